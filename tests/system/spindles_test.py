"""Several spindles in one daemon: each with a file, a Modbus unit and all else of its own.

spindles_test.py DAEMON MAKE_SMALL_NETWORK [unittest options]
"""
import json
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.error
import urllib.request

from pymodbus.client import ModbusTcpClient

from ports import can_connect, free_port, wait_until
from running_daemon import HERE, PROGRAMS, SENSORS, float32, int16, main, run_daemon

LIST = """
[serve]
port = {port}
[http]
port = {http}
[[spindle]]
name = "left"
unit = 1
config = "left/twin.toml"
[[spindle]]
name = "right"
unit = 2
config = "right/twin.toml"
"""
SPINDLE = """
network = "../small.rom"
[device]
port = {device}
timeout_s = 0.5
""" + SENSORS + """[cycle]
period_s = {period_s}
clock_rate = 10.0
[signals]
speed = {{ source = "plc" }}
load = {{ source = "constant", value = 0.5 }}
coolant = {{ source = "device", register = 6, type = "float32" }}
ambient = {{ source = "constant", value = 22.0 }}
[history]
path = "history.csv"
[checkpoint]
path = "twin.checkpoint"
interval_s = 5.0
"""
UNITS = {"left": 1, "right": 2}
STATE, NOSE, SPEED, TARE_COUNT, TARE = 10, 15, 34, 28, 26
RUNNING, DEGRADED = 1, 2
ORDER_RESULT, DONE = 1420, 2  # of the newest order


