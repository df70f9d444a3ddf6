#!/usr/bin/env python3
"""The product's sources that have changed, for clang-tidy: names with a zero byte behind each.

  changed_sources.py [--root FOLDER] [--most N]

Changed, in commits or not yet committed, since the branch left the remote's main branch; on that branch itself since the
commit before (of a merge: its first parent). A changed header counts by one source: that of its name, else
one that includes it. At the most N (8), those first in which most lines are new; the rest is left to `tests/lint all`.
"""
import argparse
import pathlib
import subprocess
import sys

FOLDERS = ("rom", "correction", "firmware", "fem_offline", "host_tools")


def git(root, *words):
    """What git says; None where it fails: no such commit, or no repository."""
    result = subprocess.run(["git", "-C", root, *words], capture_output=True, text=True)
    return result.stdout.strip() if result.returncode == 0 else None


def base(root):
    """The commit to compare with; None: there is none."""
    head = git(root, "rev-parse", "HEAD")
    left = next((found for branch in ("origin/HEAD", "origin/main") if (found := git(root, "merge-base", "HEAD", branch))), head)
    return left if left != head else git(root, "rev-parse", "--verify", "HEAD^")


def source_of(root, header):
    """A source in which clang-tidy sees the header; None: nothing includes it."""
    own = pathlib.PurePath(header).with_suffix(".cpp")
    if (root / own).is_file():
        return str(own)
    users = git(root, "grep", "-lF", f'#include "{header}"', "--", *(f"{folder}/*.cpp" for folder in FOLDERS))
    return users.splitlines()[0] if users else None


def changed(root, since):
    """The sources, most new lines first."""
    lines = {}
    said = git(root, "diff", "--numstat", "--no-renames", "--diff-filter=d", since, "--", *FOLDERS) or ""
    for added, _, path in (row.split("\t") for row in said.splitlines()):
        source = source_of(root, path) if path.endswith(".hpp") else path
        if source and source.endswith(".cpp"):
            lines[source] = lines.get(source, 0) + int(added)
    return sorted(lines, key=lambda source: (-lines[source], source))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[1])
    parser.add_argument("--most", type=int, default=8)
    options = parser.parse_args()
    since = base(options.root)
    if since is None:
        print("changed_sources: no commit to compare with, so none has changed", file=sys.stderr)
        return
    sources = changed(options.root, since)
    if len(sources) > options.most:
        print(f"changed_sources: {len(sources)} have changed since {since[:12]}; the {options.most} with most new lines",
              file=sys.stderr)
    sys.stdout.write("".join(source + "\0" for source in sources[:options.most]))


if __name__ == "__main__":
    main()
