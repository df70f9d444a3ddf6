"""What a run's numbers hang on: when, where and of which sources."""
import datetime
import os
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[3]


def load():
    return pathlib.Path("/proc/loadavg").read_text().split()[0]


def said(*command):
    """What the command prints, or nothing where there is none."""
    try:
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def processor():
    found = re.search(r"^model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    return found[1] if found else os.uname().machine


def commit():
    changed = ", with changes" if said("git", "status", "--porcelain", "--untracked-files=no") else ""
    return (said("git", "rev-parse", "--short=10", "HEAD") or "not known") + changed


def blas():
    found = re.search(r"libblas\.so\.3 .*=> (\S+)", said("/sbin/ldconfig", "-p"))
    return pathlib.Path(found[1]).resolve().as_posix() if found else "not known"


def facts(options):
    """{name: text}; `options` of the command, if any."""
    now = datetime.datetime.now(datetime.timezone.utc)
    return {"command": "tests/bench/run" + (f" {options}" if options else ""), "date": now.strftime("%d %b %Y, %H:%M UTC"),
            "commit": commit(), "machine": f"{processor()}, {os.cpu_count()} cores", "load": load(), "BLAS": blas()}
