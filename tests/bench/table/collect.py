#!/usr/bin/env python3
"""Runs everything that gives a row, prints the table of this run and writes it as a page. Called by tests/bench/run.

  tests/bench/run [--only NAME,...]     names: fem, solvers, network, build, ngspice, estimator, cycle, registers

Only what is printed by a program started here, and carries this run's name, becomes a row. A peer that is missing or fails
is a row that says so; a program of ours that fails is one too, and makes this end with 1.
"""
import argparse
import dataclasses
import json
import pathlib
import secrets
import subprocess
import sys
import tempfile

import builds
import machine
import page
import peers
import rows
import table

OWN = {"fem": "FE model", "network": "Network", "estimator": "Daemon", "cycle": "Daemon", "registers": "Registers by Modbus/TCP"}
PEERS = {"solvers": (peers.solver_rows, peers.SOLVERS), "ngspice": (peers.netlist_rows, peers.NETLISTS),
         "build": (builds.build_rows, builds.GROUP)}
ORDER = ("fem", "solvers", "network", "ngspice", "build", "estimator", "cycle", "registers")


class Failed(Exception):
    """Why a program of ours gave no rows."""


def own_rows(name, run, programs):
    command = [programs / "bench_rows", "--run", run, "--group", name]
    if name == "registers":
        command += ["--daemon", programs / "spindle-twind"]
    done = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        raise Failed((done.stderr.strip() or f"ended with {done.returncode}").splitlines()[-1])
    return rows.read_rows(done.stdout, run, f"bench_rows --group {name}")


def peer_rows(name, run, programs):
    produce, _ = PEERS[name]
    with tempfile.TemporaryDirectory() as folder:
        made = produce(programs / "spindle-twin", programs / "bench_rows", pathlib.Path(folder))
        return [rows.read_row({"run": run, **fields}, run, f"{name}, row {number}") for number, fields in enumerate(made, 1)]


def rows_of(name, run, programs):
    """Its rows, and whether a program of ours failed."""
    try:
        return (own_rows if name in OWN else peer_rows)(name, run, programs), False
    except (Failed, peers.NotMeasured, rows.RowError, OSError) as error:
        print(f"tests/bench/run: {name}: {error}", file=sys.stderr)
        group = OWN[name] if name in OWN else PEERS[name][1]
        return [rows.Row(run=run, group=group, name=f"rows of '{name}'", kind="bound", other_name="–",
                         not_measured=str(error))], True


def names(text):
    chosen = text.split(",")
    for name in chosen:
        if name not in ORDER:
            raise argparse.ArgumentTypeError(f"'{name}' is none of {', '.join(ORDER)}")
    return [name for name in ORDER if name in chosen]


def main():
    parser = argparse.ArgumentParser(prog="tests/bench/run", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, required=True, help=argparse.SUPPRESS)
    parser.add_argument("--only", type=names, default=list(ORDER), metavar="NAME,...")
    options = parser.parse_args()
    run = secrets.token_hex(8)
    facts = machine.facts(options.only != list(ORDER) and f"--only {','.join(options.only)}")
    collected, failed = [], False
    for name in options.only:
        print(f"measuring {name}", file=sys.stderr, flush=True)
        more, did_fail = rows_of(name, run, (options.build / "bin").resolve())
        collected += more
        failed = failed or did_fail
    facts["load"] = f"{facts['load']} before, {machine.load()} after"
    for name, value in facts.items():
        print(f"{name:<8} {value}")
    print(f"\n{table.text_table(collected)}", end="")
    target = options.build / "bench.html"
    target.write_text(page.page_of(facts, collected), encoding="utf-8")
    print(f"\n{target}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
