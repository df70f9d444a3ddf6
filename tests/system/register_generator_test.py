"""What the generator of the register map refuses."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

GENERATOR = pathlib.Path(__file__).resolve().parents[2] / "firmware" / "serve" / "generate_registers.py"
MAP = """
map_version = 1
states = "states.toml"
[[block]]
name = "first"
address = 0
length = {length}
command = false
doc = ""
register = [
  {{ address = 0, name = "a", type = "int16", slots = "points", doc = "" }},
  {{ address = {second}, name = "{name}", type = "{type}", doc = "" }},
]
"""


STATES = """
[slots]
points = {points}
[[codes]]
name = "State"
doc = ""
values = [
  {{ value = 0, name = "off", doc = "" }},
  {{ value = {value}, name = "{name}", doc = "" }},
]
"""


class Generator(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.map = pathlib.Path(folder.name) / "registers.toml"
        self.declare_states()

    def declare_states(self, points=4, value=1, name="on"):
        (self.map.parent / "states.toml").write_text(STATES.format(points=points, value=value, name=name))

    def run_on(self, task, length=6, second=4, name="b", type="float32"):
        self.map.write_text(MAP.format(length=length, second=second, name=name, type=type))
        return subprocess.run([sys.executable, GENERATOR, "--map", self.map, task], capture_output=True, text=True)

    def error_of(self, **changes):
        result = self.run_on("--write", **changes)
        self.assertNotEqual(result.returncode, 0)
        return result.stderr

    def test_a_good_map_is_written_and_then_current(self):
        self.assertEqual(self.run_on("--write").returncode, 0)
        self.assertEqual(self.run_on("--check").returncode, 0)

    def test_files_that_are_not_current_are_named(self):
        self.run_on("--write")
        result = self.run_on("--check", type="int32")
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("registers.md", result.stderr)
        self.assertIn("registers.csv", result.stderr)

    def test_overlap(self):
        self.assertIn("registers a and b overlap at 3", self.error_of(second=3))

    def test_outside_the_block(self):
        self.assertIn("register b: 6 is outside block first, 0 to 5", self.error_of(second=5))

    def test_a_block_longer_than_one_read(self):
        self.assertIn("block first: 126 registers, one read takes at most 125", self.error_of(length=126))

    def test_the_same_name_twice(self):
        self.assertIn("register a stands twice", self.error_of(name="a"))

    def test_an_unknown_type(self):
        self.assertIn("register b: type real, allowed: uint16", self.error_of(type="real"))

    def test_capacities_and_codes_come_from_the_states(self):
        self.declare_states(points=3, value=7, name="warm")
        self.assertEqual(self.run_on("--write").returncode, 0)
        documentation = self.map.with_name("registers.md").read_text()
        self.assertIn("| 0-2 | 30001, 40001 | a | int16 | 3 |", documentation)
        self.assertIn("| 7 | warm |", documentation)

    def test_a_capacity_that_the_states_do_not_declare(self):
        self.map.write_text(MAP.format(length=6, second=4, name="b", type="int16").replace('"points"', '"places"'))
        result = subprocess.run([sys.executable, GENERATOR, "--map", self.map, "--write"], capture_output=True, text=True)
        self.assertIn("register a: slots places, allowed: a number or points", result.stderr)

    def test_a_meaning_that_is_not_declared(self):
        for key, value in (("codes", "Stage"), ("bits", "Stage"), ("metric", "sum")):
            self.map.write_text(MAP.format(length=6, second=4, name="b", type="int16")
                                .replace('type = "int16", doc', f'type = "int16", {key} = "{value}", doc'))
            result = subprocess.run([sys.executable, GENERATOR, "--map", self.map, "--write"], capture_output=True, text=True)
            self.assertIn(f"register b: {key} {value}, allowed: ", result.stderr)

    def test_a_code_declared_twice(self):
        self.declare_states(name="off")
        self.assertIn("State: name off stands twice", self.error_of())
        self.declare_states(value=0)
        self.assertIn("State: value 0 stands twice", self.error_of())


if __name__ == "__main__":
    unittest.main()
