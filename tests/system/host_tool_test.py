"""spindle-twin as the spindle and the commissioning engineer meet it: a description becomes a network, a network is judged
and looked at, and with a simulated spindle and the daemon becomes registers.

host_tool_test.py SPINDLE_TWIN SPINDLE_TWIND SPINDLES_FOLDER [unittest options]
"""
import csv
import json
import math
import pathlib
import re
import signal
import socket
import subprocess
import time
import unittest

from pymodbus.client import ModbusTcpClient

from host_tool_case import BUILT, COARSE, DAEMON, HOUR, MINUTE, REFERENCE, SMALL, TWIN, Case, reference_network, run
from ports import can_connect, free_port, wait_until


class Solve(Case):
    def test_reference_spindle_comes_to_its_published_state(self):
        state = self.json_of("solve", REFERENCE, "--steady")
        rise_K = state["rise_K"]
        self.assertAlmostEqual(rise_K["max"]["rotor"], 15.22, delta=0.05)
        self.assertAlmostEqual(rise_K["min"]["jacket"], 2.70, delta=0.02)
        self.assertEqual(len(rise_K["key_points"]), 3)
        self.assertAlmostEqual(max(rise_K["key_points"]), 4.96, delta=0.03)
        self.assertAlmostEqual(state["deformation_um"]["nose"], 15.46, delta=0.08)
        self.assertGreater(state["heat_in_W"], 100.0)
        self.assertAlmostEqual(state["heat_out_W"] / state["heat_in_W"], 1.0, delta=1e-9)
        self.assertEqual(set(rise_K["max"]), set(rise_K["min"]))
        self.assertEqual(len(rise_K["max"]), 22)

    def test_steady_is_the_default_and_the_table_shows_the_same(self):
        state = self.json_of("solve", REFERENCE)
        table = self.good("solve", REFERENCE, "--steady").stdout
        self.assertRegex(table, rf"(?m)^rotor +{state['rise_K']['max']['rotor']:.3f} ")
        self.assertRegex(table, rf"(?m)^nose +{state['deformation_um']['nose']:.3f} um$")

    def test_uniform_rise_stretches_the_spindle_from_its_support(self):
        self.assertAlmostEqual(self.json_of("solve", REFERENCE, "--uniform-rise-K", 1)["deformation_um"]["nose"], 2.72,
                               delta=0.01)

    def test_schedule_gives_a_series_and_fields(self):
        schedule = self.text("hour.csv", HOUR)
        fields = self.folder / "new" / "fields"
        state = self.json_of("solve", COARSE, "--schedule", schedule, "--output-period", 60, "--vtu", fields)
        series = state["series"]
        self.assertEqual(series["time_s"], [60.0 * n for n in range(16)])
        self.assertLess(max(map(abs, series["key_points_K"][0])), 1e-9)
        self.assertEqual(series["key_points_K"][-1], state["rise_K"]["key_points"])
        self.assertEqual(len(series["part_max_K"]["rotor"]), 16)
        self.assertEqual(series["deformation_um"]["nose"][-1], state["deformation_um"]["nose"])
        self.assertTrue((fields / "coarse.vtu").read_text(errors="replace").lstrip().startswith("<?xml"))
        rows = list(csv.DictReader(self.good("solve", COARSE, "--schedule", schedule, "--output-period", 60)
                                   .stdout.splitlines()))
        self.assertEqual([float(row["time_s"]) for row in rows], series["time_s"])
        self.assertAlmostEqual(float(rows[-1]["nose_um"]), state["deformation_um"]["nose"], delta=1e-4)
        # The default's steps leave less than 1e-5 of the span at 60 s, beside steps a thousand times finer.
        fine = self.json_of("solve", COARSE, "--schedule", self.text("minute.csv", MINUTE),
                            "--output-period", 60, "--step-tolerance-K", 1e-7)
        span = max(max(values) for values in series["part_max_K"].values())
        for part, values in fine["series"]["part_max_K"].items():
            self.assertAlmostEqual(series["part_max_K"][part][1], values[1], delta=1e-5 * span, msg=part)
        # One form per quantity: the columns of `simulate`, and degC where the JSON has rises.
        simulated = self.folder / "columns.csv"
        self.good("simulate", reference_network()["rom"], "--schedule", schedule, "-o", simulated)
        with simulated.open() as file:
            names = next(csv.reader(file))
        self.assertEqual([name for name in rows[0] if not name.endswith("_W")],
                         [name for name in names if not name.endswith("_W")])
        first = next(name for name in names if name.endswith("_degC"))
        self.assertAlmostEqual(float(rows[-1][first]) - float(rows[0][first]), series["key_points_K"][-1][0], delta=2e-4)


