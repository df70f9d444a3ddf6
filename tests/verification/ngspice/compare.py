#!/usr/bin/env python3
"""Rises, outlets of coolant and deformations of ngspice on an exported netlist beside those of spindle-twin simulate.
compare.py NAME NETWORK.json NGSPICE.data SIMULATION.csv LIMIT_K LIMIT_UM: prints the largest difference of each output and
of all temperatures; 1 if one is over its limit."""
import bisect
import csv
import json
import sys

name, network, ngspice, simulation, limit_K, limit_um = sys.argv[1:]
reference_degC = json.load(open(network))["reference_temperature_degC"]


def node(kind, text):
    return f"v({kind}_" + "".join(c if c.isalnum() and c.isascii() else "_" for c in text.lower()) + ")"


with open(ngspice) as file:
    names = file.readline().split()
    rows = [list(map(float, line.split())) for line in file if line.strip()]
times = [row[0] for row in rows]


def spice_at(column, time_s):
    """Cubic through the four points around: the points lie as far apart as the solution allows."""
    first = min(max(bisect.bisect_left(times, time_s) - 2, 0), len(times) - 4)
    near = range(first, first + 4)
    value = 0.0
    for i in near:
        weight = 1.0
        for k in near:
            if k != i:
                weight *= (time_s - times[k]) / (times[i] - times[k])
        value += weight * rows[i][column]
    return value


worst = {}
with open(simulation, newline="") as file:
    for row in csv.DictReader(file):
        time_s = float(row["time_s"])
        if time_s == 0.0:
            continue
        for column, text in row.items():
            for kind, suffix, shift in (("key", "_degC", reference_degC), ("outlet", "_outlet_degC", reference_degC),
                                        ("deformation", "_um", 0.0)):
                wanted = node(kind, column.removesuffix(suffix))
                if column.endswith(suffix) and wanted in names:
                    error = abs(spice_at(names.index(wanted), time_s) - (float(text) - shift))
                    worst[wanted] = max(worst.get(wanted, 0.0), error)
assert worst, "the two have no output in common"
failed = False
for wanted, error in worst.items():
    unit, limit = ("um", float(limit_um)) if wanted.startswith("v(deformation") else ("K", float(limit_K))
    failed |= not error <= limit
    print(f"{name:10} {wanted:28} largest difference {error:.2e} {unit} over {times[-1]:.0f} s, {len(times)} points")
largest_K = max((error for wanted, error in worst.items() if not wanted.startswith("v(deformation")), default=0.0)
print(f"{name}: largest difference {largest_K:.2e} K")
sys.exit(1 if failed else 0)
