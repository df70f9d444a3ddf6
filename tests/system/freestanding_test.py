#!/usr/bin/env python3
"""freestanding_test.py LIBRARY: the example node's library needs nothing but nanopb and what every C compiler has."""
import subprocess
import sys

ALLOWED = {"memcpy", "memset", "memmove", "__stack_chk_fail", "_GLOBAL_OFFSET_TABLE_"}

undefined = subprocess.run(["nm", "--undefined-only", "--format=posix", sys.argv[1]], capture_output=True, text=True,
                           check=True).stdout
names = {line.split()[0] for line in undefined.splitlines() if line and not line.endswith(":")}
foreign = {name for name in names if name not in ALLOWED and not name.startswith(("pb_", "spindle_twin_stream_"))}
sanitizers = {name for name in foreign if name.startswith(("__asan", "__ubsan", "__tsan", "__sanitizer"))}
if not any(name.startswith("pb_") for name in names):
    sys.exit("it does not even call nanopb: " + ", ".join(sorted(names)))
if foreign - sanitizers:
    sys.exit("it needs an operating system's " + ", ".join(sorted(foreign - sanitizers)))
