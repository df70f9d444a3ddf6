#!/usr/bin/env python3
"""Whether functions and structs of the product stay small enough to be read.

  check_sizes.py [--root FOLDER]   fails, and names each that is too large

A function has as many lines and parameters at the most as `.clang-tidy` says (readability-function-size, which judges them
too, but only where clang-tidy runs), a struct or class twelve public members, static ones aside. One that has more says
why, on the line that names it or the one before it:
    NOLINT(readability-function-size): reason        NOLINT(public-members): reason
A reason that nothing needs any more fails too. Universal Ctags reads the sources; functions that are only declared are
another's, or judged where they are defined. It overlooks members with an initial value such as `= Type{...}`, of which the
tree has three.
"""
import collections
import json
import re
import subprocess

import checker

MOST_MEMBERS = 12
FUNCTION, MEMBERS = "readability-function-size", "public-members"
ALLOWANCE = re.compile(rf"NOLINT(NEXTLINE)?\(({FUNCTION}|{MEMBERS})\)(:? *)(\S*)")
CTAGS = ["ctags", "--quiet", "--output-format=json", "--languages=C,C++", "--kinds-C=fm", "--kinds-C++=fmsc", "--map-C=-.h",
         "--map-C++=+.h", "--fields=+neaS", "--fields-C++=+{properties}", "-L", "-", "-f", "-"]


def limit(root, option):
    """A threshold of .clang-tidy."""
    found = re.search(rf"{FUNCTION}\.{option}, *value: *(\d+)", (root / ".clang-tidy").read_text())
    if not found:
        raise checker.CannotCheck(f"{root / '.clang-tidy'} has no {FUNCTION}.{option}")
    return int(found[1])


def tags(paths):
    try:
        said = subprocess.run(CTAGS, input="\n".join(map(str, paths)), capture_output=True, text=True, check=True).stdout
    except (FileNotFoundError, subprocess.CalledProcessError) as error:
        raise checker.CannotCheck(f"needs Universal Ctags (Debian: universal-ctags): {error}") from None
    return [json.loads(line) for line in said.splitlines()]


def parameters(signature):
    """How many the list in parentheses names."""
    depth, commas, inner = 0, 0, signature.strip()[1:-1].strip()
    for letter in inner:
        depth += (letter in "([{<") - (letter in ")]}>")
        commas += letter == "," and depth == 0
    return 0 if inner in ("", "void") else commas + 1


class Allowances:
    """The reasons that stand in the sources."""

    def __init__(self, paths):
        self.lines, self.unused, self.bare = {}, {}, []
        for path in paths:
            for number, line in enumerate(path.read_text(errors="replace").splitlines(), 1):
                found = ALLOWANCE.search(line)
                if found:
                    next_line, check, colon, reason = found.groups()
                    self.lines[str(path), number + bool(next_line), check] = number
                    self.unused[str(path), number, check] = None
                    if not (colon.startswith(":") and reason):
                        self.bare.append((str(path), number, check))

    def has(self, path, line, check):
        number = self.lines.get((path, line, check))
        if number is not None:
            self.unused.pop((path, number, check), None)
        return number is not None


def complaints(root, _):
    """Lines "file:line: what is too large", and how many functions and structs were read."""
    paths = list(checker.sources_of(root, checker.room_folders(root)))
    most_lines, most_parameters = limit(root, "LineThreshold"), limit(root, "ParameterThreshold")
    allowed = Allowances(paths)
    found, members, structs, functions = [], collections.Counter(), {}, 0

    def complain(path, line, check, what):
        if not allowed.has(path, line, check):
            found.append((path, line, f"{what}, or the reason beside it: NOLINT({check}): ..."))

    for tag in tags(paths):
        place = tag["path"], tag["line"]
        if tag["kind"] == "function":
            functions += 1
            lines, count = tag.get("end", tag["line"]) - tag["line"] + 1, parameters(tag.get("signature", "()"))
            if lines > most_lines:
                complain(*place, FUNCTION, f"{tag['name']} has {lines} lines, at the most {most_lines}")
            if count > most_parameters:
                complain(*place, FUNCTION, f"{tag['name']} has {count} parameters, at the most {most_parameters}")
        elif tag["kind"] in ("struct", "class"):
            structs[tag["path"], f"{tag['scope']}::{tag['name']}" if "scope" in tag else tag["name"]] = tag["line"]
        elif tag.get("access") == "public" and "static" not in tag.get("properties", ""):
            members[tag["path"], tag["scope"]] += 1
    for (path, name), count in members.items():
        if count > MOST_MEMBERS and (path, name) in structs:
            complain(path, structs[path, name], MEMBERS,
                     f"{name.rpartition('::')[2]} has {count} public members, at the most {MOST_MEMBERS}")
    found += [(path, line, f"NOLINT({check}) without a reason behind a colon") for path, line, check in allowed.bare]
    found += [(path, line, f"nothing needs NOLINT({check}) here") for path, line, check in allowed.unused]
    start = len(str(root)) + 1
    return [f"{path[start:]}:{line}: {what}" for path, line, what in sorted(found)], functions + len(structs)


if __name__ == "__main__":
    checker.main("check_sizes", __doc__, complaints, "{count} functions and structs are small enough or say why not")
