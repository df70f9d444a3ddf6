"""The numbers of a thermal test report are those of its log, computed here without the program.

thermal_test_report_test.py MAKE_SMALL_NETWORK SPINDLE_TWIN [unittest options]
"""
import csv
import json
import math
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest

PROGRAMS = {}
CONSTANT_S = 1500.0


def write_log(path, length_s=9000, stands_s=900, wild=False, spare=True):
    """Standstill, one speed with a growth of one time constant, standstill; a cell is empty now and then."""
    chance = random.Random(3)
    lines = ["time_s,speed_rpm,load,ambient_degC,measured.sleeve_inner_degC,measured.nose_um" + ",spare" * spare]
    for time_s in range(0, length_s + 1, 10):
        turning_s = min(max(time_s - stands_s, 0), length_s - 2 * stands_s)
        cooling_s = max(time_s - (length_s - stands_s), 0)
        share = (1 - math.exp(-turning_s / CONSTANT_S)) * math.exp(-cooling_s / 2000)
        speed = 6000 + chance.uniform(-20, 20) if stands_s <= time_s < length_s - stands_s else 0
        if wild and stands_s <= time_s < length_s / 2:
            speed = 12000
        nose_um = 7 + 30 * share + 0.3 * math.sin(time_s / 700) + chance.gauss(0, 0.2)
        cell = "" if chance.random() < 0.1 and time_s > 0 else f"{nose_um:.3f}"
        lines.append(f"{time_s},{speed:.2f},0,{20 + 0.2 * math.sin(time_s / 3000):.4f},"
                     f"{21 + 8 * share + chance.gauss(0, 0.02):.4f},{cell}" + ",1" * spare)
    path.write_text("\n".join(lines) + "\n")


def readings(path, column, from_s, until_s):
    with path.open() as file:
        rows = [(float(row["time_s"]), row[column]) for row in csv.DictReader(file)]
    return [(time_s, float(cell)) for time_s, cell in rows if cell and from_s <= time_s <= until_s]


def drift(points):
    values = [value for _, value in points]
    change = values[-1] - values[0]
    return {"readings": len(values), "range": max(values) - min(values), "change": change,
            "rate_per_h": 3600 * change / (points[-1][0] - points[0][0])}


def steepest(points, span_s):
    rates = []
    for i, (begin_s, first) in enumerate(points):
        later = [point for point in points[i:] if point[0] - begin_s >= span_s]
        if later:
            rates.append(3600 * abs(later[0][1] - first) / (later[0][0] - begin_s))
    return max(rates)


def left_with(points, from_s, constant_s):
    """rms that a first-order rise of this time constant leaves, by the normal equations, and its swing."""
    forms = [1 - math.exp(-(time_s - from_s) / constant_s) for time_s, _ in points]
    mean_form, mean = sum(forms) / len(forms), sum(value for _, value in points) / len(points)
    swing = sum((form - mean_form) * (value - mean) for form, (_, value) in zip(forms, points)) / sum(
        (form - mean_form) ** 2 for form in forms)
    squares = sum((value - mean - swing * (form - mean_form)) ** 2 for form, (_, value) in zip(forms, points))
    return math.sqrt(squares / len(points)), swing


