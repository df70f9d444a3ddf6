"""A page becomes one file that loads nothing, or the generator says why not."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

GENERATOR = pathlib.Path(__file__).resolve().parents[2] / "pages" / "embed_pages.py"
PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
  <link rel="stylesheet" href="lib/a.css">
</head>
<body>
<script id="data" type="application/json"></script>
<script src="lib/a.js"></script>
<script type="module" src="page.js"></script>
</body>
</html>
"""


class EmbedPages(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "library").mkdir()
        self.write("page.html", PAGE)
        self.write("library/a.css", "b { color: red; }")
        self.write("library/a.js", "var lib = '</script><!-- x';")
        self.write("page.js", 'import { one } from "./one.js";\nimport { two } from "./two.js";\nconst sum = one + two;\n')
        self.write("one.js", "export const one = 1;\n")
        self.write("two.js", 'import { one } from "./one.js";\nexport const two = one + 1;\n')

    def write(self, name, text):
        (self.folder / name).write_text(text)

    def run_generator(self, *words):
        command = [sys.executable, GENERATOR, "--library", f"lib={self.folder}/library", *words, self.folder / "page.html"]
        return subprocess.run(command, capture_output=True, text=True, timeout=60)

    def error(self):
        result = self.run_generator("--html")
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        return result.stderr

    def test_style_library_and_modules_stand_in_the_page_each_once_and_in_order(self):
        text = self.run_generator("--html").stdout
        self.assertIn("<style>\nb { color: red; }\n</style>", text)
        self.assertIn("var lib = '<\\/script><\\!-- x';", text)
        self.assertEqual(text.count("const one = 1;"), 1)
        order = [text.index(words) for words in ("const one", "const two", "const sum")]
        self.assertEqual(order, sorted(order))
        self.assertNotRegex(text, r"(?m)^(import|export)|src=|href=")

    def test_a_module_of_a_library_imports_those_beside_it(self):
        self.write("library/three.js", 'import { four } from "./four.js";\nexport const three = four - 1;\n')
        self.write("library/four.js", "export const four = 4;\n")
        self.write("four.js", "export const wrong = 0;\n")
        self.write("page.js", 'import { three } from "./lib/three.js";\nconst sum = three;\n')
        text = self.run_generator("--html").stdout
        order = [text.index(words) for words in ("const four", "const three", "const sum")]
        self.assertEqual(order, sorted(order))
        self.assertNotIn("wrong", text)

    def test_the_texts_in_cpp_are_the_pages(self):
        page = self.run_generator("--html").stdout
        self.assertEqual(self.run_generator("--cpp", self.folder / "out").returncode, 0)
        self.assertIn(page, (self.folder / "out" / "page_texts.cpp").read_text())
        self.assertIn("extern const std::string_view page_text;", (self.folder / "out" / "page_texts.hpp").read_text())

    def test_a_served_page_is_three_texts_that_know_each_other(self):
        served = PAGE.replace('<script id="data" type="application/json"></script>\n', "")
        served = served.replace("</head>", '  <link rel="stylesheet" href="own.css">\n</head>')
        self.write("page.html", served)
        self.write("own.css", "i { color: blue; }")
        out = self.folder / "firmware" / "show"
        result = self.run_generator("--served", "--cpp", out, "--in", "firmware/show")
        self.assertEqual(result.returncode, 0, result.stderr)
        text = (out / "page_texts.cpp").read_text()
        self.assertIn("namespace spindle_twin::firmware {", text)
        self.assertEqual((text.count('href="page.css"'), text.count("href=")), (1, 1))
        self.assertEqual((text.count('src="page.js"'), text.count("src=")), (1, 1))
        order = [text.index(words) for words in ("b { color: red; }", "i { color: blue; }", "var lib", "const one", "const sum")]
        self.assertEqual(order, sorted(order))

    def test_one_name_in_two_files_is_refused(self):
        self.write("two.js", "const one = 3;\nexport const two = one;\n")
        self.assertIn("two.js: 'one' is a name of one.js too", self.error())

    def test_a_name_that_is_not_the_first_of_its_line_counts_too(self):
        self.write("two.js", "const width = Math.max(1, 2), one = 3;\nexport const two = one + width;\n")
        self.assertIn("two.js: 'one' is a name of one.js too", self.error())

    def test_other_imports_are_refused(self):
        self.write("two.js", 'import two from "https://example.org/two.js";\nexport { two };\n')
        self.assertIn("two.js: 'import two from", self.error())

    def test_what_would_be_loaded_is_refused(self):
        self.write("page.html", PAGE.replace("<body>", '<body>\n<img src="a.png" alt="">'))
        self.assertIn("a page loads nothing", self.error())

    def test_a_page_without_a_place_for_data_is_refused(self):
        self.write("page.html", PAGE.replace(' id="data"', ""))
        self.assertIn("must stand there once", self.error())

    def test_a_missing_file_is_named(self):
        (self.folder / "one.js").unlink()
        self.assertIn("one.js: cannot be read", self.error())


if __name__ == "__main__":
    unittest.main()
