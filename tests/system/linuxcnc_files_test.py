"""The files for LinuxCNC read the registers that there are, and take them for what they are.

linuxcnc_files_test.py [unittest options]
"""
import ast
import configparser
import pathlib
import re
import tomllib
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHIPPED = ROOT / "host_tools" / "linuxcnc"
# What each signal must be linked to; the HAL file judges them under these names.
REGISTERS = {
    "twin-heartbeat": "compensation_heartbeat",
    "twin-state": "compensation_state",
    "twin-rung": "compensation_rung",
    "twin-age": "compensation_age",
    "twin-word": "compensation_int16",
    "twin-known": "known_uint16",
    "twin-map-version": "map_version",
}
READ_INPUT_REGISTERS = "fnct_04_read_input_registers"


def read_toml(path):
    return tomllib.loads((ROOT / path).read_text(encoding="utf-8"))


def links():
    """LINKS of spindle_twin_watch, which only LinuxCNC's own Python can import."""
    tree = ast.parse((SHIPPED / "spindle_twin_watch").read_text(encoding="utf-8"))
    return next(ast.literal_eval(node.value) for node in tree.body
                if isinstance(node, ast.Assign) and node.targets[0].id == "LINKS")


class Files(unittest.TestCase):
    def setUp(self):
        self.map = read_toml("firmware/serve/registers.toml")
        self.registers = {register["name"]: register for block in self.map["block"] for register in block["register"]}
        self.codes = {codes["name"]: {value["name"]: value["value"] for value in codes["values"]}
                      for codes in read_toml("firmware/cycle/states.toml")["codes"]}
        settings = configparser.ConfigParser(strict=True, inline_comment_prefixes=None)
        settings.read(SHIPPED / "spindle_twin_mb2hal.ini")
        self.transactions = [settings[name] for name in settings.sections() if name.startswith("TRANSACTION_")]
        self.total = settings["MB2HAL_INIT"].getint("TOTAL_TRANSACTIONS")
        self.hal = (SHIPPED / "spindle_twin.hal").read_text(encoding="utf-8")
        self.setp = dict(re.findall(r"^setp (\S+) (\S+)$", self.hal, re.MULTILINE))

    def window(self, component):
        """Whole numbers that a wcomp lets pass."""
        least, most = float(self.setp[f"{component}.min"]), float(self.setp[f"{component}.max"])
        return [n for n in range(0, 65536) if least < n < most]

    def test_each_signal_is_linked_to_its_register(self):
        self.assertEqual(self.total, len(self.transactions))
        by_name = {transaction["HAL_TX_NAME"]: transaction for transaction in self.transactions}
        linked = links()
        self.assertEqual(set(linked), {*REGISTERS, "twin-errors"})
        for signal, register in REGISTERS.items():
            transaction, place, kind = linked[signal].split(".")
            read = by_name[transaction]
            self.assertEqual(kind, "float")
            self.assertEqual(read["MB_TX_CODE"], READ_INPUT_REGISTERS)
            self.assertLess(int(place), read.getint("NELEMENTS"), signal)
            self.assertEqual(read.getint("FIRST_ELEMENT") + int(place), self.registers[register]["address"], signal)

    def test_the_value_and_what_judges_it_come_from_one_read_of_one_block(self):
        transaction = next(t for t in self.transactions if t["HAL_TX_NAME"] == "twin")
        block = next(b for b in self.map["block"] if b["name"] == "compensation")
        last = transaction.getint("FIRST_ELEMENT") + transaction.getint("NELEMENTS")
        self.assertGreaterEqual(transaction.getint("FIRST_ELEMENT"), block["address"])
        self.assertLessEqual(last, block["address"] + block["length"])
        linked = links()
        judged = [s for s in REGISTERS if not s.startswith(("twin-known", "twin-map"))]
        self.assertTrue(all(linked[signal].startswith("twin.") for signal in judged))

    def test_the_state_is_linked_before_what_it_judges(self):
        self.assertEqual(next(iter(links())), "twin-state")

    def test_the_watch_can_be_run(self):
        self.assertTrue((SHIPPED / "spindle_twin_watch").stat().st_mode & 0o111)

    def test_state_rung_and_map_are_judged_by_the_codes_of_the_daemon(self):
        state, rung = self.codes["State"], self.codes["Rung"]
        self.assertEqual(self.window("twin-state-good"), sorted((state["running"], state["degraded"])))
        self.assertEqual(self.window("twin-rung-good"), sorted(value for name, value in rung.items() if name != "none"))
        self.assertEqual(self.window("twin-map-good"), [self.map["map_version"]])
        self.assertEqual(self.window("twin-known-good"), [0x1234])

    def test_the_words_of_the_value_become_signed_and_um(self):
        register = self.registers["compensation_int16"]
        self.assertEqual((register["type"], register["unit"]), ("int16", "um"))
        self.assertEqual(float(self.setp["twin-um.gain"]), register["resolution"])
        corners = [(int(self.setp[f"twin-sign.x-val-{n:02}"]), int(self.setp[f"twin-sign.y-val-{n:02}"])) for n in range(4)]
        self.assertEqual(corners, [(0, 0), (32767, 32767), (32768, -32768), (65535, -1)])
        self.assertGreater(float(self.setp["twin-value-good.min"]), -32768)  # not present

    def test_the_file_sets_only_what_the_settings_hold(self):
        wanted = set(re.findall(r"\[SPINDLE_TWIN\]\(?(\w+)\)?", self.hal))
        held = re.findall(r"^(\w+) = \S+$", (SHIPPED / "spindle_twin.inc").read_text(encoding="utf-8"), re.MULTILINE)
        self.assertEqual(wanted, set(held))
        self.assertEqual(len(held), len(set(held)))

    def test_each_component_is_loaded_once_and_runs_in_the_servo_thread(self):
        loaded = [name for names in re.findall(r"^loadrt .* names=(\S+)", self.hal, re.MULTILINE) for name in names.split(",")]
        added = re.findall(r"^addf (\S+) +servo-thread$", self.hal, re.MULTILINE)
        self.assertEqual(sorted(loaded), sorted(added))
        self.assertEqual(len(added), len(set(added)))


if __name__ == "__main__":
    unittest.main(verbosity=2)
