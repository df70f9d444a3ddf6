"""The check of sizes fails for what is too large, and for reasons that nothing needs."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
LIMITS = """CheckOptions:
  - {key: readability-function-size.LineThreshold, value: 5}
  - {key: readability-function-size.ParameterThreshold, value: 3}
"""
TOO_LONG = "int a() {\n" + "  ++b;\n" * 4 + "}\n"
TOO_WIDE = "struct A {\n" + "".join(f"  int a{i} = 0;\n" for i in range(13)) + "};\n"


class Sizes(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.write("rooms.toml", '[[room]]\npath = "low"\nwhy = "w"\n')
        self.write(".clang-tidy", LIMITS)

    def write(self, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def complaints(self, code, name="low/a.cpp"):
        self.write(name, code)
        result = subprocess.run([sys.executable, HERE / "check_sizes.py", "--root", self.root], capture_output=True, text=True)
        self.assertEqual(result.returncode, 1 if result.stderr else 0, result.stderr)
        return result.stderr.strip().splitlines()

    def assert_one(self, code, beginning, name="low/a.cpp"):
        complaints = self.complaints(code, name)
        self.assertEqual(len(complaints), 1, complaints)
        self.assertTrue(complaints[0].startswith(beginning), complaints)

    def test_a_function_of_too_many_lines(self):
        self.assertEqual(self.complaints(TOO_LONG.replace("  ++b;\n", "", 1)), [])
        self.assert_one("\n" + TOO_LONG, "low/a.cpp:2: a has 6 lines, at the most 5")

    def test_a_function_of_too_many_parameters(self):
        self.assertEqual(self.complaints("void a(int b, std::map<int, int> c, int (*d)(int, int)) {}\nvoid e(void) {}\n"), [])
        self.assert_one("void a(int b, int c, std::map<int, int> d = {{1, 2}}, int e = 1) {}\n",
                        "low/a.cpp:1: a has 4 parameters, at the most 3")

    def test_a_struct_of_too_many_public_members(self):
        self.assert_one(TOO_WIDE, "low/a.hpp:1: A has 13 public members, at the most 12", "low/a.hpp")

    def test_what_is_private_static_or_a_function_does_not_count(self):
        for one, other in (("  int a3 = 0;\n", "  static constexpr int a3 = 0;\n"), ("  int a3 = 0;\n", "  int a3();\n"),
                           ("  int a12 = 0;\n", " private:\n  int a12 = 0;\n")):
            with self.subTest(other):
                self.assertIn(one, TOO_WIDE)
                self.assertEqual(self.complaints(TOO_WIDE.replace(one, other)), [])
        self.assertEqual(self.complaints(TOO_WIDE.replace("struct", "class")), [])

    def test_members_of_a_struct_within_are_its_own(self):
        self.assertEqual(self.complaints(TOO_WIDE.replace("  int a3 = 0;\n", "  struct B {\n    int c = 0;\n  } b;\n")
                                         .replace("  int a4 = 0;\n", "")), [])

    def test_a_reason_beside_it(self):
        function, struct = "NOLINT(readability-function-size)", "NOLINT(public-members)"
        self.assertEqual(self.complaints(f"int a() {{  // {function}: a table\n" + TOO_LONG.partition("\n")[2]), [])
        self.assertEqual(self.complaints(f"// {function}: a table\n".replace("NOLINT", "NOLINTNEXTLINE") + TOO_LONG), [])
        self.assertEqual(self.complaints(TOO_WIDE.replace("{\n", f"{{  // {struct}: a table\n", 1)), [])
        self.assert_one(TOO_WIDE.replace("{\n", f"{{  // {struct}\n", 1),
                        "low/a.cpp:1: NOLINT(public-members) without a reason")
        self.assert_one(TOO_WIDE.replace("{\n", f"{{  // {function}: a table\n", 1).replace("  int a3 = 0;\n", ""),
                        "low/a.cpp:1: nothing needs NOLINT(readability-function-size)")

    def test_a_limit_that_is_not_there(self):
        self.write(".clang-tidy", "Checks: '*'\n")
        self.assertIn("has no readability-function-size.LineThreshold", self.complaints("int a;\n")[0])


if __name__ == "__main__":
    unittest.main()
