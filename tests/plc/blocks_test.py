"""The function block in structured text, the one in SCL and the C source do the same, and what they should.

blocks_test.py LIBRARY [unittest options]    LIBRARY: twin_compensation.c as a shared library

Every step of every test goes through all three; each value that they give or remember must be the same, to the bit.
"""
import ctypes
import math
import pathlib
import random
import re
import struct
import sys
import tomllib
import unittest

import checked_block
import structured_text

PLC = pathlib.Path(__file__).resolve().parents[2] / "host_tools" / "plc"
sys.path.insert(0, str(PLC))
import generate_plc  # noqa: E402: beside what it makes

TABLE = tomllib.loads((PLC / "plc.toml").read_text(encoding="utf-8"))
PLAN = generate_plc.Plan()
REASONS = [reason["name"] for reason in TABLE["reason"]]
C_KINDS = {"BOOL": ctypes.c_bool, "UINT": ctypes.c_uint16, "WORD": ctypes.c_uint16, "UDINT": ctypes.c_uint32,
           "DINT": ctypes.c_int32, "REAL": ctypes.c_float}
GIVEN = [(entry["name"], generate_plc.snake(entry["name"]), entry["type"]) for entry in TABLE["output"]]
REMEMBERED = [(entry["name"], generate_plc.snake(entry["name"]), entry["type"]) for entry in TABLE["memory"]]
WORDS = {word: place for word, _, place in PLAN.constants if word.startswith(("A_", "HEAD_"))}
NOT_PRESENT = 32768
LIBRARY = ""


def c_struct(entries, arrays=()):
    fields = [(generate_plc.snake(read["name"]), ctypes.c_uint16 * read["count"]) for read in arrays]
    fields += [(generate_plc.snake(entry["name"]), C_KINDS[entry["type"]]) for entry in entries]
    return type("Struct", (ctypes.Structure,), {"_fields_": fields})


Settings, Input = c_struct(TABLE["setting"]), c_struct(TABLE["input"], PLAN.reads)
Output, Memory = c_struct(TABLE["output"]), c_struct(TABLE["memory"])


class Compensation(ctypes.Structure):
    _fields_ = [("memory", Memory), ("output", Output)]


def read_block(name, dialect):
    return structured_text.read_blocks((PLC / name).read_text(encoding="utf-8"), dialect)[0]


BLOCKS = {"ST": checked_block.checked(read_block("spindle_twin.st", structured_text.ST)),
          "SCL": checked_block.checked(read_block("spindle_twin.scl", structured_text.SCL))}


class Twin:
    """The three of them, and the words that a control has read last."""

    def __init__(self, test, **settings):
        self.test, self.values = test, {name: block.initial_values() for name, block in BLOCKS.items()}
        self.twin, self.settings, self.input = Compensation(), Settings(), Input()
        for entry in TABLE["setting"]:
            setattr(self.settings, generate_plc.snake(entry["name"]), entry["default"])
        self.set(**settings)
        self.input.enable = True
        self.answer = dict(HEARTBEAT=0, STATE=0, QUALITY=0, FAULT=0, RUNG=0, VALUE=0, AGE=0)
        self.head = dict(KNOWN=0, MAP=0)
        self.step_function = ctypes.CDLL(LIBRARY).twin_step
        self.step_function.restype = None

    def set(self, **settings):
        for name, value in settings.items():
            setattr(self.settings, generate_plc.snake(name), value)
            for values in self.values.values():
                values[name] = getattr(self.settings, generate_plc.snake(name))

    def connect(self, value=0, ready=True):
        """A daemon that runs and predicts, seen alive."""
        self.head.update(KNOWN=0x1234, MAP=2)
        self.answer.update(STATE=1, RUNG=1, VALUE=value & 0xFFFF)
        self.input.ready = False
        self.step(0, beats=1)
        self.step(0, beats=1)
        self.input.ready = ready

    def step(self, elapsed_us, beats=0):
        self.answer["HEARTBEAT"] = (self.answer["HEARTBEAT"] + beats) % 65536
        for name, word in self.answer.items():
            self.input.answer[WORDS["A_" + name]] = word
        for name, word in self.head.items():
            self.input.head[WORDS["HEAD_" + name]] = word
        self.input.elapsed_us = elapsed_us
        for name, block in BLOCKS.items():
            values = self.values[name]
            values.update(Head=list(self.input.head), Answer=list(self.input.answer), ElapsedUs=elapsed_us,
                          Enable=self.input.enable, Ready=self.input.ready)
            block.step(values)
        self.step_function(ctypes.byref(self.twin), ctypes.byref(self.settings), ctypes.byref(self.input))
        self.compare()
        return self.twin.output

    def compare(self):
        for names, part in ((GIVEN, self.twin.output), (REMEMBERED, self.twin.memory)):
            for name, field, kind in names:
                for dialect, values in self.values.items():
                    if getattr(part, field) != values[name]:
                        self.test.fail(f"{name}: {getattr(part, field)} in C, {values[name]} in {dialect}")

    def run(self, seconds, period_us=100000, beats=1):
        """Steps for so long; gives the last output."""
        for _ in range(round(seconds * 1e6 / period_us)):
            self.step(period_us, beats)
        return self.twin.output

    def reason(self):
        return REASONS[self.twin.output.reason]


