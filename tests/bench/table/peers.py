"""Rows of other programs beside ours, each measured here: CalculiX and FreeFEM on our decks, ngspice on our netlists."""
import json
import pathlib
import re
import resource
import shutil
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[3]
REFERENCE = ROOT / "fem_offline" / "spindles" / "reference.toml"
IN_PARTS = ROOT / "tests" / "verification" / "ngspice" / "in_parts.py"

# FreeFEM's BDF2 (error constant 1/3) needs so many times the steps of our SDIRK2 (0.0404) for the same error.
EQUAL_ERROR = 2.87
SOLVERS = "One transient step beside other solvers, same mesh"
NETLISTS = "Network"


class NotMeasured(Exception):
    """Why a peer gave no time."""


def run(command, folder, **options):
    """What it prints. Raises NotMeasured with the last line that it said where it fails."""
    done = subprocess.run(list(map(str, command)), cwd=folder, capture_output=True, text=True, stdin=subprocess.DEVNULL, **options)
    if done.returncode != 0:
        said = (done.stderr.strip() or done.stdout.strip() or "no word").splitlines()[-1]
        raise NotMeasured(f"{pathlib.Path(command[0]).name} ended with {done.returncode}: {said}")
    return done.stdout


def need(program, package):
    if shutil.which(program) is None:
        raise NotMeasured(f"{package} is not installed (host_tools/setup bench)")


def number(text, what):
    try:
        return float(text)
    except ValueError:
        raise NotMeasured(f"{what} gave '{text.strip()[:40]}' in place of a time") from None


def freefem_step_s(folder):
    """FreeFEM's own clock around two hundred steps, after its factorisation."""
    need("FreeFem++", "freefem++")
    deck = folder / "spindle.edp"
    deck.write_text(re.sub(r"while \(steps < \d+\)", "while (steps < 200)", deck.read_text()))
    said = run(["FreeFem++", "-nw", "-ng", "-v", "0", deck.name], folder)
    found = re.search(r"^timing step_s (\S+)", said, re.MULTILINE)
    return number(found[1] if found else "", "FreeFEM")


def calculix_step_s(folder):
    """CalculiX' processor time over the increments of its first step: start-up is below one of them."""
    need("ccx", "calculix-ccx")
    deck = folder / "transient.inp"
    text = deck.read_text()
    end = re.search(r"^\*END STEP.*\n?", text, re.MULTILINE)
    deck.write_text(text[:end.end()] if end else text)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run(["env", "OMP_NUM_THREADS=1", "ccx", "transient"], folder)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return used_s / json.loads((folder / "outputs.json").read_text())["transient_steps"][0]["count"]


def beside(fields, peer):
    """A row's fields with the peer's time, or with the reason why there is none."""
    try:
        return {**fields, "other": peer()}
    except NotMeasured as reason:
        return {**fields, "not_measured": str(reason)}


def solver_rows(twin, bench_rows, work):
    """One transient step of the reference spindle on two meshes, the finer one without CalculiX, which takes minutes there."""
    for element_size_mm in (None, 1.5):
        folder = work / str(element_size_mm or "as_described")
        folder.mkdir()
        spindle, text = folder / "spindle.toml", REFERENCE.read_text()
        if element_size_mm:
            text = re.sub(r"^element_size_mm = .*", f"element_size_mm = {element_size_mm}", text, flags=re.MULTILINE)
        spindle.write_text(text)
        decks = run([twin, "export", spindle, "--calculix", folder / "calculix", "--freefem", folder / "freefem"], folder)
        nodes = int(re.search(r"^CalculiX deck.*: (\d+) nodes", decks, re.MULTILINE)[1])
        ours = number(run([bench_rows, "--step", spindle], folder), "bench_rows")

        def row(name, other_name, means, **more):
            return {"group": SOLVERS, "name": f"{nodes:,} nodes: {name}", "kind": "peer", "ours": ours, "other_name": other_name,
                    "unit": "s", "clock": "processor", "means": means, **more}

        freefem = beside(row("one step, order 2, two solutions", "FreeFEM, factor kept, order 2, one solution",
                             "Step against step; theirs has one solution, ours two.", goal=1.0),
                         lambda: freefem_step_s(folder / "freefem"))
        yield freefem
        equal = {**freefem, "name": f"{nodes:,} nodes: the same for equal error", "other_name": "FreeFEM, 2.87 steps for one of ours",
                 "means": "BDF2 needs 2.87 times as many steps for the error of ours."}
        equal.pop("goal")
        if "other" in equal:
            equal["other"] *= EQUAL_ERROR
        yield equal
        if element_size_mm is None:
            yield beside(row("one step, order 2, two solutions", "CalculiX, factorised every step, order 1",
                             "Step against step; the accuracy of order 2 is not counted.", goal=1 / 20),
                         lambda: calculix_step_s(folder / "calculix"))


def netlist_rows(twin, bench_rows, work):
    """Ten minutes of a drive cycle with a jump of speed and load every two; ngspice in parts of constant speed, its cheapest way."""
    nodes = 100  # its time grows fast with them
    run([twin, "build", REFERENCE, "-o", "net.rom", "--nodes", nodes, "--certificate-cases", 0], work)
    (work / "drive.csv").write_text("time_s,speed_rpm,load\n0,6000,1\n120,9000,0.4\n240,3000,0.7\n360,12000,0\n480,7500,0.9\n"
                                    "600,7500,0.9\n")
    ours = number(run([bench_rows, "--schedule", "net.rom", "drive.csv"], work), "bench_rows")

    def ngspice_s():
        need("ngspice", "ngspice")
        return number(run([IN_PARTS, twin, "net.rom", "drive.csv", "drive.data"], work), "ngspice")

    yield beside({"group": NETLISTS, "name": f"ten minutes of a drive cycle, {nodes} nodes, cycles of 1 s", "kind": "peer",
                  "ours": ours, "other_name": "ngspice, steps up to 10 s", "unit": "s", "clock": "processor",
                  "means": "ngspice gets one exported netlist for each speed; its start-up counts.", "goal": 1 / 20}, ngspice_s)
