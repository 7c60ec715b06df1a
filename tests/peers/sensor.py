"""An ATI NETCANOEM force/torque sensor on python-can's SLCAN client, or behind an SLCAN adapter.

Written from ATI document 9610-05-1030 and with `struct`, so that it shares no code with the firmware
that it is tested against. With --channel it connects to the board's SLCAN port over TCP; with --adapter
it is behind an adapter that the board opens, a TCP server or a serial device. It answers until the board
goes or standard input ends.

Standard input, one command per line:
    drop                      with --adapter tcp: the client is disconnected, the channel closed
    force FX FY FZ REQUESTS   the next REQUESTS readings show this force (N), then none again
Standard output:
    ready                     connected, the channel is open
    adapter PLACE             with --adapter, before anybody has come: what the board is to open
    opened, closed            with --adapter: the channel
    wrench FX FY FZ TX TY TZ  what the readings of a `force` show, N and N m, after rounding to counts
    released READINGS         the force is gone again
"""

import argparse
import os
import pty
import queue
import select
import socket
import struct
import sys
import threading
import tty

import can

# Opcodes of requests; an identifier is (base << 4) | opcode.
GAUGES, MATRIX_ROW, SERIAL_NUMBER, COUNTS_PER_UNIT, UNIT_CODES, RESET, FIRMWARE = (
    0x0, 0x2, 0x5, 0x7, 0x8, 0xC, 0xF)

# The sensor's registers: force in lbf (code 1), torque in lbf-in (code 1).
COUNTS_PER_FORCE, COUNTS_PER_TORQUE = 1000, 500
POUND_FORCE_CODE, POUND_FORCE_INCH_CODE = 1, 1
POUND_FORCE_N = 4.4482216152605
POUND_FORCE_INCH_N_M = 0.1129848290276167

# Calibration matrix with coupling between the axes, exact in single precision. It is triangular, so
# that the gauges of a wrench follow by substitution.
MATRIX = [
    [1.25, 0.0, 0.0, 0.0, 0.0, 0.0],
    [0.125, -1.5, 0.0, 0.0, 0.0, 0.0],
    [-0.0625, 0.25, 2.0, 0.0, 0.0, 0.0],
    [0.5, 0.0, -0.125, 1.0, 0.0, 0.0],
    [0.0, 0.375, 0.0, 0.25, -1.75, 0.0],
    [0.25, 0.0, 0.5, 0.0, 0.125, 1.5],
]


def gauges_of(force_n):
    """Gauge counts of a pure force (N), rounded as the sensor's converter does."""
    counts = [f / POUND_FORCE_N * COUNTS_PER_FORCE for f in force_n] + [0.0] * 3
    gauges = []
    for row, wanted in zip(MATRIX, counts):
        known = sum(m * g for m, g in zip(row, gauges))
        gauges.append(round((wanted - known) / row[len(gauges)]))
    return gauges


def wrench_of(gauges):
    """Wrench (N, N m) that gauge counts stand for."""
    counts = [sum(m * g for m, g in zip(row, gauges)) for row in MATRIX]
    forces = [c / COUNTS_PER_FORCE * POUND_FORCE_N for c in counts[:3]]
    torques = [c / COUNTS_PER_TORQUE * POUND_FORCE_INCH_N_M for c in counts[3:]]
    return forces + torques


class Sensor:
    """The device: requests in, frames out."""

    def __init__(self, base):
        self.base = base
        self.readings = 0
        self.forces = queue.Queue()
        self.shown = [0] * 6
        self.left = 0
        self.dropped = threading.Event()

    def answers(self, message):
        """Data of the answers to a request, each with its opcode."""
        opcode, data = message.arbitration_id & 0xF, bytes(message.data)
        if message.is_extended_id or message.is_remote_frame or message.arbitration_id >> 4 != self.base:
            return []
        if opcode == GAUGES and not data:
            gauges = self.reading()
            return [(0x0, struct.pack(">Hhhh", 0, *gauges[0::2])), (0x1, struct.pack(">hhh", *gauges[1::2]))]
        if opcode == MATRIX_ROW and len(data) == 1 and data[0] < 6:
            row = MATRIX[data[0]]
            return [(0x2 + part, struct.pack(">ff", *row[2 * part:2 * part + 2])) for part in range(3)]
        fixed = {
            SERIAL_NUMBER: b"FT023456",
            COUNTS_PER_UNIT: struct.pack(">II", COUNTS_PER_FORCE, COUNTS_PER_TORQUE),
            UNIT_CODES: struct.pack(">BB", POUND_FORCE_CODE, POUND_FORCE_INCH_CODE),
            FIRMWARE: struct.pack(">BBH", 2, 1, 7),
        }
        return [(opcode, fixed[opcode])] if opcode in fixed and not data else []

    def reading(self):
        """Gauges of the next reading. One count of gauge 0 flickers, as in every real converter."""
        if self.left == 0 and not self.forces.empty():
            force, self.left = self.forces.get()
            self.shown = gauges_of(force)
            say("wrench", *wrench_of(self.shown))
        self.readings += 1
        if self.left > 0:
            self.left -= 1
            gauges = self.shown
            if self.left == 0:
                say("released", self.readings)
            return gauges
        return [self.readings % 2] + [0] * 5


