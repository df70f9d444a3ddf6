"""The command line of spindle-twin, its help and register map; and every kind of bad description and option is one line.

host_tool_input_test.py SPINDLE_TWIN SPINDLE_TWIND SPINDLES_FOLDER [unittest options]
"""
import csv
import pathlib
import re
import shutil
import socket
import subprocess
import unittest

from host_tool_case import REFERENCE, SMALL, SPINDLES, TWIN, Case
from ports import free_port

COMMANDS = ["solve", "build", "verify", "inspect", "simulate", "registers", "plant", "report"]


class Registers(Case):
    def test_all_forms_show_the_same_map(self):
        entries = self.json_of("registers")["registers"]
        table = self.good("registers").stdout
        markdown = self.good("registers", "--markdown").stdout
        rows = list(csv.DictReader(self.good("registers", "--csv").stdout.splitlines()))
        self.assertGreater(len(entries), 20)
        for entry in entries:
            self.assertRegex(table, rf"(?m)^{entry['offset']}\b.* {entry['name']} ")
            self.assertRegex(markdown, rf"(?m)^\| {entry['offset']}[ -].* \| {entry['name']} \|")
        self.assertEqual(len(rows), sum(entry["slots"] for entry in entries))
        self.assertIn("excludes", self.error_of("registers", "--csv", "--json"))


