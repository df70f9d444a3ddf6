"""What the checks of the tree's sources have in common."""
import argparse
import pathlib
import sys
import tomllib

SOURCES = (".cpp", ".hpp", ".h")


class CannotCheck(Exception):
    """What there is to check cannot be read."""


def room_folders(root):
    """The topmost folders that rooms.toml names."""
    with open(root / "rooms.toml", "rb") as file:
        return sorted({room["path"].split("/")[0] for room in tomllib.load(file)["room"]})


def sources_of(root, folders):
    for folder in folders:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in SOURCES and path.is_file():
                yield path


def main(name, description, complaints, clean):
    """Runs complaints(root, generated), which gives lines "file:line: what is wrong" and how much was read; fails with the
    lines, or says `clean` with the number in place of {count}."""
    here = pathlib.Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=pathlib.Path, default=here)
    parser.add_argument("--generated", type=pathlib.Path)
    options = parser.parse_args()
    try:
        found, count = complaints(options.root, options.generated or options.root / "build" / "generated")
    except (CannotCheck, KeyError, tomllib.TOMLDecodeError) as error:
        sys.exit(f"{name}: {error}")
    if found:
        sys.exit("\n".join(found))
    if count == 0:
        sys.exit(f"{name}: nothing found below {options.root}")
    print(clean.format(count=count))