class Spindles(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        subprocess.run([PROGRAMS["make_network"], self.folder / "small.rom"], check=True)
        self.port, self.http = free_port(), free_port()
        self.devices = {}
        for name, period_s in (("left", 1.0), ("right", 2.0)):
            (self.folder / name).mkdir()
            device = free_port()
            self.devices[name] = self.start([sys.executable, HERE / "fake_device.py", device], stderr=subprocess.DEVNULL)
            wait_until(lambda: can_connect(device), f"the device of {name}")
            (self.folder / name / "twin.toml").write_text(SPINDLE.format(device=device, period_s=period_s))
        self.config = self.folder / "spindles.toml"
        self.config.write_text(LIST.format(port=self.port, http=self.http))
        self.log = open(self.folder / "log", "w+")
        self.addCleanup(self.log.close)
        self.client = ModbusTcpClient("127.0.0.1", port=self.port)
        self.addCleanup(self.client.close)
        self.start_daemon()

    def start(self, command, **options):
        process = subprocess.Popen(list(map(str, command)), **options)
        self.addCleanup(lambda: (process.kill(), process.wait()))
        return process

    def start_daemon(self):
        self.client.close()
        self.daemon = self.start([PROGRAMS["daemon"], self.config], stderr=self.log)
        wait_until(lambda: can_connect(self.port), "the daemon's port")
        self.assertTrue(self.client.connect())

    def read(self, name, first, count=1):
        reply = self.client.read_input_registers(first, count, slave=UNITS[name])
        self.assertFalse(reply.isError(), reply)
        return reply.registers

    def write(self, name, address, value):
        self.assertFalse(self.client.write_register(address, value, slave=UNITS[name]).isError())

    def wait_for(self, name, state):
        wait_until(lambda: self.read(name, STATE) == [state], f"state {state} of {name}")

    def run_both(self):
        self.write("left", 1000, 3000)
        self.write("right", 1000, 9000)
        for name in UNITS:
            self.wait_for(name, RUNNING)

    def get(self, path):
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{self.http}{path}", timeout=10) as answer:
                return answer.status, answer.read().decode()
        except urllib.error.HTTPError as error:
            return error.code, error.read().decode()

    def log_text(self):
        self.log.seek(0)
        return self.log.read()

    def nose_um(self, name):
        return int16(self.read(name, NOSE)[0]) / 10

    def test_each_unit_has_its_own_signals_orders_and_prediction(self):
        self.run_both()
        self.assertEqual([self.read(name, SPEED)[0] for name in UNITS], [3000, 9000])
        self.write("right", 1005, 1)
        wait_until(lambda: self.read("right", TARE_COUNT) == [1], "the tare of right")
        self.assertEqual(self.read("left", TARE_COUNT), [0])
        self.assertEqual(float32(*self.read("left", TARE, 2)), 0.0)
        self.assertLess(abs(self.nose_um("right")), 1.0)
        self.assertGreater(self.nose_um("left"), 1.0)
        for unit in (0, 3, 255):
            self.assertEqual(self.client.read_input_registers(0, 1, slave=unit).exception_code, 11)

    def test_a_device_that_is_lost_costs_its_own_spindle_only(self):
        self.run_both()
        self.devices["left"].kill()
        self.wait_for("left", DEGRADED)
        beats = self.read("right", 7)
        wait_until(lambda: self.read("right", 7) != beats, "a cycle of right")
        self.assertEqual(self.read("right", STATE), [RUNNING])
        wait_until(lambda: " left: " in self.log_text(), "a line of the log with the name of left")
        self.assertNotRegex(self.log_text(), " (warning|error) right: ")

    def test_both_go_on_where_they_were_killed(self):
        self.run_both()
        for name in UNITS:
            self.write(name, 1005, 1)
            wait_until(lambda: self.read(name, TARE_COUNT) == [1], f"the tare of {name}")
            wait_until(lambda: self.read(name, ORDER_RESULT) == [DONE], f"the tare of {name} on the disk")
            wait_until(lambda: (self.folder / name / "twin.checkpoint").exists(), f"a checkpoint of {name}")
        tares = [float32(*self.read(name, TARE, 2)) for name in UNITS]
        self.assertNotEqual(tares[0], 0.0)
        self.daemon.kill()
        self.daemon.wait()
        self.start_daemon()
        self.run_both()
        self.assertEqual([float32(*self.read(name, TARE, 2)) for name in UNITS], tares)
        self.daemon.send_signal(signal.SIGTERM)
        self.assertEqual(self.daemon.wait(20), 0)
        for name in UNITS:
            self.assertIn(f" {name}: ", self.log_text())
            rows = [row for part in (self.folder / name).glob("history*.csv") for row in part.read_text().splitlines()]
            self.assertGreater(len(rows), 4)

    def test_http_shows_each_by_its_name_and_metrics_of_all(self):
        self.run_both()
        status, body = self.get("/api/v1/spindles")
        self.assertEqual(status, 200)
        self.assertEqual([(each["name"], each["unit"], each["state"]) for each in json.loads(body)["spindles"]],
                         [("left", 1, "running"), ("right", 2, "running")])
        for name, speed in (("left", 3000), ("right", 9000)):
            status, body = self.get(f"/api/v1/spindles/{name}/state")
            self.assertEqual((status, json.loads(body)["registers"]["speed"]["value"]), (200, speed))
            self.assertEqual(self.get(f"/api/v1/spindles/{name}/healthz")[0], 200)
        for nothing in ("/api/v1/state", "/api/v1/spindles/middle/state", "/api/v1/spindles/left/", "/api/v1/events"):
            self.assertEqual(self.get(nothing)[0], 404, nothing)
        metrics = self.get("/metrics")[1]
        self.assertIn('spindle_twin_speed_revolutions_per_minute{spindle_name="left"} 3000\n', metrics)
        self.assertIn('spindle_twin_speed_revolutions_per_minute{spindle_name="right"} 9000\n', metrics)
        self.assertEqual(metrics.count("# TYPE spindle_twin_speed_revolutions_per_minute "), 1)
        with urllib.request.urlopen(f"http://127.0.0.1:{self.http}/api/v1/spindles/right/events", timeout=10) as events:
            lines = [events.readline().decode() for _ in range(3)]
        self.assertEqual(json.loads(lines[2].removeprefix("data: "))["registers"]["speed"]["value"], 9000)
        index = [line.split()[0] for line in self.get("/routes")[1].splitlines() if line.startswith("/")]
        for path in index:
            if not any(other in path for other in ("events", "history", "growth")):  # two want a history in SQLite
                self.assertNotEqual(self.get(path.replace("{NAME}", "left"))[0], 404, path)

    def test_each_has_the_hours_of_its_own_history_where_that_is_in_sqlite(self):
        self.daemon.terminate()
        self.assertEqual(self.daemon.wait(20), 0)
        own = self.folder / "right" / "twin.toml"
        own.write_text(own.read_text().replace("history.csv", "history.sqlite"))
        self.start_daemon()
        self.run_both()
        for name, status, has_history in (("left", 404, False), ("right", 200, True)):
            self.assertEqual(json.loads(self.get(f"/api/v1/spindles/{name}/scene")[1])["has_history"], has_history)
            self.assertEqual(self.get(f"/api/v1/spindles/{name}/history/1")[0], status)
        self.assertEqual(self.get("/api/v1/spindles/right/history/2")[0], 400)
        self.assertEqual(self.get("/api/v1/spindles/middle/history/1")[0], 404)
        measured = json.loads(self.get("/api/v1/spindles/right/history/1")[1])["columns"]["measured.sleeve_middle_degC"]
        self.assertEqual(measured["mean"][-1], 28.25)

    def test_a_spindle_without_readings_does_not_hold_up_the_others(self):
        self.daemon.kill()
        self.daemon.wait()
        self.devices["left"].kill()
        for name in UNITS:
            for file in (self.folder / name).glob("twin.[co]*"):
                file.unlink()
        begin = time.monotonic()
        self.start_daemon()
        self.write("right", 1000, 9000)
        self.wait_for("right", RUNNING)
        self.assertLess(time.monotonic() - begin, 10.0)
        self.assertEqual(self.read("left", STATE), [0])
        self.assertEqual(self.get("/healthz")[0], 503)
        self.assertIn("left", self.get("/healthz")[1])
        self.assertEqual(self.get("/api/v1/spindles/right/healthz")[0], 200)


class Refused(unittest.TestCase):
    def test_check_says_each_spindle_and_names_file_line_and_field_of_what_is_wrong(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            subprocess.run([PROGRAMS["make_network"], folder / "small.rom"], check=True)
            for spindle in UNITS:
                (folder / spindle).mkdir()
                (folder / spindle / "twin.toml").write_text(SPINDLE.format(device=1503, period_s=1.0))
            config = folder / "spindles.toml"
            config.write_text(LIST.format(port=1502, http=9502))
            said = run_daemon("--check", config)
            self.assertEqual(said.returncode, 0, said.stderr)
            self.assertIn("left (unit 1): ok", said.stdout)
            self.assertIn("right (unit 2): ok", said.stdout)
            wrong = folder / "right" / "twin.toml"
            wrong.write_text(wrong.read_text().replace("sleeve_outer", "sleeve_other"))
            said = run_daemon("--check", config)
            self.assertEqual(said.returncode, 1)
            self.assertRegex(said.stderr, r"right/twin\.toml:\d+: sensor\[3\]\.key_point")


if __name__ == "__main__":
    main()
