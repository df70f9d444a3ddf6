"""The check of includes fails where a source relies on a precompiled header."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
CMAKE = "set(spindle_twin_common_headers ${PROJECT_SOURCE_DIR}/cmake/eigen_kernels.hpp <map> <vector>)\n"


class Includes(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.write("rooms.toml", '[[room]]\npath = "low"\nwhy = "w"\n')
        self.write("cmake/rooms.cmake", CMAKE)

    def write(self, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def check(self):
        return subprocess.run([sys.executable, HERE / "check_includes.py", "--root", self.root, "--generated",
                               self.root / "generated"], capture_output=True, text=True)

    def complaints(self, code):
        self.write("low/a.cpp", code)
        result = self.check()
        self.assertEqual(result.returncode, 1 if result.stderr else 0, result.stderr)
        return result.stderr.strip().splitlines()

    def test_a_name_without_its_header_is_named_with_file_and_line(self):
        self.assertEqual(self.complaints("#include <string>\n\nstd::string a;\nstd::map<int, int> b;\n"),
                         ["low/a.cpp:4: uses std::map without #include <map>"])

    def test_a_header_of_this_tree_may_give_it(self):
        self.write("low/b.hpp", "#include <map>\n")
        self.write("low/c.hpp", '#include "low/b.hpp"\n')
        self.assertEqual(self.complaints('#include "low/c.hpp"\nstd::map<int, int> b;\n'), [])

    def test_a_generated_header_may_give_it(self):
        self.write("generated/low/b.hpp", "#include <map>\n")
        self.assertEqual(self.complaints('#include "low/b.hpp"\nstd::map<int, int> b;\n'), [])

    def test_a_library_may_not(self):
        self.assertEqual(self.complaints("#include <Eigen/Core>\nstd::map<int, int> b;\n"),
                         ["low/a.cpp:2: uses std::map without #include <map>"])

    def test_comments_and_texts_use_nothing(self):
        self.assertEqual(self.complaints('// std::map\n/* std::map\n */ const char* a = "std::map \\" std::map";\n'), [])

    def test_a_digit_separator_starts_no_text(self):
        self.assertEqual(self.complaints("int a = 1'000;\nstd::map<int, int> b;\nint c = 2'000;\n"),
                         ["low/a.cpp:2: uses std::map without #include <map>"])

    def test_a_decomposition_needs_its_own_module(self):
        self.assertEqual(self.complaints("#include <Eigen/Core>\nEigen::VectorXd x = a.partialPivLu().solve(b);\n"),
                         ["low/a.cpp:2: uses .partialPivLu() without #include <Eigen/LU>"])

    def test_a_precompiled_header_that_the_check_does_not_know(self):
        self.write("cmake/rooms.cmake", CMAKE.replace("<map>", "<map> <deque>"))
        self.assertEqual(self.complaints("int a;\n"),
                         ["check_includes.py: NEEDED has no line for <deque>, which is precompiled"])

    def test_nothing_read_is_no_success(self):
        self.assertIn("nothing found", self.check().stderr)


class ThisTree(unittest.TestCase):
    def test_a_header_taken_out_of_a_source_is_missed(self):
        sys.path.insert(0, str(HERE))
        import check_includes
        name = "rom/read/csv_table.cpp"
        text = (ROOT / name).read_text()
        for header in ("algorithm", "fstream"):
            with self.subTest(header), tempfile.TemporaryDirectory() as folder:
                root = pathlib.Path(folder)
                (root / name).parent.mkdir(parents=True)
                (root / name).write_text(text.replace(f"#include <{header}>\n", ""))
                tree = check_includes.Tree(root, ROOT)  # the rest of the tree as it stands
                self.assertIn(f"#include <{header}>", text)
                self.assertIn(f"without #include <{header}>", "\n".join(check_includes.complaints_of(name, tree)))


if __name__ == "__main__":
    unittest.main()
