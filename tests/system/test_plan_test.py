"""A test is proposed for a network: its schedule runs, its numbers hold together, nothing turns that a sensor is put on.

test_plan_test.py MAKE_SMALL_NETWORK SPINDLE_TWIN [unittest options]
"""
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAMS = {}


class TestPlan(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        self.rom = self.folder / "small.rom"
        subprocess.run([PROGRAMS["network"], self.rom, "outlined"], check=True)

    def tool(self, *arguments):
        return subprocess.run([PROGRAMS["tool"], *map(str, arguments)], capture_output=True, text=True, timeout=200)

    def plan(self, *arguments):
        made = self.tool("identify", self.rom, "--sensors", "sleeve_inner", "--test-hours", 1, "--top-speed", 12000,
                         "--json", *arguments)
        self.assertEqual((made.returncode, made.stderr), (0, ""))
        return json.loads(made.stdout)

    def test_the_proposal_beats_what_it_stands_beside_and_its_schedule_runs(self):
        schedule, page = self.folder / "test.csv", self.folder / "test.html"
        plan = self.plan("--probe", "nose", "-o", schedule, "--html", page)
        by_name = {row["name"]: row for row in plan["compared"]}
        proposed = by_name.pop("proposed")["whole"]["with_sensors_um"]
        self.assertLessEqual(by_name.pop("proposed, temporary sensors too")["whole"]["with_sensors_um"], proposed)
        self.assertEqual(set(by_name), {"constant 6000 rpm", "constant 12000 rpm", "speed spectrum, ISO 230-3"})
        for name, row in by_name.items():
            self.assertLessEqual(proposed, row["whole"]["with_sensors_um"], name)
            self.assertLessEqual(row["whole"]["with_sensors_um"], row["first"]["with_sensors_um"] * (1 + 1e-9))
        self.assertLess(proposed, plan["untested"]["with_sensors_um"])
        constant = [row["whole"]["with_sensors_um"] for name, row in by_name.items() if name.startswith("constant")]
        early = next(row for row in plan["compared"] if row["name"] == "proposed")["first"]["with_sensors_um"]
        self.assertLess(early, min(constant))

        rows = list(csv.DictReader(schedule.read_text().splitlines()))
        self.assertEqual([(float(row["time_s"]), float(row["speed_rpm"])) for row in rows[:-1]],
                         [(stage["from_s"], stage["speed_rpm"]) for stage in plan["proposed"]])
        self.assertEqual(float(rows[-1]["time_s"]), 3600)
        for stage in plan["proposed"]:
            self.assertGreaterEqual(stage["for_s"], 300)
            self.assertLessEqual(stage["speed_rpm"], 12000)
        run = self.folder / "run.csv"
        made = self.tool("simulate", self.rom, "--schedule", schedule, "-o", run, "--every", 60, "--strict")
        self.assertEqual(made.returncode, 0, made.stderr)
        text = page.read_text()
        data = json.loads(text.split('<script id="data" type="application/json">')[1].split("</script>")[0])
        grown = {float(row["time_s"]): float(row["nose_um"]) for row in csv.DictReader(run.read_text().splitlines())}
        for time_s, growth_um in zip(data["test"]["time_s"], data["test"]["growth_um"]):
            self.assertAlmostEqual(growth_um, grown[time_s], delta=0.02)
        self.assertEqual(data["test"]["compared"], plan["compared"])
        again = self.plan("--probe", "nose")
        self.assertEqual(again, plan)

    def test_places_are_reachable_unless_asked_otherwise(self):
        plain = self.tool("identify", self.rom, "--json", "--sensors", "sleeve_inner")
        anywhere = self.tool("identify", self.rom, "--json", "--sensors", "sleeve_inner", "--anywhere")
        parts = [{place["part"] for place in json.loads(made.stdout)["next_sensor"]} for made in (plain, anywhere)]
        self.assertLess(parts[0], parts[1])
        for part in parts[1] - parts[0]:
            self.assertIn(part, ("shaft", "rotor", "bearing", "balls"))
        page = self.folder / "sensors.html"
        made = self.tool("identify", self.rom, "--sensors", "sleeve_inner", "--html", page)
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertIn('"deformation":"nose"', page.read_text())

    def test_a_wish_that_cannot_be_met_ends_in_one_line(self):
        for arguments, code, message in (
                (("--test-hours", 1, "--probe", "tail"), 1, "allowed: nose"),
                (("--test-hours", 1, "--shortest-min", 90), 1, "longer than the test"),
                (("--probe", "nose"), 2, "--test-hours"),
                (("--test-hours", 0), 2, "--test-hours")):
            result = self.tool("identify", self.rom, *arguments)
            self.assertEqual(result.returncode, code, result.stdout + result.stderr)
            self.assertIn(message, result.stderr)
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)


if __name__ == "__main__":
    PROGRAMS["network"], PROGRAMS["tool"] = (os.path.abspath(sys.argv.pop(1)) for _ in range(2))
    unittest.main()