def say(*words):
    print(*words, flush=True)


def read_commands(sensor, ended):
    for line in sys.stdin:
        word, *numbers = line.split()
        if word == "drop" and not numbers:
            sensor.dropped.set()
            continue
        if word != "force" or len(numbers) != 4:
            sys.exit(f"sensor: expected `force FX FY FZ REQUESTS`, received `{line.strip()}`")
        sensor.forces.put(([float(n) for n in numbers[:3]], int(numbers[3])))
    ended.set()


def serve(sensor, bus, ended):
    while not ended.is_set():
        message = bus.recv(timeout=0.1)
        for opcode, data in sensor.answers(message) if message else []:
            identifier = sensor.base << 4 | opcode
            bus.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))


class Adapter:
    """A strict SLCAN adapter, from Lawicel's CANUSB manual: nothing but what the manual allows in a state.

    The bus behind it is python-can's virtual one.
    """

    def __init__(self, stream, bus):
        self.stream, self.bus = stream, bus
        self.bit_rate, self.open = None, False

    def serve(self, ended):
        """Until the client goes."""
        line = b""
        while not ended.is_set():
            received = self.stream.read(512)
            if received is None:
                return
            *lines, line = (line + received).split(b"\r")
            for ended_line in lines:
                self.stream.write(self.reply(ended_line.decode("latin-1")))
            if self.open:
                self.pass_on()

    def pass_on(self):
        message = self.bus.recv(timeout=0)
        while message:
            data = message.data.hex().upper()
            self.stream.write(f"t{message.arbitration_id:03X}{message.dlc}{data}\r".encode())
            message = self.bus.recv(timeout=0)

    def reply(self, line):
        if line == "":
            return b"\r"
        if line == "C" and self.open:
            self.open = False
            say("closed")
            return b"\r"
        if line == "S8" and not self.open:
            self.bit_rate = 1_000_000
            return b"\r"
        if line == "O" and not self.open and self.bit_rate:
            self.open = True
            say("opened")
            return b"\r"
        if line.startswith("t") and self.open and len(line) == 5 + 2 * int(line[4]):
            data = bytes.fromhex(line[5:])
            self.bus.send(can.Message(arbitration_id=int(line[1:4], 16), data=data, is_extended_id=False))
            return b"z\r"
        return b"\x07"


class TcpStream:
    """One client after the other; `read` gives nothing when nothing came, None when the client has gone."""

    def __init__(self, server, dropped):
        self.socket, _ = server.accept()
        self.dropped = dropped
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket.settimeout(0.001)

    def read(self, length):
        if self.dropped.is_set():
            self.dropped.clear()
            self.socket.close()
            return None
        try:
            return self.socket.recv(length) or None
        except TimeoutError:
            return b""
        except OSError:
            return None

    def write(self, data):
        try:
            self.socket.sendall(data)
        except OSError:
            pass


class SerialStream:
    """The adapter's end of a pseudo-terminal; while the far end is open here as well, clients come and go."""

    def __init__(self, descriptor):
        self.descriptor = descriptor

    def read(self, length):
        ready, _, _ = select.select([self.descriptor], [], [], 0.001)
        return os.read(self.descriptor, length) if ready else b""

    def write(self, data):
        os.write(self.descriptor, data)


def be_adapter(kind, bus, dropped, ended):
    """Serves whoever opens it."""
    if kind == "serial":
        near, far = pty.openpty()
        tty.setraw(far)
        say("adapter", os.ttyname(far))
        Adapter(SerialStream(near), bus).serve(ended)
        return
    with socket.create_server(("127.0.0.1", 0)) as server:
        say("adapter", f"tcp:127.0.0.1:{server.getsockname()[1]}")
        while not ended.is_set():
            Adapter(TcpStream(server, dropped), bus).serve(ended)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    side = parser.add_mutually_exclusive_group(required=True)
    side.add_argument("--channel", help="python-can channel, such as socket://127.0.0.1:29536")
    side.add_argument("--adapter", choices=["tcp", "serial"], help="be an adapter that the board opens")
    parser.add_argument("--base", type=lambda text: int(text, 0), default=0x20, help="identifier base, 7 bits")
    arguments = parser.parse_args()

    sensor, ended = Sensor(arguments.base), threading.Event()
    threading.Thread(target=read_commands, args=(sensor, ended), daemon=True).start()
    if arguments.adapter:
        with can.Bus(interface="virtual", channel="rig") as near, can.Bus(interface="virtual", channel="rig") as far:
            threading.Thread(target=serve, args=(sensor, far, ended), daemon=True).start()
            be_adapter(arguments.adapter, near, sensor.dropped, ended)
        return
    try:
        # The open sequence is python-can's own: C, S8, an empty line, O, O.
        with can.Bus(interface="slcan", channel=arguments.channel, bitrate=1_000_000, sleep_after_open=0) as bus:
            say("ready")
            serve(sensor, bus, ended)
    except can.CanError as error:
        sys.exit(f"sensor: the board has gone: {error}")


if __name__ == "__main__":
    main()