class Usage(Case):
    def test_every_command_explains_itself(self):
        overview = self.good("--help").stdout
        for command in COMMANDS:
            self.assertRegex(overview, rf"(?m)^  {command} +[A-Z]")
            text = self.good(command, "--help").stdout
            options = re.split(r"(?m)^(?=  -)", text.split("Options:\n")[1])[1:]
            self.assertGreater(len(options), 1)
            for option in options:
                # Two columns or two lines: the option, then what it is for.
                self.assertRegex(" ".join(option.split()), r"^-\S+ .*[a-z]{2}", command)
        self.assertRegex(self.good("--version").stdout, r"^\d+\.\d+\.\d+\n$")

    def test_a_wrong_command_line_is_one_line_that_points_to_the_help(self):
        for arguments in ([], ["paint"], ["solve"], ["build", REFERENCE], ["solve", REFERENCE, "--bogus"],
                          ["build", REFERENCE, "-o", self.folder / "x.rom", "--nodes", "0"],
                          ["build", REFERENCE, "-o", self.folder / "x.rom", "--nodes", "many"],
                          ["build", REFERENCE, "-o", self.folder / "x.rom", "--tolerance", "0.05"],
                          ["build", REFERENCE, "-o", self.folder / "x.rom", "--tolerance", "0.05K,0.03um,-1K"],
                          ["build", REFERENCE, "-o", self.folder / "x.rom", "--box", "huge"],
                          ["verify", "a", "b", "--cases", "-3"], ["solve", REFERENCE, "--steady", "--schedule", "x"],
                          ["solve", REFERENCE, "--max-step", "5"], ["simulate", "x", "--schedule", "y", "-o", "z", "--period", "nan"],
                          ["solve", REFERENCE, "--uniform-rise-K", "nan"], ["verify", "a", "b", "--fe-step", "nan"],
                          ["plant", REFERENCE], ["plant", REFERENCE, "--port", "70000"]):
            with self.subTest(str(arguments)):
                self.assertRegex(self.error_of(*arguments), r"; see spindle-twin( [a-z]+)? --help$")
        self.assertRegex(self.error_of("paint"), r"no command paint, allowed are .*build, .*solve|solve, .*build")

    def test_no_command_writes_over_what_it_reads_nor_two_files_into_one(self):
        description = self.text("own.toml", SMALL.read_text())
        schedule = self.text("own.csv", "time_s,speed_rpm,load\n0,6000,1\n60,6000,1\n")
        rom = self.folder / "own.rom"
        self.good("build", description, "-o", rom, "--nodes", 8, "--certificate-cases", 0)
        before = {path: path.read_bytes() for path in (description, schedule, rom)}
        link = self.folder / "link"
        link.symlink_to(description)
        for arguments in (["build", description, "-o", description], ["build", description, "-o", link],
                          ["simulate", rom, "--schedule", schedule, "-o", self.folder / "." / "own.csv"],
                          ["simulate", rom, "--schedule", schedule, "-o", rom], ["inspect", rom, "--html", rom],
                          ["calibrate", rom, schedule, "-o", schedule], ["export", rom, "--spice", rom]):
            with self.subTest(str(arguments)):
                self.assertRegex(self.error_of(*arguments), r"--[a-z]+: \S+ would be written over, and is read; see ")
        self.assertRegex(self.error_of("export", rom, "--spice", self.folder / "x", "--fmu", link.parent / "." / "x"),
                         r"two files, not one")
        self.assertEqual(before, {path: path.read_bytes() for path in before})

    def test_air_that_no_film_leads_to_and_an_empty_description_are_named(self):
        air = self.text("air.toml", SMALL.read_text() + '\n[[surrounding]]\nname = "dry"\nkind = "air"\n'
                                                        'capacity_J_per_K = 1.0\n')
        self.assertRegex(self.error_of("solve", air), r"air\.toml:\d+: surrounding\.dry: no film leads to this air volume$")
        self.assertRegex(self.error_of("solve", self.text("empty.toml", "")), r"empty\.toml: is empty; a description")

    def test_a_csv_in_another_encoding_is_one_line_that_can_be_read(self):
        for name, text in (("latin.csv", "time_s,speed_rpm,load,sp\u00fctze\n".encode("latin-1")),
                           ("utf16.csv", "time_s,speed_rpm,load\n0,1,1\n".encode("utf-16")), ("nul.csv", b"time_s\n4\0\n")):
            path = self.folder / name
            path.write_bytes(text)
            self.assertRegex(self.error_of("solve", SMALL, "--schedule", path), name + r":\d: is no text in UTF-8, as which a")

    def test_a_full_disk_behind_standard_output_is_no_success(self):
        for arguments in (["registers"], ["laws"], ["solve", SMALL, "--json"]):
            with open("/dev/full", "w") as full:
                result = subprocess.run([TWIN, *map(str, arguments)], stdout=full, stderr=subprocess.PIPE, text=True,
                                        timeout=60)
            self.assertEqual(result.returncode, 1, arguments)
            self.assertRegex(result.stderr, r"^spindle-twin: standard output cannot be written: .*\n$")

    def test_without_the_program_of_the_fe_model_commands_that_need_none_still_run(self):
        alone = shutil.copy(TWIN, self.folder / "spindle-twin")
        known = subprocess.run([alone, "laws"], capture_output=True, text=True)
        self.assertEqual((known.returncode, known.stdout), (0, self.good("laws").stdout), known.stderr)
        refused = subprocess.run([alone, "solve", REFERENCE], capture_output=True, text=True)
        self.assertEqual(refused.returncode, 2)
        self.assertRegex(refused.stderr, r"no spindle-twin-fem beside it nor in libexec")
        self.assertRegex(refused.stderr, r"no command solve, allowed are assemble, ")


