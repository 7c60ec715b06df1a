"""RSIPI's robot controller (its echo server) for a counted number of answered cycles.

The loop, the telegrams and the judgement of every answer are RSIPI's own. This file only counts:
it keeps each accepted answer, sorts what RSIPI counts as faulty into answers that were late (the
computer was busy) and answers that were wrong (the board's fault), and stops.

Standard output: `cycles N` every 100 accepted answers; at the end one line of JSON:
    accepted   [[IPOC, {X..C: text}], ..] in their order
    rejected   reasons of wrong answers
    late       cycles without an answer in time
    start, end RIst before the first and after the last answer, mm and degrees
"""

import argparse
import json
import sys
import xml.etree.ElementTree as ElementTree

from RSIPI.rsi_echo_server import EchoServer

# RSIPI's reasons for which the board is to blame. The others are about lateness.
WRONG = ("malformed XML", "SENTYPE mismatch", "IPOC mismatch")
# Wrong answers after which there is nothing more to learn.
ENOUGH = 10
# Faulty packets that RSIPI accepts before it breaks off: lateness must not end a test.
BUDGET = 1_000_000


class CountingRobot(EchoServer):
    """The echo server, with a record of what it decided."""

    def __init__(self, config, mode, cycle_ms, cycles):
        super().__init__(config_file=config, delay_ms=cycle_ms, mode=mode, timeout_packets=BUDGET)
        self.cycles = cycles
        self.accepted, self.rejected, self.late = [], [], 0

    def process_reply(self, xml_string):
        accepted = super().process_reply(xml_string)
        if accepted:
            root = ElementTree.fromstring(xml_string)
            self.accepted.append([int(root.findtext("IPOC")), dict(root.find("RKorr").attrib)])
            if len(self.accepted) % 100 == 0:
                print("cycles", len(self.accepted), flush=True)
            if len(self.accepted) == self.cycles:
                self.running = False
        return accepted

    def _register_faulty_packet(self, reason, count=1):
        if reason.startswith(WRONG):
            self.rejected.append(reason)
            if len(self.rejected) == ENOUGH:
                self.running = False
        else:
            self.late += count
        super()._register_faulty_packet(reason, count)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", required=True, help="Ethernet configuration (XML)")
    parser.add_argument("--mode", choices=["relative", "absolute"], default="relative")
    parser.add_argument("--delay", type=int, default=4, help="interpolation cycle, ms")
    parser.add_argument("--cycles", type=int, required=True, help="answered cycles")
    parser.add_argument("--limit-s", type=float, default=200.0, help="give up after this time")
    arguments = parser.parse_args()

    robot = CountingRobot(arguments.config, arguments.mode, arguments.delay, arguments.cycles)
    start = dict(robot.state["RIst"])
    robot.start()
    robot.thread.join(arguments.limit_s)
    complete = len(robot.accepted) == arguments.cycles
    robot.stop()
    print(json.dumps({
        "accepted": robot.accepted,
        "rejected": robot.rejected,
        "late": robot.late,
        "start": start,
        "end": robot.state["RIst"],
    }), flush=True)
    sys.exit(0 if complete else f"rsipi: {len(robot.accepted)} of {arguments.cycles} cycles were answered")


if __name__ == "__main__":
    main()
