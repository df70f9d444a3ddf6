"""The table stands on this run alone: other rows are refused, ratios are ours over the other's, what is missing is said."""
import json
import pathlib
import re
import stat
import sys
import tempfile
import unittest
from unittest import mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import builds  # noqa: E402
import collect  # noqa: E402
import page  # noqa: E402
import peers  # noqa: E402
import rows  # noqa: E402
import table  # noqa: E402

GOOD = {"run": "this", "group": "Network", "name": "a cycle", "kind": "bound", "ours": 3e-5, "other_name": "one product",
        "other": 5e-6, "unit": "s", "clock": "processor", "means": "what it costs", "detail": False}
MISSING = {"run": "this", "group": "Network", "name": "ten minutes", "kind": "peer", "other_name": "ngspice",
           "not_measured": "ngspice is not installed"}


def read(*rows_of_fields, run="this"):
    return rows.read_rows("".join(json.dumps(fields) + "\n" for fields in rows_of_fields), run, "bench_rows")


class Rows(unittest.TestCase):
    def error(self, fields):
        with self.assertRaises(rows.RowError) as caught:
            read(fields)
        return str(caught.exception)

    def test_a_row_of_another_run_is_refused(self):
        said = self.error({**GOOD, "run": "yesterday"})
        self.assertIn("bench_rows, line 1: 'run' is 'yesterday', must be 'this'", said)
        with self.assertRaises(rows.RowError):
            read(GOOD, {**GOOD, "run": "yesterday"})

    def test_a_row_without_measurement_of_another_run_is_refused_too(self):
        self.assertIn("must be 'this'", self.error({**MISSING, "run": "yesterday"}))

    def test_the_ratio_is_ours_over_the_others(self):
        self.assertAlmostEqual(read(GOOD)[0].ratio, 6.0, places=12)
        self.assertAlmostEqual(read({**GOOD, "ours": 1e-6, "other": 4e-6})[0].ratio, 0.25, places=12)

    def test_every_missing_field_is_named(self):
        for name in ("run", "group", "name", "kind", "other_name", "ours", "other", "unit", "clock"):
            self.assertIn(f"line 1: {name} missing", self.error({key: value for key, value in GOOD.items() if key != name}))
        self.assertIn("ours, other missing", self.error({k: v for k, v in GOOD.items() if k not in ("ours", "other")}))

    def test_what_is_no_time_is_refused_with_what_is_allowed(self):
        for value in (0, -1.0, None, "3", True, float("nan"), float("inf")):
            for name in ("ours", "other"):
                self.assertRegex(self.error({**GOOD, name: value}), f"'{name}' is .*, must be a finite number above 0")

    def test_unknown_words_are_refused_with_what_is_allowed(self):
        for name, allowed in (("kind", "peer or bound"), ("clock", "processor or wall"), ("unit", "s")):
            self.assertIn(f"'{name}' is \"old\", must be {allowed}", self.error({**GOOD, name: "old"}))
        self.assertIn("'clock' is \"wall\", must be resident", self.error({**GOOD, "unit": "B", "clock": "wall"}))
        self.assertIn("unknown field 'stored'; known are", self.error({**GOOD, "stored": 1}))

    def test_what_is_no_row_is_refused_with_its_line(self):
        for text, said in (("", "gave no rows"), ("[]", "line 1: must be a JSON object"), ("times: 3", "line 1: no JSON")):
            with self.assertRaisesRegex(rows.RowError, said):
                rows.read_rows(text, "this", "bench_rows")

    def test_a_row_that_was_not_measured_needs_no_times_and_has_no_ratio(self):
        self.assertIsNone(read(MISSING)[0].ratio)


class Table(unittest.TestCase):
    def test_numbers_have_three_digits_and_a_unit_that_fits(self):
        for time_s, text in ((1.0, "1.00 s"), (0.9996, "1.00 s"), (0.0123, "12.3 ms"), (3.456e-5, "34.6 µs"), (2e-9, "2.00 ns"),
                             (4e-10, "0.400 ns"), (1234.0, "1,230 s")):
            self.assertEqual(table.value_text(time_s), text)
        for size, text in ((5.9e8, "590 MB"), (1e9, "1.00 GB"), (12300.0, "12.3 kB"), (500.0, "0.500 kB")):
            self.assertEqual(table.value_text(size, "B"), text)
        self.assertEqual([table.ratio_text(r, "B") for r in (6.0, 0.004)], ["6.00 x as much", "250 x as little"])
        self.assertEqual(table.goal_text(140.0, "B"), "≤ 140 x as much")
        self.assertEqual([table.ratio_text(r) for r in (1.0, 6.0, 9.999, 0.004)],
                         ["1.00 x as long", "6.00 x as long", "10.0 x as long", "250 x as quick"])
        self.assertEqual([table.goal_text(g) for g in (None, 400.0, 0.05)], ["", "≤ 400 x as long", "≥ 20.0 x as quick"])

    def test_the_text_holds_every_row_in_columns(self):
        text = table.text_table(read(GOOD, {**GOOD, "name": "a longer name", "ours": 1.0}, MISSING))
        lines = text.splitlines()
        self.assertEqual([line.strip() for line in lines if line and not line.startswith("  ")], ["Network"])
        measured = [line for line in lines if "one product" in line]
        self.assertEqual(len({line.index("one product") for line in measured}), 1)
        self.assertIn("6.00 x as long", measured[0])
        self.assertIn("not measured: ngspice is not installed", text)

    def test_the_page_holds_the_rows_and_loads_nothing(self):
        facts = {"date": "today", "command": "</script>"}
        text = page.page_of(facts, read(GOOD, MISSING))
        data = json.loads(re.search(r'<script id="data" type="application/json">(.*?)</script>', text, re.DOTALL)[1])
        self.assertEqual(data["facts"], facts)
        measured, missing = data["groups"][0]["rows"]
        self.assertAlmostEqual(measured["ratio"], 6.0)
        self.assertIsNone(missing["ratio"])
        self.assertEqual(missing["ratio_text"], "not measured: ngspice is not installed")
        self.assertNotRegex(text, r'<(link|img|script)[^>]* (src|href)=')


