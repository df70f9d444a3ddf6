#!/usr/bin/env python3
"""stream_test.py DAEMON MAKE_NETWORK NODE: the example node feeds the twin over the stream. Between them stands a line that
flips a bit, cuts or doubles frames; these are refused and counted, and the twin goes on."""
import socket
import struct
import subprocess
import threading

from ports import free_port, wait_until
from running_daemon import PROGRAMS, RunningDaemon, main

SENSORS = "".join(f'[[sensor]]\nkey_point = "sleeve_{place}"\nchannel = {n}\n'
                  for n, place in enumerate(("inner", "middle", "outer")))
CONFIG = """
network = "small.rom"
[serve]
port = {port}
[[device]]
name = "node"
driver = "stream"
port = {stream}
idle_s = 2.0
{sensors}[signals]
speed = {{ source = "constant", value = 6000.0 }}
load = {{ source = "device", channel = 10, mean_s = 0.5 }}
coolant = {{ source = "device", channel = 3 }}
ambient = {{ source = "constant", value = 22.0 }}
""".replace("{sensors}", SENSORS)
HEADER, CRC = 10, 4
LOAD, MEASURED, ACCEPTED, REFUSED, OFFLINE = 35, 40, 1604, 1620, 1603


class Line:
    """Hands a node's frames on to the daemon; `spoil` makes something else of each."""

    def __init__(self, daemon_port):
        self.daemon_port = daemon_port
        self.spoil = lambda frame: frame
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self):
        while True:
            try:
                node, _ = self.listener.accept()
                with node, socket.create_connection(("127.0.0.1", self.daemon_port)) as daemon:
                    while frame := self.frame(node):
                        daemon.sendall(self.spoil(frame))
            except OSError:
                if self.listener.fileno() < 0:
                    return

    @staticmethod
    def frame(node):
        def take(count):
            data = b""
            while len(data) < count and (more := node.recv(count - len(data))):
                data += more
            return data
        header = take(HEADER)
        return header + take(struct.unpack(">H", header[4:6])[0] + CRC) if len(header) == HEADER else b""

    def spoil_next(self, change):
        """Once; the event is set when it is done."""
        done = threading.Event()

        def once(frame):
            self.spoil = lambda other: other
            done.set()
            return change(frame)
        self.spoil = once
        return done


class Stream(RunningDaemon):
    config_text = CONFIG

    def start_devices(self):
        self.stream_port = free_port()
        return {"stream": self.stream_port}

    def setUp(self):
        super().setUp()
        self.line = Line(self.stream_port)
        self.addCleanup(self.line.listener.close)
        self.node = self.start_node()
        self.wait_for_state(1)

    def start_node(self):
        return self.start([PROGRAMS["node"], "127.0.0.1", self.line.port], stderr=subprocess.DEVNULL)

    def counter(self, address):
        high, low = self.read(address, 2)
        return high << 16 | low

    def wait_for_more(self, address, than):
        return wait_until(lambda: self.counter(address) > than and self.counter(address), "frames that are taken")

    def assert_measured(self):
        self.assertEqual(self.read(MEASURED, 3), [2850, 2825, 2800])

    def test_the_node_feeds_sensors_and_signals_and_fast_values_come_as_their_mean(self):
        self.assert_measured()
        wait_until(lambda: self.counter(ACCEPTED) > 20, "frames")
        self.assertEqual(self.counter(REFUSED), 0)
        load, coolant = self.read(LOAD, 2)
        self.assertLessEqual(abs(load - 1000), 3, "0.5 and 1.5 in turn at 1 kHz are a load of 1, to one value of 500")
        self.assertEqual(coolant, 2150)

    def test_flipped_cut_and_doubled_frames_are_refused_and_counted_and_the_twin_goes_on(self):
        refused = 0
        for place in (0, 3, 5, 8, HEADER, HEADER + 20, -1):
            def flip(frame):
                at = place % len(frame)
                return frame[:at] + bytes([frame[at] ^ 1]) + frame[at + 1:]
            self.assertTrue(self.line.spoil_next(flip).wait(10))
            refused += 1
            wait_until(lambda: self.counter(REFUSED) == refused, f"refusal of a flipped bit at {place}")
        for left in (1, HEADER, 100, -1):
            self.assertTrue(self.line.spoil_next(lambda frame: frame[:left]).wait(10))
            refused += 1
            wait_until(lambda: self.counter(REFUSED) == refused, f"refusal of a frame cut to {left}")
        self.assertTrue(self.line.spoil_next(lambda frame: 2 * frame).wait(10))
        refused += 1
        wait_until(lambda: self.counter(REFUSED) == refused, "refusal of a doubled frame")
        self.wait_for_more(ACCEPTED, self.counter(ACCEPTED) + 10)
        self.assertEqual(self.counter(REFUSED), refused)
        self.assertEqual(self.read(10, 1), [1], "running")
        self.assert_measured()

    def test_a_node_that_is_gone_is_offline_and_comes_back(self):
        self.node.kill()
        wait_until(lambda: self.read(OFFLINE, 1) == [1], "the bit of the device")
        self.assertTrue(self.read(11, 1)[0] & 0x100)
        self.wait_for_state(2)
        self.node = self.start_node()
        self.wait_for_state(1)
        self.assertEqual(self.read(OFFLINE, 1), [0])
        self.assertEqual(self.read(1602, 1), [1])
        self.assert_measured()


if __name__ == "__main__":
    main("node")
