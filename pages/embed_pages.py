#!/usr/bin/env python3
"""Makes each page one text that needs nothing else, and writes these texts as C++.

  embed_pages.py --cpp FOLDER --in ROOM --library NAME=FOLDER PAGE.html...   FOLDER/page_texts.hpp and .cpp, included as
                                                                           ROOM/page_texts.hpp; FOLDER ends with ROOM
  embed_pages.py --html PAGE.html --library NAME=FOLDER                      one page to stdout
  with --served: a page for a server, as three texts: PAGE_html, PAGE_css and PAGE_js

A style sheet (<link rel="stylesheet" href>) or script (<script src>) is replaced by its text. A script of type module
comes with all that it imports, each file once and before those that use it: imports are of names from "./file.js" beside
the importing file, one line each, and all files of a page share one scope. Paths that begin with the NAME of a library
are taken from its folder. The element <script id="data"> stays empty: the program writes the data there. A served page
has none, and loads its one style sheet and its one script, into which all are put together, from beside itself: PAGE.css
and PAGE.js.
"""
import argparse
import pathlib
import posixpath
import re
import sys

STYLE = re.compile(r'[ \t]*<link rel="stylesheet" href="([^"]+)">\n')
SCRIPT = re.compile(r'<script( type="module")? src="([^"]+)"></script>')
IMPORT = re.compile(r'^import \{[^}]*\} from "\./([^"]+)";\n', re.MULTILINE)
EXPORT = re.compile(r"^export (?=(?:const|function) )", re.MULTILINE)
DECLARED = re.compile(r"^(?:export )?(?:(?:async )?function\*? (\w+)|(?:const|let) (.*))", re.MULTILINE)
BRACKETS = re.compile(r"\([^()]*\)|\[[^][]*\]|\{[^{}]*\}")
DATA = '<script id="data" type="application/json"></script>'
DELIMITER = "page_text"


class PageError(Exception):
    pass


class Files:
    def __init__(self, folder, libraries):
        self.folder, self.libraries = folder, libraries

    def text(self, path):
        first, _, rest = path.partition("/")
        file = self.libraries[first] / rest if first in self.libraries else self.folder / path
        try:
            return file.read_text(encoding="utf-8")
        except OSError as error:
            raise PageError(f"{file}: cannot be read: {error.strerror}") from error


def modules(files, path, seen):
    """The module's text after those of all that it imports."""
    if path in seen:
        return ""
    seen[path] = text = files.text(path)
    beside = posixpath.dirname(path)
    before = "".join(modules(files, posixpath.join(beside, imported), seen) for imported in IMPORT.findall(text))
    own = EXPORT.sub("", IMPORT.sub("", text))
    left_over = re.search(r"^\s*(import|export)\b.*", own, re.MULTILINE)
    if left_over:
        raise PageError(f"{path}: '{left_over.group().strip()}': allowed are import {{ ... }} from \"./file.js\"; in one line, "
                        "export const and export function")
    return f"{before}// {path}\n{own}"


def own_names(text):
    """What a file declares for all; of a list in one line each name."""
    for function, line in DECLARED.findall(text):
        while BRACKETS.search(line):
            line = BRACKETS.sub("", line)
        yield from [function] if function else re.findall(r"(?:^|, )(\w+)(?= =[^=>]|,|;)", line)


def one_scope(seen):
    """Fails where two files of a page give a name of their own the same spelling."""
    owner = {}
    for path, text in seen.items():
        for name in own_names(text):
            if owner.setdefault(name, path) != path:
                raise PageError(f"{path}: '{name}' is a name of {owner[name]} too; all files of a page share one scope")


def script(files, path, is_module):
    if is_module:
        seen = {}
        text = modules(files, path, seen)
        one_scope(seen)
    else:
        text = files.text(path)
    # Inside a script element no text may close it or open a comment; in a string \/ and \! are the same characters.
    return text.replace("</script", "<\\/script").replace("<!--", "<\\!--").strip()