class Tolerance(Case):
    def test_the_nearest_network_is_written_where_none_is_small_enough_and_says_what_misses(self):
        rom = self.folder / "sleeve.rom"
        result = run("build", SMALL, "-o", rom, "--tolerance", "1K,1e-14um", "--certificate-cases", 1, "--json")
        self.assertEqual(result.returncode, 3, result.stderr)
        said = json.loads(result.stdout)
        self.assertEqual(said["tolerance"]["kept"], False)
        self.assertIn(said["nodes"], [size["nodes"] for size in said["sizes_tried"]])
        self.assertEqual([missed["output"] for missed in said["tolerance"]["missed"]], ["deformation outer_growth"])
        self.assertRegex(result.stderr, r"deformation outer_growth +errs by \S+ um")
        offered = re.search(r"--tolerance (\S+),", result.stderr)[1]
        self.good("build", SMALL, "-o", self.folder / "again.rom", "--tolerance", offered, "--certificate-cases", 1)
        self.good("simulate", rom, "--schedule", self.text("hour.csv", "time_s,speed_rpm,load\n0,0,1\n60,0,1\n"), "-o",
                  self.folder / "run.csv")


class Network(Case):
    def setUp(self):
        super().setUp()
        built = reference_network()
        self.rom, self.built = built["rom"], built["said"]

    def assert_within_limits(self, errors):
        self.assertLessEqual(errors["key_points_K"], 0.2)
        self.assertLessEqual(errors["nose_um"], 0.1)
        self.assertLessEqual(errors["part_max_K"], 1.0)

    def test_build_reports_what_it_wrote(self):
        self.assertEqual(BUILT["files"], ["reference.rom"])
        self.assertLessEqual(self.built["nodes"], 200)
        certificate = self.built["certificate"]
        self.assert_within_limits(certificate["worst"])
        self.assertEqual(certificate["box"], {"contacts": [0.1, 10.0], "films": [0.2, 5.0], "speed_high_rpm": 24000.0})
        self.assertEqual(certificate["mesh"], {"element_size_mm": 8.0, "fe_unknowns": self.built["fe_unknowns"]})
        for group, names in (("key_points_K", 3), ("part_mean_K", 22), ("part_max_K", 22), ("contact_pressures_MPa", 6)):
            self.assertEqual(len(certificate["outputs"][group]), names)
            for name, error in certificate["outputs"][group].items():
                self.assertLessEqual(error["median"], error["worst"], name)
                self.assertGreater(error["mesh"], 0.0, name)
        stages = self.built["stages_s"]
        for stage in ("FE model", "FE snapshots", "network snapshots", "verification", "mesh error"):
            self.assertGreater(stages[stage], 0.0)
        for line in BUILT["progress"].splitlines():
            self.assertRegex(line, r"^[A-Za-z ]+: (done|\d+ %(, about \d+ (s|min) left)?)$")

    def test_verify_takes_cases_of_its_own_and_says_where_it_does_not(self):
        rom = self.folder / "small.rom"
        self.good("build", SMALL, "-o", rom, "--nodes", 12, "--certificate-cases", 10, "--seed", 5)
        asked = [self.good("verify", rom, SMALL, "--cases", 2, *seed).stdout
                 for seed in ((), ("--seed", 6), ("--seed", 5))]
        self.assertEqual(asked[0], asked[1])
        self.assertNotIn("the certificate's own cases", asked[0])
        self.assertIn("the certificate's own cases", asked[2])

    def test_verify_stays_within_the_limits_for_any_seed(self):
        for seed in (11, 2026):
            report = self.json_of("verify", self.rom, COARSE, "--cases", 2, "--seed", seed)
            self.assertEqual((report["cases"], report["seed"], report["nodes"]), (2, seed, self.built["nodes"]))
            for which in ("worst", "median"):
                self.assert_within_limits(report[which])
                self.assertGreater(report[which]["key_points_K"], 0.0)
            self.assertLessEqual(report["median"]["nose_um"], report["worst"]["nose_um"])
            self.assertTrue(report["checks"]["passed"], report["checks"])
            self.assertLess(report["checks"]["heat_balance"], 1e-9)
            self.assertEqual(set(report["outputs"]["deformations_um"]["nose"]), {"worst", "median"})

    def test_verify_while_contacts_and_films_drift(self):
        report = self.json_of("verify", self.rom, COARSE, "--cases", 1, "--seed", 11, "--drift")
        self.assert_within_limits(report["worst"])

    def test_verify_against_another_description_is_refused(self):
        other = self.text("other.toml", COARSE.read_text() + "\n# changed\n")
        self.assertRegex(self.error_of("verify", self.rom, other),
                         rf"^spindle-twin: {self.rom}: description_hash: was built from another description than {other} ")

    def test_inspect_shows_what_is_in_the_file(self):
        seen = self.json_of("inspect", self.rom)
        self.assertEqual(len(seen["nodes"]), self.built["nodes"])
        self.assertEqual([point["name"] for point in seen["key_points"]], ["inner", "middle", "outer"])
        self.assertEqual(len(seen["parts"]), 22)
        self.assertEqual(seen["certificate"], self.built["certificate"])
        nose = next(entry for entry in seen["deformations"] if entry["name"] == "nose")
        self.assertAlmostEqual(nose["um_per_K"], 2.72, delta=0.01)
        self.assertLess(seen["checks"]["conduction_row_sum"], 1e-9)
        table = self.good("inspect", self.rom).stdout
        self.assertIn(f"network      {self.built['nodes']} nodes", table)
        self.assertIn("Certificate: 3 random cases", table)
        self.assertIn("A single one may be below zero", table)
        rows = re.findall(r"(?m)^(front_cover@\S+) +front_cover +\S+ +\S+ +(-?[\d.]+)$", table)
        self.assertGreater(len(rows), 1)
        volume_m3 = math.pi * ((0.080 ** 2 - 0.044 ** 2) * 0.022 + (0.0475 ** 2 - 0.043 ** 2) * 0.005)
        self.assertAlmostEqual(sum(float(row[1]) for row in rows), 7830 * 450 * volume_m3, delta=0.1)

    def test_page_of_inspect_closes_its_balances_and_has_the_numbers_of_the_json(self):
        page = self.folder / "page.html"
        seen = self.json_of("inspect", self.rom, "--html", page)
        text = page.read_text()
        self.assertNotRegex(text, r'(src|href)="?https?:')
        mark = '<script id="data" type="application/json">'
        start = text.index(mark) + len(mark)
        data = json.JSONDecoder().raw_decode(text, start)[0]
        heat_in = sum(source["heat_W"] for source in data["sources"])
        self.assertAlmostEqual(heat_in, sum(source["operating_W"] for source in seen["sources"]), delta=1e-9)
        self.assertAlmostEqual(heat_in, sum(b["source_W"] for b in data["balance"]), delta=1e-9 * heat_in)
        self.assertAlmostEqual(heat_in, sum(f["heat_W"] for f in data["flows"] if f["outside"]), delta=1e-9 * heat_in)
        for body in data["balance"]:
            self.assertLess(abs(body["residue_W"]), 1e-9 * heat_in, body["name"])
            self.assertLess(abs(body["conduction_W"]), 1e-9 * heat_in, "heat that leaks past the contacts of " + body["name"])
            given = sum(f["heat_W"] for f in data["flows"] if f["from"] == body["name"])
            taken = sum(f["heat_W"] for f in data["flows"] if f["to"] == body["name"])
            self.assertAlmostEqual(body["source_W"] + taken, given, delta=1e-8 * heat_in, msg=body["name"])
        for mode, time_constant_s in zip(data["modes"], seen["time_constants_s"]):
            self.assertAlmostEqual(mode["time_constant_s"] / time_constant_s, 1.0, delta=1e-9)
        self.assertEqual([node["name"] for node in data["nodes"]], [node["name"] for node in seen["nodes"]])
        self.assertEqual(len({outline["part"] for outline in data["outlines"]}), 22)
        self.assertEqual(data["certificate"]["cases"], seen["certificate"]["cases"])
        for point in seen["steady_state"]["key_points"]:
            self.assertAlmostEqual(point["degC"] - seen["steady_state"]["rest_degC"], point["rise_K"], delta=1e-9)
        nose = seen["steady_state"]["deformations"][0]
        self.assertAlmostEqual(data["warm_up"]["deformations"][0]["um"][-1] / nose["um"], 1.0, delta=0.02)  # exp(-5)

    def test_simulate_follows_the_fe_model(self):
        schedule = self.text("hour.csv", HOUR)
        out = self.folder / "out.csv"
        result = self.good("simulate", self.rom, "--schedule", schedule, "-o", out, "--every", 60)
        self.assertEqual(result.stderr, "")
        rows = list(csv.DictReader(out.read_text().splitlines()))
        self.assertEqual([float(row["time_s"]) for row in rows], [60.0 * n for n in range(16)])
        state = self.json_of("solve", COARSE, "--schedule", schedule)
        for name, rise_K in zip(("inner", "middle", "outer"), state["rise_K"]["key_points"]):
            self.assertAlmostEqual(float(rows[-1][f"{name}_degC"]) - 27.0, rise_K, delta=0.1)
        self.assertAlmostEqual(float(rows[-1]["nose_um"]), state["deformation_um"]["nose"], delta=0.1)

    def test_a_bad_schedule_is_one_line_with_file_line_and_column(self):
        out = self.folder / "out.csv"
        for name, text, line, what in (
                ("column", "time_s,speed_rpm,load,oil_degC\n0,1,1,1\n1,1,1,1\n", 1, "oil_degC: unknown column; allowed: time_s"),
                ("missing", "time_s,load\n0,1\n1,1\n", 1, "speed_rpm: missing column"),
                ("cell", "time_s,speed_rpm,load\n0,fast,1\n9,1,1\n", 2, "speed_rpm: 'fast' is not a finite number"),
                ("nan", "time_s,speed_rpm,load\n0,1,1\n9,1,nan\n", 3, "load: 'nan' is not a finite number"),
                ("order", "time_s,speed_rpm,load\n0,1,1\n0,1,1\n", 3, "time_s: times must rise"),
                ("short", "time_s,speed_rpm,load\n0,1,1\n9,1\n", 3, "2 values, but the header names 3 columns"),
                ("start", "time_s,speed_rpm,load\n5,1,1\n9,1,1\n", 2, "time_s: the first row must be at time 0")):
            schedule = self.text(name + ".csv", text)
            for command in (("simulate", self.rom, "-o", out), ("solve", SMALL)):
                if name == "column" and command[0] == "solve":
                    continue  # its surroundings have other names
                with self.subTest(name, command=command[0]):
                    self.assertIn(f"spindle-twin: {schedule}:{line}: {what}", self.error_of(*command, "--schedule", schedule))
        self.assertIn(f"{self.folder}/none.csv: cannot be opened for reading",
                      self.error_of("simulate", self.rom, "-o", out, "--schedule", self.folder / "none.csv"))

    def test_a_damaged_network_is_one_line(self):
        data = bytearray(self.rom.read_bytes())
        data[len(data) // 2] ^= 1
        damaged = self.folder / "damaged.rom"
        damaged.write_bytes(data)
        cut = self.folder / "cut.rom"
        cut.write_bytes(data[:1000])
        empty = self.folder / "empty.rom"
        empty.write_bytes(b"")
        schedule = self.text("hour.csv", HOUR)
        for path in (damaged, cut, empty, REFERENCE, self.folder, self.folder / "none.rom"):
            for command in (["inspect", path], ["verify", path, REFERENCE],
                            ["simulate", path, "--schedule", schedule, "-o", self.folder / "out.csv"],
                            ["report", path, "--history", schedule, "--plant", schedule, "--table"]):
                with self.subTest(path.name, command=command[0]):
                    self.assertTrue(self.error_of(*command).startswith(f"spindle-twin: {path}: "))

    def test_an_output_that_cannot_be_written_is_refused_before_the_work(self):
        schedule = self.text("hour.csv", HOUR)
        no_file = self.folder / "socket"  # of our own: a tool with a fault must not replace a device of the machine
        with socket.socket(socket.AF_UNIX) as bound:
            bound.bind(str(no_file))
        for output in (self.folder / "none" / "x", self.folder, pathlib.Path("/proc/x"), no_file):
            for command in (["build", REFERENCE], ["simulate", self.rom, "--schedule", schedule]):
                with self.subTest(str(output), command=command[0]):
                    self.assertIn(f"{output}: --output: cannot be written: ", self.error_of(*command, "-o", output))
        blocked = self.text("blocked", "")
        self.assertIn("--vtu: no folder can be made", self.error_of("solve", SMALL, "--vtu", blocked / "fields"))

    def test_report_on_truncated_logs(self):
        history = self.folder / "history.csv"
        plant = self.folder / "plant.csv"
        arguments = ["report", self.rom, "--history", history, "--plant", plant, "--table"]
        self.assertIn(f"{history}: cannot be opened for reading", self.error_of(*arguments))
        history.write_text("")
        plant.write_text("time_s\n0\n1\n")
        self.assertIn(f"{history}: empty; a header", self.error_of(*arguments))
        history.write_text("model_time_s,nose_um\n")
        self.assertIn(f"{history}: holds no row", self.error_of(*arguments))
        history.write_text("model_time_s,nose_um\n0,1\n1\n2,1\n")
        self.assertIn(f"{history}:3: 1 values, but the header names 2 columns", self.error_of(*arguments))
        history.write_text("model_time_s,nose_um\n0,1\n1,x\n")
        self.assertIn(f"{history}:3: nose_um: 'x' is not a finite number", self.error_of(*arguments))
        history.write_text("time_s,nose_um\n0,1\n1,1\n")
        self.assertRegex(self.error_of(*arguments), rf"{history}:1: \S+: missing column")


class Interrupted(Case):
    def test_an_interrupted_build_leaves_the_old_file_and_nothing_else(self):
        output = self.text("x.rom", "the old one")
        build = subprocess.Popen([TWIN, "build", REFERENCE, "-o", output], stderr=subprocess.PIPE, text=True)
        self.addCleanup(lambda: (build.kill(), build.wait(), build.stderr.close()))
        self.assertEqual(build.stderr.readline(), "FE model: done\n")
        build.send_signal(signal.SIGINT)
        self.assertEqual(build.wait(30), -signal.SIGINT)
        self.assertEqual([path.name for path in self.folder.iterdir()], ["x.rom"])
        self.assertEqual(output.read_text(), "the old one")


CONFIG = """
network = "{rom}"
[cycle]
clock_rate = 60.0
[serve]
port = {port}
[device]
port = {device}
poll_s = 0.6
[[sensor]]
key_point = "inner"
register = 8
scale = 0.01
stale_after_s = 60.0
[[sensor]]
key_point = "middle"
register = 9
scale = 0.01
stale_after_s = 60.0
[[sensor]]
key_point = "outer"
register = 10
scale = 0.01
stale_after_s = 60.0
[signals]
speed = {{ source = "device", register = 4, type = "uint16", stale_after_s = 60.0 }}
load = {{ source = "device", register = 5, scale = 0.001, stale_after_s = 60.0 }}
coolant = {{ source = "device", register = 6, scale = 0.01, stale_after_s = 60.0 }}
ambient = {{ source = "device", register = 7, scale = 0.01, stale_after_s = 60.0 }}
[correction]
law = "paper"
"""


class EndToEnd(Case):
    def start(self, *command):
        log = open(self.folder / "log", "a")
        process = subprocess.Popen(list(map(str, command)), stdout=log, stderr=log)
        self.addCleanup(lambda: (process.kill(), process.wait(), log.close()))
        return process

    def connected(self, port):
        wait_until(lambda: can_connect(port), f"port {port}")
        client = ModbusTcpClient("127.0.0.1", port=port)
        self.addCleanup(client.close)
        self.assertTrue(client.connect())
        return client

    def read(self, client, first, count):
        reply = client.read_input_registers(first, count, slave=1)
        self.assertFalse(reply.isError(), reply)
        return [word - 65536 if word > 32767 else word for word in reply.registers]

    def mbpoll(self, port, first, count):
        command = ["mbpoll", "-m", "tcp", "-1", "-0", "-q", "-t", "3", "-r", first, "-c", count, "-p", port, "127.0.0.1"]
        result = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=20)
        self.assertEqual(result.returncode, 0, result.stdout)
        words = [int(word) for word in re.findall(r"(?m)^\[\d+\]:\s+(\d+)", result.stdout)]
        return [word - 65536 if word > 32767 else word for word in words]

    def test_what_the_plant_measures_comes_out_of_the_twin_for_both_clients(self):
        plant_port, port = free_port(), free_port()
        config = self.text("twin.toml", CONFIG.format(rom=reference_network()["rom"], port=port, device=plant_port))
        plant_process = self.start(TWIN, "plant", COARSE, "--port", plant_port, "--rate", 60, "--wait-for-client")
        wait_until(lambda: "serving" in (self.folder / "log").read_text(), "the plant's start")
        daemon_process = self.start(DAEMON, config)
        twin = self.connected(port)
        plant = self.connected(plant_port)
        wait_until(lambda: self.read(twin, 32, 2)[1] >= 240, "240 s of model time")
        wait_until(lambda: self.read(twin, 10, 1) == [1], "the state running")

        before = self.read(plant, 8, 3)
        time.sleep(0.3)  # what the device showed then has passed through the twin by now
        first = self.read(twin, 0, 80)
        polled = self.mbpoll(port, 0, 80)
        last = self.read(twin, 0, 80)
        time.sleep(0.05)
        after = self.read(plant, 8, 3)

        self.assertEqual(first[34:38], [6000, 1000, 2700, 2700])
        self.assertEqual(polled[34:38], first[34:38])
        self.assertGreater(min(before), 2700 + 30, "nothing has warmed up; the comparison would say nothing")
        # The spindle only gets warmer, so that each reading lies between the ones before and after it; 0.01 degC, 0.1 um.
        for k in range(3):
            self.assertLessEqual(before[k], first[40 + k])
            self.assertLessEqual(last[40 + k], after[k])
        for offset in (7, 15, 32, 33, 40, 41, 42, 72, 73, 74):
            self.assertLessEqual(first[offset], polled[offset], offset)
            self.assertLessEqual(polled[offset], last[offset], offset)
        # This plant is as described, so that network and FE model must come to the same.
        for k in range(3):
            self.assertAlmostEqual(polled[56 + k] / 100, (before[k] + after[k]) / 200, delta=0.2)
        for process in (daemon_process, plant_process):
            process.send_signal(signal.SIGTERM)
            self.assertEqual(process.wait(20), 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