class Implausible(Case):
    """What is no mistake of form but likely one of units: a warning, with --strict an error."""

    def test_a_schedule_in_percent_and_kelvin_is_warned_of_with_line_and_field(self):
        schedule = self.text("percent.csv", "time_s,speed_rpm,load,coolant_degC\n0,6000,0.5,27\n60,6000,70,295\n120,6000,70,295\n")
        said = self.good("solve", REFERENCE, "--schedule", schedule, "--output-period", 120).stderr
        warned = [line for line in said.splitlines() if line.startswith("warning: ")]
        self.assertIn(f"{schedule}:3: load: 70 is not plausible; believed is -3 to 3", warned[0])
        self.assertIn(f"{schedule}:3: coolant_degC: 295 is not plausible; believed is 2 to 52", warned[1])
        self.assertIn("hottest temperature", warned[2])
        self.assertEqual(len(warned), 3, said)  # once each, not once a row
        refused = self.error_of("solve", REFERENCE, "--schedule", schedule, "--strict")
        self.assertIn(f"{schedule}:3: load: 70 is not plausible", refused)

    def test_a_description_in_other_units_is_warned_of(self):
        text = REFERENCE.read_text()
        hot = self.text("kilowatts.toml", re.sub(r"(density_W_per_m3) = (\S+)", lambda found: f"{found[1]} = {1e3 * float(found[2]):g}", text))
        said = self.good("solve", hot).stderr
        self.assertRegex(said, r"warning: .*kilowatts.toml: source: \d+ W in all are not plausible")
        self.assertIn("hottest temperature", said)
        self.assertIn("source: ", self.error_of("build", hot, "-o", self.folder / "x.rom", "--strict"))

    def test_the_hottest_of_a_whole_run_is_named(self):
        cool = self.text("cool.toml", REFERENCE.read_text() + "\n[plausible]\nresult_degC = [0, 60]\n")
        schedule = self.text("hot.csv", "time_s,speed_rpm,load\n0,12000,2.9\n3600,12000,2.9\n")
        warm = self.good("solve", cool, "--schedule", schedule, "--output-period", 300)
        hottest_degC = max(float(cell) for line in warm.stdout.splitlines()[1:] if line[:1].isdigit()
                           for cell in line.split(",")[1:])
        said = re.search(r"hottest temperature: (\S+) is not", warm.stderr)
        self.assertAlmostEqual(float(said[1]), hottest_degC, delta=0.3)  # columns know a part's vertices

    def test_two_results_that_would_share_a_column_are_refused_by_name(self):
        text = REFERENCE.read_text()
        name = re.search(r'\[\[part\]\]\nname = "(\w+)"', text)[1]
        doubled = self.text("doubled.toml", re.sub(r'(\[\[key_point\]\]\nname = ")\w+', rf"\1{name}_max", text, count=1))
        schedule = self.text("short.csv", "time_s,speed_rpm,load\n0,6000,1\n60,6000,1\n")
        said = self.error_of("solve", doubled, "--schedule", schedule)
        self.assertIn(f"part {name}: its column {name}_max_degC would be that of key point {name}_max as well", said)

    def test_the_shipped_spindles_are_believed(self):
        for path in sorted(pathlib.Path(SPINDLES).glob("*.toml")):
            with self.subTest(path.name):
                self.assertEqual(self.good("solve", path, "--strict").stderr, "")


class WrongKindOfFile(Case):
    def test_a_network_where_a_description_is_wanted_is_called_what_it_is(self):
        by_hand = pathlib.Path(SPINDLES).parents[1] / "rom" / "by_hand" / "two_node.toml"
        rom = self.folder / "two_node.rom"
        self.good("assemble", by_hand, "-o", rom)
        for command in (["solve"], ["build", "-o", self.folder / "x.rom"], ["verify", rom]):
            self.assertIn("is a network file", self.error_of(*command, rom))
            self.assertIn("written by hand", self.error_of(*command, by_hand))