def whole_page(files, name):
    text = files.text(name)
    if text.count(DATA) != 1:
        raise PageError(f"{name}: {DATA} must stand there once")
    text = STYLE.sub(lambda found: f"<style>\n{files.text(found[1]).strip()}\n</style>\n", text)
    text = SCRIPT.sub(lambda found: f"<script{found[1] or ''}>\n{script(files, found[2], found[1])}\n</script>", text)
    loaded = re.search(r'<(?:link|script|img|iframe)\b[^>]*\b(?:href|src)=', text)
    if loaded:
        raise PageError(f"{name}: '{loaded.group()}': a page loads nothing")
    return text


def served_page(files, name):
    """HTML, style and script of a page that a server gives: {"html": ..., "css": ..., "js": ...}."""
    text, stem = files.text(name), pathlib.PurePath(name).stem
    styles, scripts = STYLE.findall(text), SCRIPT.findall(text)
    if not styles or not scripts or not scripts[-1][0]:
        raise PageError(f"{name}: a style sheet and, as last script, one of type module must stand there")
    last = {"style": styles[-1], "script": scripts[-1][1]}
    html = STYLE.sub(lambda found: f'  <link rel="stylesheet" href="{stem}.css">\n' if found[1] == last["style"] else "", text)
    html = re.sub(SCRIPT.pattern + r"\n", lambda found: f'<script type="module" src="{stem}.js"></script>\n'
                  if found[2] == last["script"] else "", html)
    return {"html": html, "css": "\n".join(files.text(path).strip() for path in styles) + "\n",
            "js": "\n".join(script(files, path, is_module) for is_module, path in scripts) + "\n"}


def cpp_texts(pages, room):
    """Header and source that hold the pages, {name: text}."""
    about = "// Made by pages/embed_pages.py.\n"
    namespace = "spindle_twin::" + room.split("/")[0]
    names = "".join(f"extern const std::string_view {name}_text;\n" for name in pages)
    header = f"{about}#pragma once\n\n#include <string_view>\n\nnamespace {namespace} {{\n\n{names}\n}}\n"
    source = f'{about}#include "{room}/page_texts.hpp"\n\nnamespace {namespace} {{\n\n'
    for name, text in pages.items():
        if f"){DELIMITER}\"" in text:
            raise PageError(f"{name}: holds the mark that ends a text")
        source += f'const std::string_view {name}_text = R"{DELIMITER}({text}){DELIMITER}";\n'
    return header, source + "\n}\n"


def all_texts(paths, libraries, is_served):
    """{name: text} of the pages."""
    texts = {}
    for path in paths:
        files = Files(path.parent, libraries)
        if is_served:
            texts |= {f"{path.stem}_{kind}": text for kind, text in served_page(files, path.name).items()}
        else:
            texts[path.stem] = whole_page(files, path.name)
    return texts


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cpp", type=pathlib.Path, metavar="FOLDER")
    parser.add_argument("--in", dest="room", default="host_tools/pages", metavar="ROOM")
    parser.add_argument("--served", action="store_true")
    parser.add_argument("--html", action="store_true")
    parser.add_argument("--library", action="append", default=[], metavar="NAME=FOLDER")
    parser.add_argument("pages", nargs="+", type=pathlib.Path)
    options = parser.parse_args()
    libraries = {name: pathlib.Path(folder) for name, _, folder in (entry.partition("=") for entry in options.library)}
    try:
        texts = all_texts(options.pages, libraries, options.served)
        if options.html:
            sys.stdout.write("".join(texts.values()))
        if options.cpp:
            header, source = cpp_texts(texts, options.room)
            options.cpp.mkdir(parents=True, exist_ok=True)
            (options.cpp / "page_texts.hpp").write_text(header, encoding="utf-8")
            (options.cpp / "page_texts.cpp").write_text(source, encoding="utf-8")
    except PageError as error:
        sys.exit(f"embed_pages.py: {error}")


if __name__ == "__main__":
    main()
