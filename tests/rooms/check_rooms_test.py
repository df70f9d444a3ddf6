"""The check of the rooms' order fails where an include runs back.

check_rooms_test.py GENERATED_FOLDER [unittest options]
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
GENERATED = None
ORDER = """
[[room]]
path = "low/numbers.hpp"
why = "w"
[[room]]
path = "low"
why = "w"
[[room]]
path = "high"
why = "w"
never = ["low/numbers.hpp"]
[[room]]
path = "high/inner"
why = "w"
"""


class Rooms(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def write(self, path, *includes):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("#pragma once\n" + "".join(f'#include "{name}"\n' for name in includes))

    def check(self):
        return subprocess.run([sys.executable, HERE / "check_rooms.py", "--root", self.root, "--generated", self.root / "generated"],
                              capture_output=True, text=True)

    def complaint(self, order=ORDER):
        (self.root / "rooms.toml").write_text(order)
        result = self.check()
        self.assertEqual(result.returncode, 1, result.stdout)
        return result.stderr.strip()

    def test_down_and_within_a_room_is_good(self):
        (self.root / "rooms.toml").write_text(ORDER)
        self.write("low/numbers.hpp")
        self.write("low/a.cpp", "low/a.hpp", "low/numbers.hpp")
        self.write("high/b.cpp", "low/a.hpp", "high/b.hpp")
        self.write("high/inner/c.cpp", "high/b.hpp", "low/numbers.hpp")
        result = self.check()
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertIn("6 includes, none runs back", result.stdout)

    def test_up_is_named_with_file_and_line(self):
        self.write("low/a.cpp", "low/a.hpp", "high/b.hpp")
        self.assertEqual(self.complaint(), "low/a.cpp:3: runs back: high stands after low in rooms.toml")

    def test_a_name_without_folder_is_the_file_beside(self):
        (self.root / "rooms.toml").write_text(ORDER)
        self.write("low/a.hpp")
        self.write("low/a.cpp", "a.hpp")
        self.assertEqual(self.check().stderr, "")
        self.write("low/numbers.hpp", "a.hpp")
        self.assertEqual(self.complaint(), "low/numbers.hpp:2: runs back: low stands after low/numbers.hpp in rooms.toml")
        self.write("low/numbers.hpp", "b.hpp")
        self.assertEqual(self.complaint(), "low/numbers.hpp:2: b.hpp belongs to no room of rooms.toml")

    def test_from_a_folder_into_one_inside_it(self):
        self.write("high/b.cpp", "high/inner/c.hpp")
        self.assertEqual(self.complaint(), "high/b.cpp:2: runs back: high/inner stands after high in rooms.toml")

    def test_a_file_that_is_a_room_of_its_own(self):
        self.write("low/numbers.hpp", "low/a.hpp")
        self.assertEqual(self.complaint(), "low/numbers.hpp:2: runs back: low stands after low/numbers.hpp in rooms.toml")

    def test_what_a_room_may_never_include(self):
        self.write("high/b.cpp", "low/numbers.hpp")
        self.assertEqual(self.complaint(), "high/b.cpp:2: high may never include low/numbers.hpp, and low/numbers.hpp is of it")

    def test_a_generated_header_belongs_to_the_room_of_its_path(self):
        self.write("low/a.cpp", "high/table.hpp")
        self.assertEqual(self.complaint(), "low/a.cpp:2: runs back: high stands after low in rooms.toml")
        self.write("low/a.cpp", "low/table.hpp")
        self.write("generated/low/table.hpp", "high/b.hpp")
        self.assertEqual(self.complaint(), "low/table.hpp:2: runs back: high stands after low in rooms.toml")

    def test_a_folder_that_is_not_declared(self):
        self.write("low/a.cpp", "low/a.hpp")
        self.write("low/cellar/d.cpp", "low/a.hpp")
        self.assertEqual(self.complaint(), "low/cellar/d.cpp: its folder is no room; declare it in rooms.toml, with the reason")

    def test_an_include_from_outside_the_rooms(self):
        self.write("low/a.cpp", "tests/rom/heap_calls.hpp")
        self.assertEqual(self.complaint(), "low/a.cpp:2: tests/rom/heap_calls.hpp belongs to no room of rooms.toml")

    def test_a_room_needs_its_reason(self):
        self.assertIn("room 1 has no why", self.complaint('[[room]]\npath = "low"\n'))

    def test_nothing_read_is_no_success(self):
        self.assertIn("nothing found", self.complaint())


class ThisHouse(unittest.TestCase):
    """The whole tree with one include more."""

    def complaint_of(self, path, included, generated=False):
        with tempfile.TemporaryDirectory() as name:
            root = pathlib.Path(name)
            for folder in ("rom", "correction", "firmware", "fem_offline", "host_tools"):
                shutil.copytree(ROOT / folder, root / folder, ignore=shutil.ignore_patterns("*.png", "*.toml", "*.csv"))
            shutil.copy(ROOT / "rooms.toml", root)
            for source in GENERATED.rglob("*.hpp"):
                to = root / "generated" / source.relative_to(GENERATED)
                to.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(source, to)
            with open(root / ("generated" if generated else ".") / path, "a") as file:
                file.write(f'#include "{included}"\n')
            result = subprocess.run([sys.executable, HERE / "check_rooms.py", "--root", root, "--generated", root / "generated"],
                                    capture_output=True, text=True)
            self.assertEqual(result.returncode, 1, result.stdout)
            return result.stderr

    def test_a_planted_back_arrow_is_the_one_complaint(self):
        for path, included, end in (
                ("firmware/cycle/snapshot.hpp", "firmware/config/config.hpp", "firmware/config stands after firmware/cycle"),
                ("fem_offline/model/build_model.hpp", "fem_offline/look/picture.hpp", "fem_offline/look stands after fem_offline/model"),
                ("fem_offline/reduce/reduce.hpp", "correction/estimator/parameters.hpp", "fem_offline/reduce may never include correction"),
                ("rom/laws/evaluate.hpp", "rom/boundaries.hpp", "rom stands after rom/laws")):
            with self.subTest(path):
                complaint = self.complaint_of(path, included).splitlines()
                self.assertEqual(len(complaint), 1, complaint)
                self.assertTrue(complaint[0].startswith(path), complaint)
                self.assertIn(end, complaint[0])

    def test_a_back_arrow_of_a_generated_header(self):
        complaint = self.complaint_of("firmware/cycle/states.hpp", "firmware/serve/register_table.hpp", generated=True)
        self.assertIn("firmware/serve stands after firmware/cycle", complaint)


if __name__ == "__main__":
    GENERATED = pathlib.Path(sys.argv.pop(1))
    unittest.main()
