"""What the tests of spindle-twin share: the programs under test, and how a command is run and judged.

The first three arguments of a test program that imports this are SPINDLE_TWIN SPINDLE_TWIND SPINDLES_FOLDER.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

TWIN, DAEMON, SPINDLES = map(os.path.abspath, sys.argv[1:4])
del sys.argv[1:4]
REFERENCE = pathlib.Path(SPINDLES) / "reference.toml"
SMALL = pathlib.Path(SPINDLES) / "shaft_in_sleeve.toml"  # solves in no time
FOLDER = tempfile.TemporaryDirectory()
WORK = pathlib.Path(FOLDER.name)
COARSE = WORK / "coarse.toml"  # the reference spindle on elements of twice the size: a quarter of the work
COARSE.write_text(REFERENCE.read_text().replace("element_size_mm = 4", "element_size_mm = 8"))
HOUR = "time_s,speed_rpm,load,coolant_degC\n0,6000,1,27\n600,12000,0.5,25\n900,12000,0.5,25\n"
MINUTE = "time_s,speed_rpm,load,coolant_degC\n0,6000,1,27\n60,6600,0.95,26.8\n"  # the first of it


def run(*arguments, seconds=600, **options):
    return subprocess.run([TWIN, *map(str, arguments)], capture_output=True, text=True, timeout=seconds, **options)


BUILT = {}


def reference_network():
    """The network of COARSE, small enough to be quick, built once; with what the command said."""
    if not BUILT:
        folder = pathlib.Path(tempfile.mkdtemp(dir=WORK))
        rom = folder / "reference.rom"
        result = run("build", COARSE, "-o", rom, "--nodes", 120, "--certificate-cases", 3, "--json")
        assert result.returncode == 0, result.stderr
        BUILT.update(rom=rom, said=json.loads(result.stdout), progress=result.stderr,
                     files=[path.name for path in folder.iterdir()])
    return BUILT


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=WORK))

    def text(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def good(self, *arguments):
        result = run(*arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def json_of(self, *arguments):
        return json.loads(self.good(*arguments, "--json").stdout)

    def error_of(self, *arguments):
        """The one line that a refused command leaves; and no new file."""
        before = sorted(self.folder.rglob("*"))
        result = run(*arguments, seconds=120)
        self.assertNotEqual(result.returncode, 0, result.stdout)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertEqual(result.stdout, "")
        self.assertEqual(sorted(self.folder.rglob("*")), before, "the refused command left a file")
        self.assertTrue(result.stderr.startswith("spindle-twin"), result.stderr)
        return result.stderr.strip()