class BadDescription(Case):
    """Each kind of mistake in a description, with the line it is on."""

    def spoilt(self, old, new):
        text = REFERENCE.read_text()
        self.assertEqual(text.count(old), 1, old)
        return self.text("spoilt.toml", text.replace(old, new))

    def test_each_kind_is_one_line_with_file_line_and_names(self):
        contact = '[[contact]]\nbetween = ["shaft", "nut"]\nconductance_W_per_m2K = 4000\n'
        for kind, old, new, marked, names in (
                ("unknown key", "load = 1.0", "load = 1.0\nlaod = 1", "laod", ["laod"]),
                ("missing material", 'name = "labyrinth"\nmaterial = "steel_45"', 'name = "labyrinth"\nmaterial = "brass"',
                 None, ["labyrinth", "brass"]),
                ("contact not declared", contact, "", None, ["shaft", "nut"]),
                ("contact that does not touch", contact, contact + contact.replace("shaft", "labyrinth"), None,
                 ["labyrinth", "nut"]),
                ("overlap", "rectangles = [[25, 31, 378, 398]]", "rectangles = [[24, 31, 378, 398]]", None, ["shaft", "nut"]),
                ("film on no face", "regions = [[0, 14, 0, 410]]", "regions = [[0, 10, 0, 410]]", None, ["shaft_bore"]),
                ("outer face with no film", "[80, 200, 18, 40], [88, 200, 40, 400]", "[80, 200, 18, 40]", None, ["housing"]),
                ("negative", "coefficient_W_per_m2K = 235", "coefficient_W_per_m2K = -235", "= -235", ["-235"]),
                ("not finite", "coefficient_W_per_m2K = 235", "coefficient_W_per_m2K = nan", "= nan", ["shaft_bore"]),
                ("not TOML", "load = 1.0", "load = = 1.0", "load = =", ["TOML"])):
            path = self.spoilt(old, new)
            output = self.folder / "x.rom"
            commands = [["solve", path]]
            if kind == "unknown key":  # they have one reader
                commands += [["build", path, "-o", output], ["plant", path, "--port", free_port()]]
            for command in commands:
                with self.subTest(kind, command=command[0]):
                    message = self.error_of(*command)
                    found = re.match(rf"spindle-twin: {re.escape(str(path))}:(\d+): ", message)
                    self.assertTrue(found, message)
                    if marked:
                        self.assertIn(marked, path.read_text().splitlines()[int(found[1]) - 1])
                    for name in names:
                        self.assertIn(name, message)

    def test_a_missing_file(self):
        path = self.folder / "none.toml"
        for command in (["solve", path], ["build", path, "-o", self.folder / "x.rom"], ["plant", path, "--port", free_port()]):
            self.assertEqual(self.error_of(*command), f"spindle-twin: {path}: cannot be read as a file")
        history = self.folder / "none.sqlite"
        self.assertEqual(self.error_of("history", history),
                         f"spindle-twin: {history}: cannot be read: No such file or directory")


class Plant(Case):
    def test_a_busy_port(self):
        with socket.socket() as other:
            other.bind(("127.0.0.1", 0))
            other.listen()
            port = other.getsockname()[1]
            self.assertEqual(self.error_of("plant", SMALL, "--port", port),
                             f"spindle-twin: --port: cannot listen on 127.0.0.1:{port}: Address already in use")

    def test_an_unknown_name_lists_those_that_exist(self):
        for option, known in (("--heat-factor", "rotor"), ("--contact-factor", "shaft"), ("--film-factor", "shaft_bore"),
                              ("--offset-K", "inner")):
            message = self.error_of("plant", REFERENCE, "--port", free_port(), option, "roter=2")
            self.assertRegex(message, rf"^spindle-twin: {option}: 'roter' does not exist; allowed: all, .*{known}")

    def test_values_out_of_range(self):
        for option, value in (("--heat-factor", "rotor"), ("--heat-factor", "rotor=-1"), ("--contact-spread", "2"),
                              ("--rate", "0"), ("--rate", "nan"), ("--noise-K", "-1"), ("--step-s", "0"),
                              ("--duration", "-1"), ("--log-every-s", "0"), ("--log", self.folder / "none" / "x.csv"),
                              ("--address", "nowhere"), ("--schedule", self.folder / "none.csv")):
            with self.subTest(option, value=value):
                self.assertIn(str(option if option not in ("--log", "--schedule", "--address") else value),
                              self.error_of("plant", SMALL, "--port", free_port(), f"{option}={value}"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