class ThermalTestReport(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        self.log = self.folder / "test.csv"

    def tool(self, *arguments):
        return subprocess.run([PROGRAMS["tool"], *map(str, arguments)], capture_output=True, text=True, timeout=120)

    def report(self, *arguments):
        made = self.tool("thermal-test-report", self.log, "--json", *arguments)
        self.assertEqual((made.returncode, made.stderr), (0, ""))
        return json.loads(made.stdout)

    def assert_drift(self, found, points):
        expected = drift(points)
        self.assertEqual(set(found), set(expected))
        for name, value in expected.items():
            self.assertAlmostEqual(found[name], value, places=6, msg=name)

    def test_ranges_rates_and_time_constants_are_those_of_the_log(self):
        write_log(self.log)
        report = self.report("--note", "machine=the third one", "--note", "probe=at the nose, axial")
        self.assertIn({"name": "probe", "text": "at the nose, axial"}, report["set_up"])
        self.assertEqual(report["unused_columns"], ["load", "spare"])
        self.assertEqual([(phase["from_s"], phase["until_s"]) for phase in report["phases"]],
                         [(0, 900), (900, 8100), (8100, 9000)])
        rotation = report["rotation"]
        self.assertEqual((rotation["from_s"], rotation["until_s"], rotation["kind"]), (900, 8100, "constant speed"))
        for column, found in (("measured.nose_um", rotation["lengths"][0]["measured"]),
                              ("measured.sleeve_inner_degC", rotation["temperatures"][0]["measured"])):
            for window, length_s in (("first_15_min", 900), ("first_60_min", 3600), ("whole", 7200)):
                self.assert_drift(found[window], readings(self.log, column, 900, 900 + length_s))
            self.assertAlmostEqual(found["steepest_15_min_per_h"], steepest(readings(self.log, column, 900, 8100), 900),
                                   places=6)
        self.assertIsNone(rotation["lengths"][0]["compensated"])
        self.assert_drift(report["etve"]["lengths"][0]["whole"], readings(self.log, "measured.nose_um", 0, 900))
        self.assert_drift(report["etve"]["surroundings"][0]["whole"], readings(self.log, "ambient_degC", 0, 900))
        self.assert_drift(report["cooling"]["lengths"][0]["whole"], readings(self.log, "measured.nose_um", 8100, 9000))

        fitted = report["time_constants"][0]
        points = readings(self.log, "measured.nose_um", 900, 8100)
        rms, swing = left_with(points, 900, fitted["time_constant_s"])
        self.assertAlmostEqual(fitted["rms_um"], rms, places=6)
        self.assertAlmostEqual(fitted["swing_um"], swing, places=6)
        for factor in (0.98, 0.999, 1.001, 1.02):
            self.assertGreater(left_with(points, 900, factor * fitted["time_constant_s"])[0], rms)
        self.assertAlmostEqual(fitted["time_constant_s"], CONSTANT_S, delta=100)  # of a sine besides

    def test_the_page_has_the_same_numbers_in_it_and_loads_nothing(self):
        write_log(self.log)
        page = self.folder / "report.html"
        report = self.report("-o", page)
        text = page.read_text()
        data = json.loads(text.split('<script id="data" type="application/json">')[1].split("</script>")[0])
        courses = data.pop("courses")
        self.assertEqual(data, report)
        zero_um = readings(self.log, "measured.nose_um", 900, 9000)[0][1]
        drawn = dict(zip(courses["time_s"], courses["lengths"][0]["values"]))
        for time_s, value in readings(self.log, "measured.nose_um", 0, 9000):
            self.assertAlmostEqual(drawn[time_s], value - zero_um, places=3)
        self.assertNotRegex(text, r'(src|href)="http')

    def test_a_window_that_the_probe_does_not_cover_has_no_numbers(self):
        write_log(self.log)
        lines = self.log.read_text().splitlines()
        nose = lines[0].split(",").index("measured.nose_um")
        for lost_from_s, lost_until_s in ((1200, 1e9), (0, 3000)):
            cut = lines[:1]
            for line in lines[1:]:
                cells = line.split(",")
                if lost_from_s <= float(cells[0]) < lost_until_s:
                    cells[nose] = ""
                cut.append(",".join(cells))
            log = self.folder / "cut.csv"
            log.write_text("\n".join(cut) + "\n")
            made = subprocess.run([PROGRAMS["tool"], "thermal-test-report", log, "--json"], capture_output=True, text=True,
                                  timeout=60)
            self.assertEqual(made.returncode, 0, made.stderr)
            report = json.loads(made.stdout)
            of = report["rotation"]["lengths"][0]["measured"]
            self.assertEqual([of[window] for window in ("first_15_min", "first_60_min", "whole")], [None] * 3)
            self.assertIsNone(report["time_constants"][0]["time_constant_s"])
            self.assertIsNotNone(report["rotation"]["temperatures"][0]["measured"]["whole"])

    def test_several_speeds_are_said_to_vary_and_a_short_log_has_no_hour(self):
        write_log(self.log, length_s=4000, stands_s=300, wild=True)
        report = self.report()
        self.assertEqual(report["rotation"]["kind"], "varying speed")
        self.assertIsNone(report["etve"])
        self.assertIsNone(report["cooling"])
        self.assertIsNone(report["rotation"]["lengths"][0]["measured"]["first_60_min"])
        self.assertIsNotNone(report["rotation"]["lengths"][0]["measured"]["first_15_min"])

    def test_what_compensation_leaves_is_reading_minus_prediction(self):
        rom = self.folder / "small.rom"
        subprocess.run([PROGRAMS["network"], rom], check=True, capture_output=True)
        write_log(self.log, length_s=3000, stands_s=600, spare=False)
        report = self.report("--rom", rom, "--correction", "none", "--start-degC", "20")
        replayed = self.folder / "replayed.csv"
        made = self.tool("replay", rom, self.log, "--correction", "none", "--start-degC", "20", "-o", replayed)
        self.assertEqual(made.returncode, 0, made.stderr)
        with replayed.open() as file:
            rows = list(csv.DictReader(file))
        predicted = {round(float(row["time_s"]), 3): float(row["nose_um"]) for row in rows}
        left = [(time_s, value - predicted[time_s])
                for time_s, value in readings(self.log, "measured.nose_um", 600, 2400) if time_s in predicted]
        found = report["rotation"]["lengths"][0]["compensated"]["whole"]
        for name, value in drift(left).items():
            self.assertAlmostEqual(found[name], value, places=4, msg=name)
        self.assertNotAlmostEqual(found["range"], report["rotation"]["lengths"][0]["measured"]["whole"]["range"], places=1)

    def test_bad_logs_end_in_one_line(self):
        for text, message in (("time_s,speed_rpm\n0,0\n10,0\n", "measured.<name>_um"),
                              ("time_s,measured.nose_um\n0,0\n", "speed_rpm"),
                              ("time_s,speed_rpm,measured.nose_um\n0,0,1\n0,0,1\n", "times must rise"),
                              ("time_s,speed_rpm,measured.nose_um\n0,,1\n10,0,1\n", "must not be empty")):
            self.log.write_text(text)
            page = self.folder / "none.html"
            result = self.tool("thermal-test-report", self.log, "-o", page)
            self.assertEqual(result.returncode, 1, text)
            self.assertIn(message, result.stderr)
            self.assertEqual(len(result.stderr.splitlines()), 1)
            self.assertFalse(page.exists())
        self.assertEqual(self.tool("thermal-test-report", self.log, "--correction", "none").returncode, 2)


if __name__ == "__main__":
    PROGRAMS["network"], PROGRAMS["tool"] = (os.path.abspath(sys.argv.pop(1)) for _ in range(2))
    unittest.main()