class Collected(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def program(self, text):
        path = self.folder / "bench_rows"
        path.write_text(f"#!/bin/sh\n{text}\n")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)

    def rows_of(self, name):
        with mock.patch.object(sys, "stderr"):
            return collect.rows_of(name, "this", self.folder)

    def test_a_program_of_ours_is_told_the_run_and_its_rows_are_taken(self):
        fields = {key: value for key, value in GOOD.items() if key != "run"}
        self.program(f"""printf '{{"run": "%s", {json.dumps(fields)[1:]}\\n' "$2" """)
        self.assertEqual(self.rows_of("network"), (read(GOOD), False))

    def test_a_program_that_prints_another_runs_rows_gives_none_of_them(self):
        self.program(f"echo '{json.dumps({**GOOD, 'run': 'yesterday'})}'")
        (row,), failed = self.rows_of("network")
        self.assertTrue(failed)
        self.assertIn("a row of another run", row.not_measured)

    def test_a_program_that_fails_is_a_row_with_its_last_word(self):
        self.program(f"echo '{json.dumps(GOOD)}'; echo first >&2; echo no memory >&2; exit 3")
        (row,), failed = self.rows_of("fem")
        self.assertTrue(failed)
        self.assertEqual((row.group, row.not_measured), ("FE model", "no memory"))

    def test_a_build_costs_what_its_process_took_and_a_missed_tolerance_is_no_failure(self):
        spent = "import sys, time; kept = bytearray(200_000_000)\nwhile time.process_time() < 0.3: pass\nprint('{}'); sys.exit(3)"
        said, code, seconds, peak_bytes = builds.cost_of([sys.executable, "-c", spent], self.folder)
        self.assertEqual((said.strip(), code), ("{}", builds.TOLERANCE_MISSED))
        self.assertGreaterEqual(seconds, 0.3)
        self.assertGreater(peak_bytes, 2e8)
        self.assertLess(peak_bytes, 4e8)
        with self.assertRaisesRegex(peers.NotMeasured, "sh ended with 2: no mesh"):
            builds.cost_of(["sh", "-c", "echo no mesh >&2; exit 2"], self.folder)

    def test_a_build_is_held_against_the_bare_factor_of_its_own_matrix(self):
        bare = {"unknowns": 20000, "factor_s": 0.02, "solve_s": 0.001, "bytes": 6e6}
        made = [{"run": "this", **fields} for fields in builds.rows_of("reference", {"nodes": 220}, 3, 80.0, 3e8, bare)]
        factors, solutions, memory = read(*made)
        self.assertAlmostEqual(factors.ratio, 4000.0)
        self.assertAlmostEqual(solutions.ratio, 80000.0)
        self.assertAlmostEqual(memory.ratio, 50.0)
        self.assertAlmostEqual(memory.goal, 100.0)
        self.assertIn("75 s", factors.means)
        self.assertIn("misses", factors.means)

    def test_a_peer_that_is_not_installed_is_a_row_that_says_so(self):
        with mock.patch.object(peers.shutil, "which", return_value=None):
            fields = peers.beside({"name": "x"}, lambda: peers.need("ngspice", "ngspice"))
        self.assertEqual(fields, {"name": "x", "not_measured": "ngspice is not installed (host_tools/setup bench)"})

    def test_a_peer_that_fails_is_a_row_with_its_last_word(self):
        fields = peers.beside({}, lambda: peers.run(["sh", "-c", "echo diverged >&2; exit 2"], self.folder))
        self.assertEqual(fields, {"not_measured": "sh ended with 2: diverged"})

    def test_a_peer_that_gives_no_time_is_not_measured(self):
        self.assertEqual(peers.beside({}, lambda: peers.number("", "FreeFEM")),
                         {"not_measured": "FreeFEM gave '' in place of a time"})


if __name__ == "__main__":
    unittest.main()
