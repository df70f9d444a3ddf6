"""What notices a fault: the first test that fails, of those that pass the fault, the quick ones first."""
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import threading

import faults
import switches
from workshop import (BUILD, NOTICED_BY, SCRATCH, SLACK_S, SLOWEST, SOURCE, TREE, WHOLE_DAEMON, WHOLE_PROGRAMS, Tests, build,
                      configure, run, run_tests, run_whole, renew)

QUICK_S = (0.3, 3.0)  # tests that take less run first, then those that take less than the second
LIKED = SCRATCH / "switches.json"  # what the compiler has said to a fault as a switch
TESTS_AT_ONCE = 400  # names that one call of a program takes


def first_failure(program, usual, fault=None):
    """The first test that fails, twice; "hangs", "ends with ...", or None. `usual`: the time of each test without fault."""
    for from_s, to_s in zip((0.0, *QUICK_S), (*QUICK_S, math.inf)):
        all_tests = sorted((test for test, time_s in usual.items() if from_s <= time_s < to_s), key=usual.get)
        for first in range(0, len(all_tests), TESTS_AT_ONCE):
            tests = all_tests[first:first + TESTS_AT_ONCE]
            while tests:
                limit_s = SLACK_S + SLOWEST * sum(usual[test] for test in tests)
                failure = run_tests(program, tests, limit_s, fault)
                if failure is None:
                    break
                if failure not in tests or run_tests(program, [failure], limit_s, fault):
                    return failure
                print(f"  {program} {failure} failed once, and not again alone: not counted", flush=True)
                tests = [test for test in tests if test != failure]
    return None


class Batch:
    """Some faults of some rooms in one build."""

    def __init__(self, names, drawn, jobs):
        """`names`: files of the tree; `drawn`: (room, fault) pairs."""
        self.jobs, self.tests = jobs, Tests(jobs)
        self.drawn, self.one_daemon = drawn, threading.Lock()
        self.words = [faults.words(SOURCE, fault) for _, fault in drawn]
        known = json.loads(LIKED.read_text()) if LIKED.exists() else {}
        self.how = {number: known.get(words, switches.MUST) for number, words in enumerate(self.words)}
        self.programs = sorted({program for room, _ in drawn for program in NOTICED_BY[room]})
        if any(room in WHOLE_DAEMON for room, _ in drawn):
            self.programs_built = [*self.programs, *WHOLE_PROGRAMS]
        else:
            self.programs_built = self.programs
        for name in names:
            if all(fault[0] != name for _, fault in drawn):
                renew(name, (SOURCE / name).read_bytes(), TREE)
        self._write()
        configure(bundles=True)
        self._build()
        self.asked = set().union(*(switches.asked_when_running(BUILD / "bin" / program) for program in self.programs_built))
        for program in self.programs:
            self.tests.learn(program)

    def _write(self):
        """Each file with the switches that it may have."""
        for name in sorted({fault[0] for _, fault in self.drawn}):
            of_file = [(number, *fault[1:], self.how[number]) for number, (_, fault) in enumerate(self.drawn) if fault[0] == name]
            text, written = switches.with_switches((SOURCE / name).read_text(), of_file, name.endswith(".hpp"))
            for number, *_ in of_file:
                if number not in written:
                    self.how[number] = switches.NEVER
            renew(name, text.encode(), TREE)

    def _build(self):
        """Builds; takes back the switches that the compiler does not like, until it likes the rest."""
        while True:
            self._write()
            said = build(self.programs_built, self.jobs, "-k", "0")
            if said is None:
                known = json.loads(LIKED.read_text()) if LIKED.exists() else {}
                LIKED.write_text(json.dumps(known | {self.words[number]: how for number, how in self.how.items()}))
                return
            before = dict(self.how)
            for places in switches.lines_to_blame(said, TREE):
                self._take_back(places)
            if self.how == before:
                sys.exit(f"mutation: the tree does not build; see {SCRATCH / 'build.log'}")

    def _take_back(self, places):
        """Weakens the switches of the first of these places that has some; a place is a line of a copy, which has one more."""
        for near in (0, 8):
            for name, line in places:
                here = [number for number, (_, fault) in enumerate(self.drawn)
                        if fault[0] == name and self.how[number] != switches.NEVER and abs(fault[1] + 1 - line) <= near]
                for number in here:
                    self.how[number] -= 1
                if here:
                    return

    def switched(self, number):
        return self.how[number] != switches.NEVER and number in self.asked

    def verdict(self, number):
        """What notices a switched fault; None: nothing."""
        room, _ = self.drawn[number]
        for program in NOTICED_BY[room]:
            usual = {test: self.tests.times[program][test] for test, passed in self.tests.passes[program].items() if number in passed}
            failure = first_failure(program, usual, number)
            if failure:
                return f"{program} {failure}"
        if room in WHOLE_DAEMON:
            with self.one_daemon:
                self.tests.learn_whole(room)
                names = [name for name, passed in self.tests.passes[room].items() if number in passed]
                failure = run_whole(names, number) if names else None
                if failure and run_whole([failure], number):
                    return failure
        return None

    def without_switches(self):
        """The copy as the tree is, for faults that are judged alone."""
        for name in sorted({fault[0] for _, fault in self.drawn}):
            renew(name, (SOURCE / name).read_bytes(), TREE)
        configure(bundles=False)


