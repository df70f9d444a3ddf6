#!/usr/bin/env python3
"""Runs the line of host_tools/README.md that takes a network to ngspice, on a hand-written network over a drive cycle with
changing speed, and compares with spindle-twin simulate.
readme_line_test.py SPINDLE-TWIN: 77 if ngspice is not installed, 1 if the two differ by more than the limits."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
# ngspice's own error of time, with its steps of up to ten seconds, on a winding that changes within minutes.
LIMIT_K, LIMIT_UM = 0.03, 0.01
DAY = "time_s,speed_rpm,load\n0,6000,1\n600,12000,0.5\n1500,0,0\n2400,9000,0.8\n3600,9000,0.8\n"

twin = pathlib.Path(sys.argv[1]).resolve()
if not shutil.which("ngspice"):
    print("ngspice is not installed (host_tools/setup tests)")
    sys.exit(77)
line, = re.findall(r"^    (spindle-twin export my\.rom --spice .*ngspice -b net\.cir)", (ROOT / "host_tools/README.md").read_text(),
                   flags=re.M)
assert "--schedule day.csv" in line, line
with tempfile.TemporaryDirectory() as folder:
    work = pathlib.Path(folder)
    (work / "day.csv").write_text(DAY)

    def run(command):
        result = subprocess.run(command, shell=True, cwd=work, capture_output=True, text=True, timeout=120,
                                env={**os.environ, "PATH": f"{twin.parent}:{os.environ['PATH']}"})
        assert result.returncode == 0, f"{command}\n{result.stdout}\n{result.stderr}"
        return result.stdout

    run(f"spindle-twin assemble '{ROOT}/rom/by_hand/motor_spindle.toml' -o my.rom")
    run(line)
    (work / "my.json").write_text(run("spindle-twin inspect my.rom --json"))
    run("spindle-twin simulate my.rom --schedule day.csv -o simulated.csv")
    points = [float(row.split()[0]) for row in (work / "net.data").read_text().splitlines()[1:] if row.strip()]
    assert points[-1] == 3600.0, f"ngspice stopped at {points[-1]} s of 3600 s"
    sys.exit(subprocess.run([sys.executable, HERE / "compare.py", "readme", "my.json", "net.data", "simulated.csv",
                             str(LIMIT_K), str(LIMIT_UM)], cwd=work, check=False).returncode)
