#!/usr/bin/env python3
"""Runs the line of host_tools/README.md that takes a network to ngspice, on a hand-written network over a drive cycle with
changing speed; then netlists of a cooling jacket whose circuit's flow changes too, with all nodes and reduced to a few, in
both directions of the flow. Compares all with spindle-twin simulate, and prints the ratio of processor times.
readme_line_test.py SPINDLE-TWIN: 77 if ngspice is not installed, 1 if the two differ by more than the limits."""
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
DAY = "time_s,speed_rpm,load\n0,6000,1\n600,12000,0.5\n1500,0,0\n2400,9000,0.8\n3600,9000,0.8\n"
# Flow goes on while the spindle stands still.
JACKET_DAY = ("time_s,speed_rpm,load,water_degC,helix_kg_per_s\n0,6000,1,20,0.02\n600,12000,1,21,0.03\n1500,0,1,19,0.01\n"
              "2400,9000,1,20,0.02\n3600,9000,1,20,0.02\n")
GROOVES, LAYERS = 6, 4
# Errors of ngspice's steps of up to ten seconds, and 2e-3 K of reduction.
LIMIT_K, LIMIT_UM = 4e-3, 6e-3


def jacket():
    """A jacket in rings along its axis, each of layers from the bore to a sleeve, with a groove between jacket and sleeve."""
    lines = ['name = "small_jacket"', "[operating]", "speed_rpm = 6000", "reference_temperature_degC = 20",
             "temperatures_degC = { room = 22, water = 20 }",
             '[[surrounding]]\nname = "room"\nkind = "ambient"', '[[surrounding]]\nname = "water"\nkind = "coolant"']
    for ring in range(GROOVES):
        for layer in range(LAYERS):
            part = "sleeve" if layer == LAYERS - 1 else "jacket"
            lines.append(f'[[node]]\nname = "n{ring}{layer}"\npart = "{part}"\ncapacity_J_per_K = {250 + 60 * layer + 10 * ring}')
            if layer < LAYERS - 2:
                lines.append(f'[[conduction]]\nbetween = ["n{ring}{layer}", "n{ring}{layer + 1}"]\nconductance_W_per_K = 90')
            if ring > 0:
                lines.append(f'[[conduction]]\nbetween = ["n{ring - 1}{layer}", "n{ring}{layer}"]\nconductance_W_per_K = 4')

    def faces(text):
        return "faces = [" + ", ".join(text.format(ring) for ring in range(GROOVES)) + "]"

    lines += ['[[contact]]\nname = "fit"\nconductance_W_per_m2K = 2500',
              faces(f'{{{{ between = ["n{{0}}{LAYERS - 2}", "n{{0}}{LAYERS - 1}"], area_mm2 = 6000 }}}}'),
              '[[film]]\nname = "outer"\nsurrounding = "room"\ncoefficient_W_per_m2K = 30',
              "speed_law = { constant = 0.5, speed_terms = [[0.5, 0.7]] }",
              faces(f'{{{{ node = "n{{0}}{LAYERS - 1}", area_mm2 = 15000 }}}}'),
              '[[coolant_circuit]]\nname = "helix"\ninlet = "water"\nflow_kg_per_s = 0.02',
              "heat_capacity_J_per_kgK = 4180\ncoefficient_W_per_m2K = 1500\nsegments = [",
              *(f'{{ name = "groove_{ring}", node = "n{ring}{LAYERS - 2}", area_mm2 = 9000 }},' for ring in range(GROOVES)), "]",
              '[[heat]]\nname = "stator"\nheat_W = 400\nspeed_law = { speed_terms = [[1, 1.2]] }',
              "weights = { n00 = 0.1, n10 = 0.2, n20 = 0.2, n30 = 0.2, n40 = 0.2, n50 = 0.1 }",
              '[[key_point]]\nname = "front"\nnode = "n00"', '[[key_point]]\nname = "rear"\nnode = "n50"',
              '[[deformation]]\nname = "length"\num_per_K = { n02 = 0.3, n12 = 0.3, n22 = 0.3, n32 = 0.3, n42 = 0.3, n52 = 0.3 }']
    return "\n".join(lines) + "\n"


twin = pathlib.Path(sys.argv[1]).resolve()
if not shutil.which("ngspice"):
    print("ngspice is not installed (host_tools/setup tests)")
    sys.exit(77)
line, = re.findall(r"^    (spindle-twin export my\.rom --spice .*ngspice -b net\.cir)", (ROOT / "host_tools/README.md").read_text(),
                   flags=re.M)
assert "--schedule day.csv" in line, line
with tempfile.TemporaryDirectory() as folder:
    work = pathlib.Path(folder)
    failed = False

    def run(command):
        """What it prints, and its processor seconds."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        result = subprocess.run(command, shell=True, cwd=work, capture_output=True, text=True, timeout=120,
                                env={**os.environ, "PATH": f"{twin.parent}:{os.environ['PATH']}"})
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        assert result.returncode == 0, f"{command}\n{result.stdout}\n{result.stderr}"
        return result.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def check(name):
        """What ngspice wrote in net.data beside simulate of my.rom along day.csv, a row of it every ten seconds."""
        _, ngspice_s = run("ngspice -b net.cir")
        _, simulate_s = run("spindle-twin simulate my.rom --schedule day.csv -o simulated.csv")
        (work / "my.json").write_text(run("spindle-twin inspect my.rom --json")[0])
        print(f"{name}: ngspice {ngspice_s:.2f} s, simulate {simulate_s:.2f} s, {ngspice_s / simulate_s:.1f} times as long")
        points = [float(row.split()[0]) for row in (work / "net.data").read_text().splitlines()[1:] if row.strip()]
        assert points[-1] == 3600.0, f"ngspice stopped at {points[-1]} s of 3600 s"
        sys.stdout.flush()
        return subprocess.run([sys.executable, HERE / "compare.py", name, "my.json", "net.data", "simulated.csv", str(LIMIT_K),
                               str(LIMIT_UM)], cwd=work, check=False).returncode != 0

    (work / "day.csv").write_text(DAY)
    run(f"spindle-twin assemble '{ROOT}/rom/by_hand/motor_spindle.toml' -o my.rom")
    run(line)
    failed |= check("readme")

    (work / "jacket.toml").write_text(jacket())
    run("spindle-twin assemble jacket.toml -o my.rom")
    for name, day in (("jacket", JACKET_DAY), ("backward", JACKET_DAY.replace(",0.0", ",-0.0"))):
        (work / "day.csv").write_text(day)
        for nodes in ("all", "reduced"):
            said, _ = run(f"spindle-twin export my.rom --spice net.cir --schedule day.csv --spice-nodes {nodes}")
            print(said.strip())
            assert (f" of {GROOVES * LAYERS} nodes" in said) == (nodes == "reduced"), said
            failed |= check(f"{name} {nodes}")
    sys.exit(1 if failed else 0)
