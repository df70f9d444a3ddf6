#!/usr/bin/env python3
"""A log of sensors for a replay, from a simulated machine that is warmer or colder than its twin believes.

make_log.py TWIN NETWORK.rom SCHEDULE.csv LOG.csv: the machine is the network itself with 0.7 of the schedule's load, of
which the log says nothing; every key point is a sensor with 0.03 K of noise (seed 1), read every 10 s.
"""
import csv
import json
import pathlib
import random
import subprocess
import sys

HEAT_OF_THE_MACHINE = 0.7
NOISE_K = 0.03

twin, network, schedule, log = sys.argv[1:]
with open(schedule, newline="") as file:
    drive = list(csv.DictReader(file))
hidden = pathlib.Path(log).with_suffix(".machine.csv")
with open(hidden, "w", newline="") as file:
    rows = csv.DictWriter(file, drive[0].keys())
    rows.writeheader()
    rows.writerows({**row, "load": HEAT_OF_THE_MACHINE * float(row["load"])} for row in drive)
truth = hidden.with_suffix(".out")
subprocess.run([twin, "simulate", network, "--schedule", hidden, "-o", truth, "--every", "10"], check=True,
               stdout=subprocess.DEVNULL)
inspected = subprocess.run([twin, "inspect", network, "--json"], check=True, stdout=subprocess.PIPE, text=True).stdout
points = [point["name"] for point in json.loads(inspected)["key_points"]]
flows = [name for name in drive[0] if name.endswith("_kg_per_s")]
random.seed(1)
with open(truth, newline="") as machine, open(log, "w", newline="") as file:
    out = csv.writer(file)
    out.writerow(["time_s", "speed_rpm", "load", *("flow." + name for name in flows),
                  *(f"measured.{name}_degC" for name in points)])
    for row in csv.DictReader(machine):
        now = [step for step in drive[:-1] if float(step["time_s"]) <= float(row["time_s"])][-1]
        out.writerow([row["time_s"], now["speed_rpm"], now["load"], *(now[name] for name in flows),
                      *(f"{float(row[name + '_degC']) + random.gauss(0.0, NOISE_K):.2f}" for name in points)])
