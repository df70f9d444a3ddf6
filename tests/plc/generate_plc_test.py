"""What generate_plc.py makes follows the register map, and it refuses what does not fit.

generate_plc_test.py [unittest options]
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SOURCES = ("firmware/serve/generate_registers.py", "firmware/serve/registers.toml", "firmware/cycle/generate_states.py",
           "firmware/cycle/states.toml", *(f"host_tools/plc/{path.name}" for path in (ROOT / "host_tools" / "plc").iterdir() if path.is_file()))


class Generator(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        for name in SOURCES:
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, self.root / name)

    def run_generator(self, task):
        return subprocess.run([sys.executable, self.root / "host_tools/plc/generate_plc.py", task], capture_output=True, text=True)

    def change(self, name, before, after):
        text = (self.root / name).read_text(encoding="utf-8")
        self.assertIn(before, text)
        (self.root / name).write_text(text.replace(before, after, 1), encoding="utf-8")

    def made(self, name):
        return (self.root / "host_tools/plc" / name).read_text(encoding="utf-8")

    def test_a_change_of_any_source_makes_the_files_stale(self):
        self.assertEqual(self.run_generator("--check").returncode, 0)
        for name, before, after in (("firmware/serve/registers.toml", "map_version = 2", "map_version = 3"),
                                    ("host_tools/plc/plc.toml", "default = 200000", "default = 200001"),
                                    ("host_tools/plc/logic.st", "Settled := FALSE;", "Settled := TRUE;"),
                                    ("host_tools/plc/reader_tia.scl", "MB_MODE := 0", "MB_MODE := 104")):
            self.change(name, before, after)
            said = self.run_generator("--check")
            self.assertEqual(said.returncode, 1)
            self.assertIn("stale: ", said.stderr)
            self.assertEqual(self.run_generator("--write").returncode, 0)
            self.assertEqual(self.run_generator("--check").returncode, 0)

    def test_the_files_follow_the_map(self):
        self.change("firmware/serve/registers.toml", "map_version = 2", "map_version = 7")
        self.change("firmware/cycle/states.toml", '{ value = 2, name = "degraded"', '{ value = 9, name = "degraded"')
        self.assertEqual(self.run_generator("--write").returncode, 0)
        for name, words in (("spindle_twin.st", ("MAP_VERSION : UINT := 7;", "STATE_DEGRADED : UINT := 9;")),
                            ("twin_interface.h", ("#define TWIN_MAP_VERSION 7u", "#define TWIN_STATE_DEGRADED 9u"))):
            for word in words:
                self.assertIn(word, self.made(name))

    def test_what_does_not_fit_is_refused_by_name(self):
        for name, before, after, words in (
                ("host_tools/plc/plc.toml", 'A_RUNG = "compensation_rung"', 'A_RUNG = "missing"', "register missing, allowed"),
                ("host_tools/plc/plc.toml", 'A_RUNG = "compensation_rung"', 'A_RUNG = "compensation_sd"', "allowed: compensation_heartbeat to"),
                ("host_tools/plc/plc.toml", 'last = "compensation_age"', 'last = "network_id"', "one block"),
                ("host_tools/plc/reader_tia.scl", "@Head.count@", "@Head.cuont@", "no place"),
                ("firmware/serve/registers.toml", 'name = "compensation_int16", type = "int16"', 'name = "compensation_int16", type = "uint16"',
                 "an int16 in um")):
            with self.subTest(words):
                self.setUp()
                self.change(name, before, after)
                said = self.run_generator("--write")
                self.assertEqual(said.returncode, 1)
                self.assertIn(words, said.stderr)


if __name__ == "__main__":
    unittest.main()
