"""The scratch copy of the tree that faults are made in, its build, and its tests."""
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRATCH = ROOT / "build-mutation"
SOURCE = SCRATCH / "source"  # as the tree was when the run began: later edits do not reach it
TREE, BUILD = SCRATCH / "tree", SCRATCH / "build"  # with faults in it
RESULTS = SCRATCH / "results"
OF_CORRECTION = ["test_correction", "test_calibrate", "test_plan_test", "test_firmware", "test_replay"]
NOTICED_BY = {"rom": ["test_rom", *OF_CORRECTION], "correction": OF_CORRECTION,
              "firmware": ["test_firmware", "test_replay"]}
# At last the whole daemon, where its own sources are at fault: tests of ctest, and the programs that they run.
WHOLE_DAEMON = {"firmware": "^(daemon|compensation|service|device_fault|daemon_fault|http|stream|spindles|plant|history|deploy|tls|viewers|network_file)_system$"}
WHOLE_PROGRAMS = ["spindle-twind", "spindle-twin", "make_small_network", "spindle-twin-node"]
NODE_MODULES = "tests/system/clients/node_modules"  # what host_tools/setup has installed: the copy of the tests uses it
SLOWEST, SLACK_S = 10.0, 60.0  # tests that take so many times their usual time, and that much longer, hang
NEVER_A_FAULT = re.compile(r"Killed signal|No space left|internal compiler error|out of memory")  # the machine's, not the fault's


running = set()  # processes that have been started, each with what it starts


def run(command, limit_s=None, **options):
    """A program and all that it starts, which end with it. TimeoutExpired after the limit."""
    with subprocess.Popen(command, start_new_session=True, text=True, errors="replace", **options) as process:
        running.add(process.pid)
        try:
            output, _ = process.communicate(timeout=limit_s)
            return process.returncode, output
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)
            raise
        finally:
            running.discard(process.pid)


def end(*_):
    """On a signal: at once, with all that was started. What was judged is kept."""
    for pid in list(running):
        os.killpg(pid, signal.SIGKILL)
    print("mutation: interrupted; the same command goes on from here", file=sys.stderr, flush=True)
    os._exit(1)


def renew(name, content, folder):
    """A file of a copy, touched only where it changes, so that nothing is built for the others."""
    copy = folder / name
    if not copy.exists() or copy.read_bytes() != content:
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(content)
        shutil.copymode(ROOT / name, copy)


def renew_source():
    """Makes the copy hold what the tree holds. Gives the names of its files, and a short name of their content, to which
    documents and these programs count nothing."""
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"], cwd=ROOT, check=True,
                            capture_output=True, text=True).stdout
    names = sorted(name for name in listed.split("\0") if name and (ROOT / name).is_file())
    content = hashlib.sha256()
    for name in names:
        renew(name, (ROOT / name).read_bytes(), SOURCE)
        if not name.endswith(".md") and not name.startswith("tests/mutation/"):
            content.update(name.encode() + b"\0" + hashlib.sha256((SOURCE / name).read_bytes()).digest())
    for folder in (SOURCE, TREE):
        for copy in list(folder.rglob("*")):
            if copy.is_file() and copy.relative_to(folder).as_posix() not in names:
                copy.unlink()
    return names, content.hexdigest()[:12]


