#!/usr/bin/env python3
"""device_fault_test.py DAEMON MAKE_NETWORK: what a device may do wrong costs its own channels only. Two devices; the first one
answers late, for another request, with another length, with an exception, with what is no number, or is gone."""
import socket
import struct
import threading
import time

from ports import free_port, wait_until
from running_daemon import RunningDaemon, main

CONFIG = """
network = "small.rom"
[serve]
port = {port}
[[device]]
name = "troubled"
port = {troubled}
poll_s = 0.1
timeout_s = 0.3
retry_most_s = 0.4
[[device]]
name = "healthy"
port = {healthy}
poll_s = 0.1
[[sensor]]
key_point = "sleeve_inner"
device = "troubled"
register = 0
type = "float32"
stale_after_s = 1.0
[[sensor]]
key_point = "sleeve_middle"
device = "healthy"
register = 2
type = "float32"
stale_after_s = 1.0
[[sensor]]
key_point = "sleeve_outer"
device = "healthy"
register = 4
type = "float32"
stale_after_s = 1.0
[signals]
speed = {{ source = "constant", value = 6000.0 }}
load = {{ source = "constant", value = 1.0 }}
coolant = {{ source = "device", device = "healthy", register = 6, type = "float32" }}
ambient = {{ source = "constant", value = 22.0 }}
[output]
limit_um = 100.0
"""
TEMPERATURES_DEGC = (28.5, 28.25, 28.0, 21.5)
GOOD, STALE, NOT_FINITE = 0, 3, 4


class Device:
    """Modbus/TCP by hand; `change` makes something else of each answer, which is sent after `wait_s`."""

    def __init__(self):
        self.port = free_port()
        self.listener = None
        self.be_well()
        self.come()

    def be_well(self):
        self.change = lambda answer: answer
        self.wait_s = 0.0

    def come(self):
        def listen():
            try:
                return socket.create_server(("127.0.0.1", self.port))
            except OSError:
                return None
        self.listener = wait_until(listen, "the device's port")
        self.here = True
        threading.Thread(target=self.serve, args=(self.listener,), daemon=True).start()

    def go(self):
        self.here = False
        self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()

    def serve(self, listener):
        while True:
            try:
                client, _ = listener.accept()
            except OSError:
                return
            with client:
                try:
                    while self.here and len(request := client.recv(12)) == 12 and self.here:
                        first, count = struct.unpack(">HH", request[8:])
                        data = struct.pack(">4f", *TEMPERATURES_DEGC)[2 * first:2 * (first + count)]
                        answer = request[:4] + struct.pack(">H", 3 + len(data)) + request[6:8] + bytes([len(data)]) + data
                        answer = self.change(answer)
                        time.sleep(self.wait_s)
                        client.sendall(answer)
                except OSError:
                    pass


def exception(answer):
    return answer[:4] + bytes([0, 3]) + answer[6:7] + bytes([answer[7] | 0x80, 4])


def not_a_number(answer):
    return answer[:9] + struct.pack(">f", float("nan")) + answer[13:]


class DeviceFaults(RunningDaemon):
    config_text = CONFIG

    def start_devices(self):
        self.troubled, self.healthy = Device(), Device()
        return {"troubled": self.troubled.port, "healthy": self.healthy.port}

    def setUp(self):
        super().setUp()
        self.addCleanup(lambda: (self.troubled.go(), self.healthy.go()))
        self.wait_for_state(1)
        self.nose_um = self.nose()

    def nose(self):
        word = self.read(15, 1)[0]
        return (word - 65536 if word > 32767 else word) / 10

    def qualities(self):
        return self.read(88, 3)

    def counters(self, first):
        words = self.read(first, 4)
        return words[0] << 16 | words[1], words[2] << 16 | words[3]

    def assert_the_rest_goes_on(self):
        """For a second: cycles, the other device and its sensors, and a nose without a step."""
        beat, accepted = self.read(7, 1)[0], self.counters(1604)[1]
        refused = self.counters(1620)[1]
        end = time.monotonic() + 1.0
        while time.monotonic() < end:
            self.assertEqual(self.qualities()[1:], [GOOD, GOOD])
            self.assertIn(self.read(10, 1)[0], (1, 2), "running or degraded")
            self.assertEqual(self.read(1603, 1)[0] & 2, 0)
            self.assertLess(abs(self.nose() - self.nose_um), 10.0)
            time.sleep(0.05)
        self.assertNotEqual(self.read(7, 1)[0], beat)
        wait_until(lambda: self.counters(1604)[1] > accepted + 3, "answers of the healthy device")
        self.assertEqual(self.counters(1620)[1], refused)

    def assert_costs_one_sensor(self, quality, offline):
        wait_until(lambda: self.qualities()[0] == quality, f"sensor quality {quality}")
        if offline:
            wait_until(lambda: self.read(1603, 1) == [1], "the bit of the troubled device")
        self.assertEqual(self.read(10, 1), [2], "degraded")
        self.assert_the_rest_goes_on()

    def recover(self):
        self.troubled.be_well()
        self.wait_for_state(1)
        self.assertEqual(self.read(1603, 1), [0])
        self.assertEqual(self.qualities(), [GOOD] * 3)

    def test_each_fault_costs_the_devices_own_channels_only_and_passes(self):
        refused = self.counters(1620)[0]
        for name, change, wait_s, quality, offline in (
                ("late", None, 0.5, STALE, True),
                ("of another request", lambda a: bytes([a[0], a[1] ^ 1]) + a[2:], 0.0, STALE, True),
                ("of another length", lambda a: a[:4] + bytes([0, a[5] - 2]) + a[6:8] + bytes([a[8] - 2]) + a[9:-2],
                 0.0, STALE, True),
                ("with bytes too many", lambda a: a + b"\0\0", 0.0, STALE, True),
                ("an exception", exception, 0.0, STALE, False),
                ("no number", not_a_number, 0.0, NOT_FINITE, False)):
            with self.subTest(name):
                self.troubled.change = change or self.troubled.change
                self.troubled.wait_s = wait_s
                self.assert_costs_one_sensor(quality, offline)
                if quality == STALE:
                    self.assertGreater(self.counters(1620)[0], refused, "refused and counted")
                refused = self.counters(1620)[0]
                self.recover()

    def test_a_device_that_is_gone_for_a_while_comes_back(self):
        self.troubled.go()
        self.assert_costs_one_sensor(STALE, True)
        time.sleep(2.0)
        self.assert_the_rest_goes_on()
        self.troubled.come()
        self.recover()
        self.assertRegex(self.log_text(), r"device troubled at 127\.0\.0\.1:\d+ does not answer")


if __name__ == "__main__":
    main()
