#!/usr/bin/env python3
"""clang-tidy on those of the given sources that differ from when it last found them clean.

A source is the same when its preprocessed text (with comments and macros, which checks read too), its flags,
.clang-tidy and the program are: the digests of clean sources are the names of empty files in build-tidy/clean. Needs the
compile commands and generated headers of build-tidy, which tests/lint makes.
    tests/clang_tidy_changed.py [--quick] FILE...
--quick leaves out the static analyzer, which takes most of the time, and keeps marks of its own.
"""
import concurrent.futures
import hashlib
import json
import os
import pathlib
import shlex
import subprocess
import sys

BUILD = pathlib.Path("build-tidy")
CLEAN = BUILD / "clean"
FOREIGN_FLAGS = "--extra-arg=-Wno-unused-command-line-argument"  # the build folder may hold flags that only GCC knows


def said_by(command, folder="."):
    return subprocess.run(command, cwd=folder, capture_output=True, check=True).stdout


def digest(entry, checks):
    words = shlex.split(entry["command"])
    out = words.index("-o")
    words = words[:out] + words[out + 2:]
    at = words.index("-c")
    words[at:at + 1] = ["-E", "-C", "-dD"]
    if os.path.basename(words[0]) == "ccache":
        words = words[1:]
    return hashlib.sha256(checks + " ".join(words).encode() + said_by(words, entry["directory"])).hexdigest()


def judge(path, entry, checks, options):
    """What clang-tidy says against the source; nothing for a clean one. The last: whether it had to be run."""
    try:
        mark = CLEAN / digest(entry, checks)
    except subprocess.CalledProcessError as error:
        return error.stderr.decode(), False
    if mark.exists():
        return "", False
    result = subprocess.run(["clang-tidy", "-p", BUILD, "--quiet", FOREIGN_FLAGS, *options, path], capture_output=True,
                            text=True)
    if result.returncode == 0:
        mark.touch()
        return "", True
    return result.stdout or result.stderr or f"{path}: clang-tidy ended with {result.returncode}\n", True


def main(paths):
    options = []
    if paths[:1] == ["--quick"]:
        options, paths = ["--checks=-clang-analyzer-*"], paths[1:]
    CLEAN.mkdir(exist_ok=True)
    checks = said_by(["clang-tidy", "--version"]) + pathlib.Path(".clang-tidy").read_bytes() + "".join(options).encode()
    entries = {entry["file"]: entry for entry in json.loads((BUILD / "compile_commands.json").read_text())}
    wanted = [(path, entries[os.path.abspath(path)]) for path in paths if os.path.abspath(path) in entries]
    if len(wanted) < len(paths):
        print(f"clang-tidy: {len(paths) - len(wanted)} sources are of no target here")
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        changed = found = 0
        for text, run in pool.map(lambda source: judge(*source, checks, options), wanted):
            print(text, end="", flush=True)
            changed += run
            found += bool(text)
    print(f"clang-tidy: {changed} of {len(wanted)} sources had changed, {found} with findings")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
