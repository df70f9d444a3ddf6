"""A daemon that runs beside a fake device, for the tests of the whole of it."""
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

from pymodbus.client import ModbusTcpClient

from ports import can_connect, free_port, wait_until

HERE = pathlib.Path(__file__).resolve().parent
PROGRAMS = {}  # "daemon", "make_network": set by the test's command line

SENSORS = "".join(f'[[sensor]]\nkey_point = "sleeve_{place}"\nregister = {2 * n}\ntype = "float32"\n'
                  for n, place in enumerate(("inner", "middle", "outer")))
BEGINNING = """
network = "small.rom"
[serve]
port = {port}
[device]
port = {device}
timeout_s = 2.0
""" + SENSORS + """[cycle]
"""  # of a configuration; places for `port` and `device`; more of [cycle] may follow
CONFIG = BEGINNING + """
clock_rate = 10.0
[signals]
speed = {{ source = "plc" }}
load = {{ source = "plc" }}
coolant = {{ source = "device", register = 6, type = "float32" }}
ambient = {{ source = "constant", value = 22.0 }}
[correction]
law = "estimator"
[history]
path = "history.csv"
parameters = "parameters.csv"
[checkpoint]
path = "twin.checkpoint"
interval_s = 5.0
"""


def int16(word):
    return word - 65536 if word > 32767 else word


def float32(first, second):
    return struct.unpack(">f", struct.pack(">HH", first, second))[0]


def run_daemon(*arguments):
    return subprocess.run([PROGRAMS["daemon"], *map(str, arguments)], capture_output=True, text=True, timeout=30)


class RunningDaemon(unittest.TestCase):
    """With a device and a daemon that run."""
    config_text = CONFIG

    def start_devices(self):
        """What the configuration names of ports, beside the daemon's own."""
        self.device_port = free_port()
        self.device = self.start([sys.executable, HERE / "fake_device.py", self.device_port], stderr=subprocess.DEVNULL)
        wait_until(lambda: can_connect(self.device_port), "the device's port")
        return {"device": self.device_port}

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        subprocess.run([PROGRAMS["make_network"], self.folder / "small.rom"], check=True)
        self.port = free_port()
        self.config = self.folder / "twin.toml"
        self.config.write_text(self.config_text.format(port=self.port, **self.start_devices()))
        self.log = open(self.folder / "log", "w+")
        self.addCleanup(self.log.close)
        self.daemon = self.start([PROGRAMS["daemon"], self.config], stderr=self.log)
        self.meet_daemon()

    def meet_daemon(self):
        """The client of all tests."""
        wait_until(lambda: can_connect(self.port), "the daemon's port")
        self.client = ModbusTcpClient("127.0.0.1", port=self.port)
        self.assertTrue(self.client.connect())
        self.addCleanup(self.client.close)

    def start(self, command, **options):
        process = subprocess.Popen(list(map(str, command)), **options)
        self.addCleanup(lambda: (process.kill(), process.wait()))
        return process

    def read(self, first, count, holding=False):
        function = self.client.read_holding_registers if holding else self.client.read_input_registers
        reply = function(first, count, slave=1)
        self.assertFalse(reply.isError(), reply)
        return reply.registers

    def wait_for_state(self, wanted):
        return wait_until(lambda: self.read(10, 1)[0] == wanted, f"state {wanted}")

    def write_signals(self):
        self.assertFalse(self.client.write_register(1000, 6000, slave=1).isError())
        self.assertFalse(self.client.write_registers(1001, [1000], slave=1).isError())

    def start_again(self):
        self.client.close()
        self.daemon = self.start([PROGRAMS["daemon"], self.config], stderr=self.log)
        wait_until(lambda: can_connect(self.port), "the daemon's port")
        self.assertTrue(self.client.connect())

    def assert_logged(self, text):
        """Lines are written by a thread of their own, so some while after what they tell."""
        wait_until(lambda: text in self.log_text(), f'"{text}" in the log', 10)

    def log_text(self):
        self.log.seek(0)
        return self.log.read()


def main(*more):
    """Takes the programs from the command line: daemon, make_network and those that the test names."""
    names = ("daemon", "make_network", *more)
    PROGRAMS.update(zip(names, map(os.path.abspath, sys.argv[1:])))
    unittest.main(argv=sys.argv[:1] + sys.argv[1 + len(names):], verbosity=2)
