"""What a network costs to build: `spindle-twin build` without options beside a bare factor of the same spindle's FE matrix."""
import json
import os
import pathlib
import subprocess

import peers

SPINDLES = pathlib.Path(__file__).resolve().parents[3] / "fem_offline" / "spindles"
GROUP = "Default build of a network, with its certificate"
ASKED_S = {"reference": 75.0, "four_bearing_milling": 120.0}  # processor time, on the machine of the docs
ASKED_BYTES = 0.6e9
TOLERANCE_MISSED = 3  # the network is written all the same


def cost_of(command, folder):
    """What it prints, its exit code, processor seconds and peak resident bytes. Raises NotMeasured where it fails."""
    with open(folder / "said", "w+", encoding="utf-8") as said, open(folder / "complaints", "w+", encoding="utf-8") as complaints:
        process = subprocess.Popen(list(map(str, command)), cwd=folder, stdin=subprocess.DEVNULL, stdout=said, stderr=complaints)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        complaints.seek(0)
        if process.returncode not in (0, TOLERANCE_MISSED):
            last = (complaints.read().strip() or "no word").splitlines()[-1]
            raise peers.NotMeasured(f"{pathlib.Path(command[0]).name} ended with {process.returncode}: {last}")
        return said.read(), process.returncode, used.ru_utime + used.ru_stime, 1024 * used.ru_maxrss


def rows_of(spindle, built, code, seconds, peak_bytes, bare):
    """The rows of one spindle: `built` is the build's JSON, `bare` that of `bench_rows --factor`."""
    kept = "keeps" if code == 0 else "misses"
    name = f"{spindle}, {built['nodes']} nodes from {bare['unknowns']:,} unknowns"
    asked = f"At most {ASKED_S[spindle]:g} s are asked on the machine of the docs; this network {kept} the tolerance."
    times = {"group": GROUP, "kind": "bound", "ours": seconds, "unit": "s", "clock": "processor"}
    yield {**times, "name": name, "other_name": "bare CHOLMOD: one factorisation", "other": bare["factor_s"], "means": asked}
    yield {**times, "name": name, "other_name": "one bare back-substitution", "other": bare["solve_s"], "means": asked,
           "detail": True}
    yield {"group": GROUP, "kind": "bound", "name": f"{spindle}, peak memory", "other_name": "the bare factor", "ours": peak_bytes,
           "other": bare["bytes"], "unit": "B", "clock": "resident", "detail": True, "goal": ASKED_BYTES / bare["bytes"],
           "means": f"At most {ASKED_BYTES / 1e9:g} GB are asked; the goal is that in factors."}


def build_rows(twin, bench_rows, work):
    """Both spindles, the milling spindle takes some minutes; each build is the command that a user runs, in a process of its own."""
    for spindle in ASKED_S:
        path = SPINDLES / f"{spindle}.toml"
        bare = json.loads(peers.run([bench_rows, "--factor", path], work))
        said, *cost = cost_of([twin, "build", path, "-o", work / f"{spindle}.rom", "--json"], work)
        yield from rows_of(spindle, json.loads(said), *cost, bare)
