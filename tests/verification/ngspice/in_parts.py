#!/usr/bin/env python3
"""ngspice through a schedule with all nodes of a network, row by row: between two rows speed and load stand still, so every
netlist has constant films, which costs ngspice a small part of what films that follow the schedule do. Each part starts from ngspice's own node
voltages at the end of the one before.
in_parts.py SPINDLE-TWIN NETWORK.rom SCHEDULE.csv OUT.data: prints the processor seconds of ngspice. Works in the present folder."""
import csv
import pathlib
import re
import resource
import subprocess
import sys

twin, network, schedule, out = sys.argv[1:]
stem = str(pathlib.Path(out).with_suffix(""))
with open(schedule, newline="") as file:
    header, *rows = list(csv.reader(file))
times = [float(row[0]) for row in rows]
voltages = {}
used_s = 0.0


def processor_seconds():
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return children.ru_utime + children.ru_stime


def run(command, log):
    with open(log, "w") as file:
        if subprocess.run(command, stdout=file, stderr=subprocess.STDOUT, check=False).returncode != 0:
            sys.exit(f"{' '.join(command)} failed, see {log}")


with open(out, "w") as collected:
    for part in range(len(rows) - 1):
        name = f"{stem}.part{part + 1}"
        with open(name + ".csv", "w", newline="") as file:
            csv.writer(file).writerows(
                [header, ["0", *rows[part][1:]], [repr(times[part + 1] - times[part]), *rows[part + 1][1:]]])
        # All nodes: those that a netlist is reduced to differ from part to part.
        run([twin, "export", network, "--spice", name + ".cir", "--spice-nodes", "all", "--schedule", name + ".csv"],
            name + ".export.log")
        text = pathlib.Path(name + ".cir").read_text()
        text = re.sub(r"^\.ic v\((n\d+)\)=(\S+)$",
                      lambda line: f".ic v({line[1]})={voltages.get(line[1], line[2])}", text, flags=re.M)
        text = text.replace("\nquit\n", f"\nwrnodev {name}.ic\nquit\n")
        pathlib.Path(name + ".cir").write_text(text)
        before_s = processor_seconds()
        run(["ngspice", "-b", name + ".cir"], name + ".log")
        used_s += processor_seconds() - before_s
        voltages = dict(re.findall(r"^\.ic [vV]\((n\d+)\) = (\S+)$", pathlib.Path(name + ".ic").read_text(), flags=re.M))
        assert voltages, f"no voltages in {name}.ic"
        names, *points = pathlib.Path(name + ".data").read_text().splitlines()
        if part == 0:
            print(names, file=collected)
        for point in points[1 if part else 0:]:
            time_s, values = point.split(maxsplit=1)
            print(repr(float(time_s) + times[part]), values, file=collected)
print(f"{used_s:.3f}")