class Belief(unittest.TestCase):
    """What is believed, and why not."""

    def test_nothing_is_believed_before_anything_is_read(self):
        twin = Twin(self)
        twin.input.ready = True
        self.assertEqual((twin.run(1, beats=0).value_nm, twin.reason()), (0, "no_twin"))

    def test_the_first_heartbeat_proves_nothing_the_second_does(self):
        twin = Twin(self)
        twin.head.update(KNOWN=0x1234, MAP=2)
        twin.answer.update(STATE=1, RUNG=1, HEARTBEAT=7)
        twin.step(1000)
        self.assertEqual(twin.reason(), "stale")
        twin.run(10, beats=0)
        self.assertEqual(twin.reason(), "stale")
        self.assertTrue(twin.step(1000, beats=1).valid)

    def test_a_heartbeat_lives_over_its_wrap_and_by_any_step(self):
        twin = Twin(self)
        twin.answer["HEARTBEAT"] = 65530
        twin.connect()
        for beats in (1, 1, 1, 1, 1, 30, 65535, 65000):
            self.assertTrue(twin.run(2, period_us=2000000 // 2, beats=0).valid)
            self.assertTrue(twin.step(1000, beats).valid)

    def test_a_heartbeat_that_stands_for_stale_ms_is_a_lost_connection(self):
        twin = Twin(self, StaleMs=3000)
        twin.connect()
        self.assertTrue(twin.run(2.9, beats=0).valid)
        self.assertFalse(twin.step(100000).valid)
        self.assertEqual(twin.reason(), "stale")
        self.assertTrue(twin.step(100000, beats=1).valid)

    def test_another_device_swapped_bytes_and_another_map_are_refused(self):
        for known, version, reason in ((0, 2, "no_twin"), (0x3412, 2, "no_twin"), (0x1234, 3, "map"), (0x1234, 0, "map")):
            twin = Twin(self)
            twin.connect(value=100)
            twin.head.update(KNOWN=known, MAP=version)
            self.assertFalse(twin.step(1000, beats=1).valid)
            self.assertEqual(twin.reason(), reason)

    def test_state_rung_value_and_age_are_judged(self):
        good = {"STATE": (1, 2), "RUNG": (1, 2, 3, 4, 5), "VALUE": (0, 32767, 32769, 65535), "AGE": (0, 600)}
        bad = {"STATE": ((0, 3, 4, 65535), "state"), "RUNG": ((0, 6, 65535), "no_prediction"),
               "VALUE": ((NOT_PRESENT,), "not_present"), "AGE": ((601, 65535), "old")}
        for name, (words, reason) in bad.items():
            twin = Twin(self)
            twin.connect()
            kept = twin.answer[name]
            for word in words:
                twin.answer[name] = word
                self.assertFalse(twin.step(1000, beats=1).valid, (name, word))
                self.assertEqual(twin.reason(), reason)
            for word in good[name]:
                twin.answer[name] = word
                self.assertTrue(twin.step(1000, beats=1).valid, (name, word))
            twin.answer[name] = kept

    def test_only_the_bits_that_are_asked_for_stop_it(self):
        for setting, word, reason in (("QualityStop", "QUALITY", "quality"), ("FaultStop", "FAULT", "fault")):
            twin = Twin(self)
            twin.connect()
            twin.answer[word] = 65535
            self.assertTrue(twin.step(1000, beats=1).valid)
            twin.set(**{setting: 0x8001})
            self.assertFalse(twin.step(1000, beats=1).valid)
            self.assertEqual(twin.reason(), reason)
            twin.answer[word] = 0x7FFE
            self.assertTrue(twin.step(1000, beats=1).valid)

    def test_settings_outside_their_range_are_refused_and_nothing_moves(self):
        for entry in TABLE["setting"]:
            least, most = checked_block.RANGES.get(entry["type"], (-math.inf, math.inf))
            outside = [value for value in (entry["min"] - 1, entry["max"] + 1) if least <= value <= most]
            if entry["type"] == "REAL":
                outside.append(math.nan)
            for value in outside:
                twin = Twin(self)
                twin.connect(value=500)
                before = twin.run(2).value_nm
                twin.set(**{entry["name"]: value})
                self.assertEqual(twin.run(2).value_nm, before, (entry["name"], value))
                self.assertEqual(twin.reason(), "setting")
                twin.set(**{entry["name"]: entry["default"]})
                twin.run(0.3)
                self.assertEqual(twin.reason(), "ok")


class Way(unittest.TestCase):
    """How the value moves."""

    def test_it_follows_values_of_both_signs(self):
        twin = Twin(self)
        for value in (123, -123, 0, -1, 1999, -1999):
            twin.connect(value=value)
            output = twin.run(45)
            self.assertEqual((output.value_nm, output.settled), (value * 100, True))

    def test_a_step_is_gone_at_the_slew_rate_whatever_the_period(self):
        for period_us in (50, 250, 1000, 1234, 10000, 100000, 1000000):
            for rate in (100, 10000):
                twin = Twin(self, SlewNmPerS=rate)
                twin.connect(value=1900)
                seconds = 3 if period_us >= 1000 else 0.2
                self.assertAlmostEqual(twin.run(seconds, period_us).value_nm, seconds * rate, delta=rate / 100 + 1, msg=period_us)

    def test_a_long_wait_is_no_reason_for_a_step(self):
        twin = Twin(self, SlewNmPerS=10000)
        twin.connect(value=1900)
        self.assertLessEqual(twin.step(4294967295, beats=1).value_nm, 10000)

    def test_beyond_the_limit_it_stays_there_and_is_not_settled(self):
        for sign in (1, -1):
            twin = Twin(self, LimitNm=5000)
            twin.connect(value=sign * 51)
            output = twin.run(2)
            self.assertEqual((output.value_nm, output.limited, output.settled, output.valid), (sign * 5000, True, False, True))
            twin.answer["VALUE"] = (sign * 50) & 0xFFFF
            self.assertTrue(twin.run(1).settled)

    def test_a_lost_value_is_held_and_then_goes_to_zero_slowly(self):
        twin = Twin(self, HoldMs=60000, ReturnNmPerS=100)
        twin.connect(value=-10)
        twin.run(1)
        output = twin.run(60, beats=0)
        self.assertEqual((output.value_nm, output.valid, output.lost), (-1000, False, False))
        output = twin.run(3.5, beats=0)
        self.assertEqual((output.lost, output.settled), (True, False))
        self.assertTrue(-1000 < output.value_nm < 0)
        self.assertEqual(twin.run(12, beats=0).value_nm, 0)
        output = twin.run(1)
        self.assertEqual((output.value_nm, output.lost, output.settled), (-1000, False, True))

    def test_a_restart_of_the_daemon_is_no_step(self):
        twin = Twin(self)
        twin.connect(value=100)
        twin.run(5)
        twin.run(2, beats=0)
        twin.answer.update(HEARTBEAT=0, STATE=0, RUNG=0, VALUE=NOT_PRESENT)
        self.assertEqual((twin.run(5).value_nm, twin.reason()), (10000, "state"))
        twin.answer.update(STATE=1, RUNG=1, VALUE=98)
        self.assertEqual(twin.run(1).value_nm, 9800)

    def test_words_that_a_lost_connection_sets_to_zero_are_held(self):
        for head in (dict(KNOWN=0, MAP=0), dict(KNOWN=0x1234, MAP=2)):
            twin = Twin(self)
            twin.connect(value=100)
            twin.run(2)
            twin.head.update(head)
            twin.answer = dict.fromkeys(twin.answer, 0)
            self.assertEqual(twin.run(10, beats=0).value_nm, 10000)

    def test_switched_off_it_goes_to_zero_and_back(self):
        twin = Twin(self)
        twin.connect(value=100)
        twin.run(2)
        twin.input.enable = False
        self.assertGreater(twin.step(100000, beats=1).value_nm, 8000)
        output = twin.run(2)
        self.assertEqual((output.value_nm, output.valid, output.settled), (0, True, False))
        twin.input.enable = True
        self.assertTrue(twin.run(2).settled)

    def test_switched_off_after_it_was_lost_it_goes_at_the_slew_rate(self):
        twin = Twin(self, HoldMs=0)
        twin.connect(value=1000)
        twin.run(11)
        twin.run(4, beats=0)
        twin.input.enable = False
        self.assertEqual(twin.run(10, beats=0).value_nm, 0)

    def test_a_control_that_is_not_ready_keeps_its_value(self):
        twin = Twin(self)
        twin.connect(value=100, ready=False)
        self.assertEqual(twin.run(20).value_nm, 0)
        twin.input.ready = True
        self.assertLessEqual(twin.step(1000, beats=1).value_nm, 1000)
        self.assertTrue(twin.run(2).settled)

    def test_the_output_has_the_controls_unit_and_sign(self):
        for scale, output, counts in ((0.001, 0.0123, 0), (1.0, 12.3, 12), (10.0, 123.0, 123), (-10.0, -123.0, -123)):
            twin = Twin(self, Scale=scale)
            twin.connect(value=123)
            given = twin.run(5)
            self.assertAlmostEqual(given.output, output, delta=abs(output) * 1e-6)
            self.assertEqual(given.counts, counts)


class Alike(unittest.TestCase):
    def test_random_words_settings_and_periods(self):
        for seed in range(40):
            chance = random.Random(seed)
            twin = Twin(self)
            twin.connect(value=chance.randrange(-2000, 2000))
            for _ in range(250):
                self.change(twin, chance)
                twin.step(chance.choice((0, 1, 250, 9999, 100000, 999999, 4000000000)), chance.choice((0, 0, 1, 65535)))

    def change(self, twin, chance):
        dice = chance.random()
        if dice < 0.3:
            twin.answer["VALUE"] = chance.choice((0, 1, 32767, NOT_PRESENT, 65535, chance.randrange(65536)))
        elif dice < 0.4:
            name = chance.choice(list(twin.answer))
            twin.answer[name] = chance.choice((0, 1, 2, 3, 5, 6, 65535))
        elif dice < 0.5:
            twin.answer.update(STATE=1, RUNG=1, AGE=0)
            twin.head.update(KNOWN=0x1234, MAP=2)
        elif dice < 0.52:
            twin.head[chance.choice(("KNOWN", "MAP"))] = chance.randrange(65536)
        elif dice < 0.6:
            entry = chance.choice(TABLE["setting"])
            twin.set(**{entry["name"]: chance.choice((entry["min"], entry["max"], entry["default"]))})
        elif dice < 0.65:
            twin.input.enable, twin.input.ready = chance.random() < 0.8, chance.random() < 0.8

    def test_the_defaults_are_the_same(self):
        header = (PLC / "twin_interface.h").read_text(encoding="utf-8")
        in_c = [float(text.rstrip("uf")) for text in re.search(r"TWIN_SETTINGS_DEFAULT \{(.*)\}", header)[1].split(", ")]
        for block in BLOCKS.values():
            values = block.initial_values()
            self.assertEqual([struct.unpack("<f", struct.pack("<f", number))[0] for number in in_c],
                             [values[entry["name"]] for entry in TABLE["setting"]])


if __name__ == "__main__":
    LIBRARY = sys.argv.pop(1)
    unittest.main()
