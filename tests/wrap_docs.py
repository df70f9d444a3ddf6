#!/usr/bin/env python3
"""Lines of documents: at most 120 characters outside tables and code.

  tests/wrap_docs.py           names each longer line and fails
  tests/wrap_docs.py --write   breaks the paragraphs and list entries that hold one anew; the words stay

Of all Markdown files of the repository but those that a generator writes (their second line says so).
"""
import pathlib
import re
import subprocess
import sys
import textwrap

ROOT = pathlib.Path(__file__).resolve().parents[1]
LONGEST = 120
OF_ITS_OWN = re.compile(r"\s*(\||#|```|!\[|<!--|---)|    |\t|\s*$")  # table, heading, fence, picture, code, nothing
ENTRY = re.compile(r"(\s*)([-*]|\d+\.)(\s+)")


def documents():
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.md"], cwd=ROOT, check=True,
                            capture_output=True, text=True).stdout.split()
    for name in listed:
        lines = (ROOT / name).read_text().splitlines()
        if not any("generate" in line.lower() for line in lines[:4]):
            yield name, lines


def blocks(lines):
    """Lists of lines that flow into each other; a line of its own is a list of one with False beside it."""
    flowing, fenced = [], False
    for line in lines:
        fence = line.lstrip().startswith("```")
        own = fenced or fence or (OF_ITS_OWN.match(line) and not (flowing and line.startswith("    ") and ENTRY.match(flowing[0])))
        if fence:
            fenced = not fenced
        if own or ENTRY.match(line):
            if flowing:
                yield flowing, True
            flowing = []
        if own:
            yield [line], False
        else:
            flowing.append(line)
    if flowing:
        yield flowing, True


def wrapped(block):
    """Narrower where a line would begin like an entry, a heading or a table."""
    entry = ENTRY.match(block[0])
    first = entry.group(0) if entry else re.match(r"\s*", block[0]).group(0)
    words = " ".join([block[0][len(first):]] + [line.strip() for line in block[1:]])
    for width in range(LONGEST, LONGEST - 40, -1):
        lines = textwrap.wrap(words, width, initial_indent=first, subsequent_indent=" " * len(first), break_long_words=False,
                              break_on_hyphens=False)
        if not any(ENTRY.match(line) or OF_ITS_OWN.match(line.strip()) for line in lines[1:]):
            return lines
    raise ValueError(f"no way to break: {words}")


def main():
    long_lines = 0
    for name, lines in documents():
        result = []
        for block, flows in blocks(lines):
            too_long = flows and any(len(line) > LONGEST for line in block)
            long_lines += too_long
            if too_long and "--write" not in sys.argv:
                print(f"{name}:{len(result) + 1}: a line of more than {LONGEST} characters; tests/wrap_docs.py --write breaks it")
            result += wrapped(block) if too_long and "--write" in sys.argv else block
        if result != lines:
            (ROOT / name).write_text("\n".join(result) + "\n")
    if long_lines and "--write" not in sys.argv:
        sys.exit(1)


if __name__ == "__main__":
    main()
