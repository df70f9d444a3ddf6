"""What compare.py lets pass, and what it does not."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

COMPARE = pathlib.Path(__file__).with_name("compare.py")


class Compare(unittest.TestCase):
    def passes(self, one, other):
        with tempfile.TemporaryDirectory() as folder:
            files = [pathlib.Path(folder) / name for name in ("a", "b")]
            for file, text in zip(files, (one, other)):
                file.write_text(text)
            return subprocess.run([sys.executable, "-B", COMPARE, "1e-9", *files],
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0

    def test_small_numbers_differ_by_the_limit_large_ones_by_that_share(self):
        self.assertTrue(self.passes("a,b\n0.5,nan\n", "a,b\n0.5000000009,nan\n"))
        self.assertFalse(self.passes("a,b\n0.5,1\n", "a,b\n0.5000000011,1\n"))
        self.assertTrue(self.passes("a\n1000\n", "a\n1000.0000009\n"))
        self.assertFalse(self.passes("a\n1000\n", "a\n1000.0000011\n"))

    def test_a_number_on_one_side_only_differs(self):
        self.assertFalse(self.passes("a\n1\n", "a\nnan\n"))
        self.assertFalse(self.passes("a\ninf\n", "a\n1\n"))

    def test_other_columns_other_rows_and_nothing_at_all_differ(self):
        self.assertFalse(self.passes("a\n1\n", "b\n1\n"))
        self.assertFalse(self.passes("a\n1\n2\n", "a\n1\n"))
        self.assertFalse(self.passes("a,b\n1,2\n", "a,b\n1\n"))
        self.assertFalse(self.passes("a\n", "a\n"))


if __name__ == "__main__":
    unittest.main()
