"""A log replayed twice: both are what `replay` gives alone, and the difference is theirs.

compare_test.py MAKE_SMALL_NETWORK SPINDLE_TWIN [unittest options]
"""
import csv
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAMS = {}


class Compare(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        self.rom, self.other = self.folder / "small.rom", self.folder / "other.rom"
        subprocess.run([PROGRAMS["network"], self.rom], check=True)
        subprocess.run([PROGRAMS["network"], self.other, "0.7"], check=True)
        self.log = self.folder / "log.csv"
        lines = ["time_s,speed_rpm,load,measured.sleeve_inner_degC,measured.nose_um"]
        for time_s in range(0, 1201, 10):
            rise = 1 - math.exp(-time_s / 900)
            lines.append(f"{time_s},6000,1,{20 + 4 * rise:.4f},{9 * rise:.4f}")
        self.log.write_text("\n".join(lines) + "\n")

    def tool(self, *arguments):
        made = subprocess.run([PROGRAMS["tool"], *map(str, arguments)], capture_output=True, text=True, timeout=120)
        self.assertEqual(made.returncode, 0, made.stderr)
        return made.stdout

    def replayed(self, rom, law):
        out = self.folder / f"{rom.stem}_{law}.csv"
        errors = json.loads(self.tool("replay", rom, self.log, "--correction", law, "--json", "-o", out))
        with out.open() as file:
            return errors, [float(row["nose_um"]) for row in csv.DictReader(file)]

    def assert_compared(self, first, second, *arguments):
        compared = json.loads(self.tool("compare", self.rom, self.log, "--json", "--html", self.folder / "page.html",
                                        *arguments))
        nose = compared["deformations"][0]
        for key, (errors, _) in (("first_error", first), ("second_error", second)):
            twin = errors["deformations"][0]["twin"]
            self.assertAlmostEqual(nose[key]["rms_um"], twin["rms_um"], delta=0.01 * twin["rms_um"])
        apart = [b - a for a, b in zip(first[1], second[1])]
        self.assertAlmostEqual(nose["difference"]["rms_um"], math.sqrt(sum(a * a for a in apart) / len(apart)), places=3)
        self.assertAlmostEqual(nose["difference"]["worst_um"], max(apart, key=abs), places=3)
        text = (self.folder / "page.html").read_text()
        data = json.loads(text.split('<script id="data" type="application/json">')[1].split("</script>")[0])
        self.assertEqual(len(data["time_s"]), len(first[1]))
        self.assertAlmostEqual(data["deformations"][0]["second"][-1], second[1][-1], places=3)
        self.assertEqual(data["deformations"][0]["difference"], nose["difference"])
        return compared

    def test_two_laws_are_what_each_is_alone(self):
        self.assert_compared(self.replayed(self.rom, "none"), self.replayed(self.rom, "estimator"),
                             "--correction", "none", "--to-correction", "estimator")

    def test_two_networks_are_what_each_is_alone(self):
        compared = self.assert_compared(self.replayed(self.rom, "none"), self.replayed(self.other, "none"),
                                        "--correction", "none", "--to", self.other)
        self.assertIn("other.rom", compared["second"])

    def test_the_same_twice_does_not_differ(self):
        compared = json.loads(self.tool("compare", self.rom, self.log, "--correction", "estimator", "--json"))
        for output in compared["deformations"] + compared["key_points"]:
            for name, value in output["difference"].items():
                self.assertEqual(value, 0, name)


if __name__ == "__main__":
    PROGRAMS["network"], PROGRAMS["tool"] = (os.path.abspath(sys.argv.pop(1)) for _ in range(2))
    unittest.main()