def objects_beside(room, header):
    """Pairs of objects of the room's library and of its own test program: of the sources in a header's folder and the tests
    in the one that mirrors it, first of those only that include it by name, then of all."""
    program, folder = NOTICED_BY[room][0], pathlib.PurePath(header).parent
    sources = [path for path in sorted((TREE / folder).glob("*.cpp")) if path.name != "main.cpp"]
    tests = sorted((TREE / "tests" / folder).glob("*.cpp"))
    for chosen in (lambda path: f'"{header}"' in path.read_text(), lambda path: True):
        yield ([f"{room}/CMakeFiles/spindle_twin_{room}.dir/{path.relative_to(TREE / room)}.o" for path in filter(chosen, sources)],
               [f"tests/CMakeFiles/{program}.dir/{path.relative_to(TREE / 'tests')}.o" for path in filter(chosen, tests)])


def failure_beside(room, own, tests, usual, jobs):
    """The first test that fails when only these objects are built with the fault. None if nothing can be said so: then the
    whole is built."""
    program = NOTICED_BY[room][0]
    if not tests or build([*own, *tests], jobs) is not None:
        return None
    _, link = run(["ninja", "-C", BUILD, "-t", "commands", "-s", f"bin/{program}"], stdout=subprocess.PIPE)
    link = next(line for line in link.splitlines() if f"-o bin/{program} " in line)
    # In front of the libraries, which then give nothing of the same name.
    link = link.replace(f"-o bin/{program} ", f"-o bin/{program} {' '.join(own)} ")
    if run(["sh", "-c", link], cwd=BUILD, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)[0] != 0:
        return None
    failure = first_failure(program, usual)
    return failure if failure in usual else None


def judge_beside(room, fault, times, jobs):
    """What of the room's own tests notices a header's fault already when only what lies beside it is built; None: who knows.
    Leaves the copy without the fault, and nothing that was built with it."""
    path, program = TREE / fault[0], NOTICED_BY[room][0]
    if build([program], jobs) is not None:  # what the fault before has left
        sys.exit(f"mutation: the tree does not build; see {SCRATCH / 'build.log'}")
    whole, seen = path.read_bytes(), path.stat()
    faults.put(TREE, fault)
    built = []
    try:
        for own, tests in objects_beside(room, fault[0]):
            built += own + tests
            failure = failure_beside(room, own, tests, times[program], jobs)
            if failure:
                return f"{program} {failure}"
        return None
    finally:
        path.write_bytes(whole)
        os.utime(path, ns=(seen.st_atime_ns, seen.st_mtime_ns))  # else all that includes it would be built again
        for name in built:
            (BUILD / name).unlink(missing_ok=True)


def judge_alone(room, fault, times, jobs):
    """What noticed a fault that is built by itself: a test, or None; "no build" if it does not compile."""
    name, _, _, token = fault
    if name.endswith(".hpp") and not token.isdigit():  # a number of things may be a size, alike in all objects
        verdict = judge_beside(room, fault, times, jobs)
        if verdict:
            return verdict
    path = TREE / name
    whole = path.read_bytes()
    faults.put(TREE, fault)
    try:
        for program in NOTICED_BY[room]:
            if build([program], jobs) is not None:
                return "no build"
            failure = first_failure(program, times[program])
            if failure:
                return f"{program} {failure}"
        if room not in WHOLE_DAEMON:
            return None
        if build(WHOLE_PROGRAMS, jobs) is not None:
            return "no build"
        _, listed = run(["ctest", "--test-dir", BUILD, "-N", "-R", WHOLE_DAEMON[room]], stdout=subprocess.PIPE)
        failure = run_whole(re.findall(r"Test +#\d+: (\w+)", listed))
        return failure if failure and run_whole([failure]) else None
    finally:
        path.write_bytes(whole)