def configure(bundles):
    """The build of the copy with faults in it. `bundles`: several sources in one object, which is quicker where
    all is built; False: one each, for faults that are built one after another."""
    if (ROOT / NODE_MODULES).is_dir() and not (TREE / NODE_MODULES).exists():
        (TREE / NODE_MODULES).symlink_to(ROOT / NODE_MODULES)
    code, output = run(["cmake", "-S", TREE, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DSPINDLE_TWIN_OFFLINE=OFF",
                        f"-DCMAKE_UNITY_BUILD={'ON' if bundles else 'OFF'}",
                        f"-DCMAKE_CXX_FLAGS=-w -I{TREE}", "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -D_GLIBCXX_ASSERTIONS"],
                       stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if code != 0:
        sys.exit(f"mutation: {output}")


def build(targets, jobs, *options):
    """None if it compiles, else what the compiler says. No limit of time: a busy machine is no fault."""
    path = SCRATCH / "build.log"
    with open(path, "w") as log:
        code, _ = run(["ninja", "-C", BUILD, "-j", str(jobs), *options, *targets], stdout=log, stderr=log)
    said = path.read_text(errors="replace") if code != 0 else ""
    trouble = NEVER_A_FAULT.search(said)
    if code < 0 or trouble:
        sys.exit(f"mutation: the build ended with {trouble.group() if trouble else code}, which is no fault of a token; see {path}")
    return said if code != 0 else None


def run_tests(program, tests, limit_s, fault=None):
    """The name of the first of these tests that fails, "hangs", "ends with ...", or None."""
    command = [BUILD / "bin" / program, "--gtest_fail_fast", "--gtest_brief=1", "--gtest_filter=" + ":".join(tests)]
    try:
        code, output = run(command, limit_s, cwd=TREE, env=environment(fault), stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    except subprocess.TimeoutExpired:
        return "hangs"
    if code == 0:
        return None
    failed = re.search(r"\[  FAILED  \] ([\w./]+)", output)
    return failed.group(1) if failed else f"ends with {code}"


def environment(fault=None, reached=None):
    """Of a program with a fault turned on, or that writes down the faults that it passes."""
    given = {name: value for name, value in os.environ.items() if not name.startswith("SPINDLE_TWIN_")}
    if fault is not None:
        given["SPINDLE_TWIN_FAULT"] = str(fault)
    if reached is not None:
        given["SPINDLE_TWIN_REACHED"] = str(reached)
    return given


def run_whole(names, fault=None, reached=None):
    """The first of these tests of the whole daemon that fails, or None."""
    command = ["ctest", "--test-dir", BUILD, "-j", str(os.cpu_count()), "--no-tests=error", "--stop-on-failure",
               "-R", "^(" + "|".join(names) + ")$"]
    code, output = run(command, env=environment(fault, reached), stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if code == 0:
        return None
    failed = re.search(r"(\w+)\s*\.*\s*\*\*\*", output)
    return failed.group(1) if failed else "the whole daemon"


def names_of_tests(program):
    _, listed = run([BUILD / "bin" / program, "--gtest_list_tests"], cwd=TREE, env=environment(), stdout=subprocess.PIPE)
    names, suite = [], ""
    for line in listed.splitlines():
        if line.startswith("  "):
            names.append(suite + line.split("#")[0].strip())
        elif line.split("#")[0].strip().endswith("."):
            suite = line.split("#")[0].strip()
    return [name for name in names if ".DISABLED_" not in name]


class Tests:
    """What is known of the tests without a fault: the time of each, and the faults that it passes."""

    def __init__(self, jobs):
        self.jobs, self.times, self.passes = jobs, {}, {}

    def learn(self, program):
        """Walks each test of a program once. One that fails with all switches off (they cost time) judges no fault."""
        names = names_of_tests(program)
        with concurrent.futures.ThreadPoolExecutor(self.jobs) as workers:
            seen = list(workers.map(lambda name: self._walk(program, name), names))
        self.times[program] = {name: time_s for name, time_s, _ in seen}
        self.passes[program] = {name: reached for name, _, reached in seen}
        print(f"without a fault {len(names)} tests of {program} pass in {sum(self.times[program].values()):.0f} s", flush=True)

    def _walk(self, program, name):
        path = SCRATCH / "reached" / f"{program}.{re.sub(r'[^A-Za-z0-9]', '_', name)}"
        path.parent.mkdir(exist_ok=True)
        for last in (False, True):
            path.unlink(missing_ok=True)
            command = [BUILD / "bin" / program, "--gtest_brief=1", f"--gtest_filter={name}"]
            began = time.monotonic()
            code, output = run(command, cwd=TREE, env=environment(reached=path), stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            if code == 0:
                break
            if last:
                print(f"mutation: without any fault {program} {name} fails, so it judges none:\n{output}", flush=True)
                return name, 0.0, set()
        return name, time.monotonic() - began, passed_in(path)

    def learn_whole(self, room):
        if room in self.passes:
            return
        _, listed = run(["ctest", "--test-dir", BUILD, "-N", "-R", WHOLE_DAEMON[room]], stdout=subprocess.PIPE)
        self.passes[room] = {}
        for name in re.findall(r"Test +#\d+: (\w+)", listed):
            path = SCRATCH / "reached" / name
            path.unlink(missing_ok=True)
            if run_whole([name], reached=path):
                sys.exit(f"mutation: without any fault {name} fails")
            self.passes[room][name] = passed_in(path)


def passed_in(path):
    return {number for number, passed in enumerate(path.read_bytes()) if passed} if path.exists() else set()
