"""What clang-tidy judges is what has changed since the branch left main, or in the last commit."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[1] / "changed_sources.py"


class ChangedSources(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.git("init", "--quiet", "--initial-branch", "main")
        self.commit(**{"rom/a.cpp": '#include "rom/b.hpp"\n', "rom/b.hpp": "int b;\n", "rom/c.cpp": "int c;\n"})

    def git(self, *words):
        subprocess.run(["git", "-C", self.root, "-c", "user.name=n", "-c", "user.email=e", *words], check=True,
                       capture_output=True)

    def write(self, **texts):
        for name, text in texts.items():
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            (self.root / name).write_text(text)

    def commit(self, **texts):
        self.write(**texts)
        self.git("add", ".")
        self.git("commit", "--quiet", "--message", "m")

    def changed(self, *options):
        result = subprocess.run([sys.executable, SCRIPT, "--root", self.root, *options], check=True, capture_output=True,
                                text=True)
        self.said = result.stderr
        return result.stdout.split("\0")[:-1]

    def test_the_first_commit_has_nothing_before_it(self):
        self.assertEqual(self.changed(), [])
        self.assertIn("no commit to compare with", self.said)

    def test_on_main_what_the_last_commit_changed(self):
        self.commit(**{"rom/a.cpp": "int a;\n"})
        self.commit(**{"rom/c.cpp": "int d;\n", "README.md": "text\n", "tests/t.cpp": "int t;\n"})
        self.assertEqual(self.changed(), ["rom/c.cpp"])

    def test_on_a_branch_all_since_it_left_main_and_what_is_not_committed(self):
        self.git("update-ref", "refs/remotes/origin/main", "HEAD")
        self.commit(**{"rom/c.cpp": "int d;\n"})
        self.commit(**{"firmware/e.cpp": "int e;\nint f;\n"})
        self.assertEqual(self.changed(), ["firmware/e.cpp", "rom/c.cpp"])
        self.write(**{"rom/a.cpp": "int a;\n" * 3})
        self.assertEqual(self.changed(), ["rom/a.cpp", "firmware/e.cpp", "rom/c.cpp"])

    def test_a_header_counts_by_a_source_that_includes_it(self):
        self.commit(**{"rom/b.hpp": "int changed;\n"})
        self.assertEqual(self.changed(), ["rom/a.cpp"])
        self.commit(**{"rom/b.cpp": "int own;\n"})
        self.commit(**{"rom/b.hpp": "int b;\n", "rom/lonely.hpp": "int l;\n"})
        self.assertEqual(self.changed(), ["rom/b.cpp"])

    def test_what_is_gone_is_not_judged(self):
        self.git("rm", "--quiet", "rom/c.cpp")
        self.git("commit", "--quiet", "--message", "m")
        self.assertEqual(self.changed(), [])

    def test_of_many_those_with_most_new_lines(self):
        self.commit(**{"rom/a.cpp": "int a;\n", "rom/c.cpp": "int d;\n" * 5, "rom/d.cpp": "int d;\n" * 3})
        self.assertEqual(self.changed("--most", "2"), ["rom/c.cpp", "rom/d.cpp"])
        self.assertIn("3 have changed", self.said)


if __name__ == "__main__":
    unittest.main()
