"""An EtherCAT cable in a network namespace of its own.

One end is the Ethernet interface MAIN, for a MainDevice with raw sockets; the other is a UDP socket outside of the
namespace, where the simulated segment is. Ethernet frames travel in datagrams, one in each.
"""

import ctypes
import os
import signal
import socket
import subprocess
import sys
import threading

MAIN = "sdmain"
FAR = "sdfar"
ETHERCAT = 0x88A4
# unshare(2)
CLONE_NEWNET = 0x40000000
# prctl(2): the signal with which the relay ends when its parent does.
PR_SET_PDEATHSIG = 1
# Exit status that says: this machine does not allow it.
FORBIDDEN = 77


def forbidden(what, error):
    print(f"FORBIDDEN {what}: {error}", flush=True)
    sys.exit(FORBIDDEN)


def plug():
    """Makes the cable, says where the segment is to go, and waits until it is there."""
    segment = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    segment.bind(("127.0.0.1", 0))
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.unshare(CLONE_NEWNET) != 0:
        forbidden("a network namespace (needs root)", os.strerror(ctypes.get_errno()))
    try:
        ip("link", "add", MAIN, "type", "veth", "peer", "name", FAR)
        for end in (MAIN, FAR):
            # Nobody else shall speak on it.
            ip("link", "set", end, "addrgenmode", "none")
            ip("link", "set", end, "up")
        far = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETHERCAT))
        far.bind((FAR, ETHERCAT))
    except (OSError, subprocess.CalledProcessError) as error:
        forbidden("a veth pair with raw sockets (needs iproute2)", error)
    print(f"cable 127.0.0.1:{segment.getsockname()[1]}", flush=True)
    _, there = segment.recvfrom(2048)
    # A process of its own: a MainDevice in C holds Python's lock while it waits for its frame.
    if os.fork() == 0:
        libc.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        threading.Thread(target=inwards, args=(segment, far), daemon=True).start()
        outwards(far, segment, there)


def ip(*arguments):
    subprocess.run(["ip", *arguments], check=True, capture_output=True)


def outwards(far, segment, there):
    while True:
        frame, address = far.recvfrom(2048)
        # Not what this end itself has sent.
        if address[2] != socket.PACKET_OUTGOING:
            segment.sendto(frame, there)


def inwards(segment, far):
    while True:
        frame = segment.recv(2048)
        if len(frame) >= 14:
            far.send(frame)
