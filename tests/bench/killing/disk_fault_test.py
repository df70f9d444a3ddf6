"""A disk that fails: the n-th call on the daemon's files, for all n of a run, once or from then on until it is mended.

disk_fault_test.py DAEMON MAKE_SMALL_NETWORK FILE_SEAM [--trials 0] [--seed 1] [--lanes 4]
A run goes on from a checkpoint, with an order, a table of parameters and a history (a run's calls with CSV files and
with SQLite), takes a tare, and writes checkpoints all the time. The failing call is each of them in turn: opening to
write, writing, syncing, renaming, removing, cutting. While it fails the twin answers and misses no cycle. Once the
disk is mended the order is done, the faults are gone, checkpoint and history go on; at the end each file is whole,
nothing lies beside them, and the log told each fault in a few lines. `--trials`: so many of them, drawn at random; 0: all.
"""
import collections
import errno
import json
import pathlib
import random
import re
import shutil
import signal
import sqlite3
import tempfile
import time

import kept_files
import seam
import twin
from kept_files import demand
from lanes import options_of, work_off
from ports import wait_until

CLOCK_RATE = 10.0  # a cycle each 0.1 s
ALL_FILES = seam.CHECKPOINT | seam.ORDERS | seam.PARAMETERS | seam.HISTORY
OF_FILES = twin.ORDERS_NOT_KEPT | twin.HISTORY_LOST | twin.CHECKPOINT_LOST
CHANGE_FILES = seam.ALL & ~seam.SYNCS
MODES = {  # what it does, for how many calls, which calls, what they say
    "I/O error, once": (seam.FAILS, 1, seam.ALL, errno.EIO),
    "I/O error": (seam.FAILS, seam.FOR_EVER, seam.ALL, errno.EIO),
    "disk full, once": (seam.FAILS, 1, seam.ALL, errno.ENOSPC),
    "disk full": (seam.FILLS, seam.FOR_EVER, seam.OPENS | seam.WRITES, errno.ENOSPC),
    "read-only": (seam.FAILS, seam.FOR_EVER, CHANGE_FILES, errno.EROFS),
}
MORE = (twin.CHECKPOINT + '[history]\nparameters = "files/parameters.csv"\npath = "files/{history}"\n')
FAILS_FOR_S, MOST_LINES = 0.5, 6


class Lane:
    """Runs of a kind of history, each from the same files."""

    def __init__(self, programs, folder, device_port, history):
        self.history = history
        more = MORE.format(interval_s=3.0, history=history)
        self.twin = twin.Twin(programs, folder, device_port, more, CLOCK_RATE)
        self.kept = folder / "kept"

    def begin(self, strike=None):
        """`strike`: what begins with the first call."""
        self.twin.seam.forget()
        self.twin.seam.heal()
        if strike:
            self.twin.seam.strike(*strike)
        self.twin.start()
        self.twin.wait_until_it_answers()
        wait_until(lambda: self.twin.read(twin.STATE, 1)[0] in (1, 2), "a prediction")

    def make_files(self):
        """A run of before, that ended well."""
        self.begin()
        self.twin.take_tare()
        wait_until(lambda: self.twin.number(twin.SEQUENCE) >= 20, "twenty cycles")
        demand(self.twin.end(signal.SIGTERM) == 0, "the daemon's end")
        shutil.copytree(self.twin.files, self.kept)

    def count_calls(self, calls):
        """Of a run without a fault."""
        self.restore()
        self.begin((0, ALL_FILES, seam.FOR_EVER, seam.FOR_EVER, calls))
        self.go_through()
        count = self.twin.seam.get("matched")
        self.finish(False)
        return count

    def restore(self):
        for each in self.twin.files.iterdir():
            each.unlink()
        for each in self.kept.iterdir():
            shutil.copy(each, self.twin.files)

    def go_through(self):
        """What writes everything once more."""
        self.twin.order_tare()
        written = self.twin.checkpoint.stat().st_mtime_ns
        end = time.monotonic() + 1.5
        while time.monotonic() < end and self.twin.checkpoint.stat().st_mtime_ns == written:
            time.sleep(0.02)

    def trial(self, mode, number):
        action, calls_that_fail, calls, error = MODES[mode]
        last = number if calls_that_fail == 1 else seam.FOR_EVER
        self.restore()
        self.begin((action, ALL_FILES, number, last, calls, error))
        demand(self.twin.fault() & twin.ORDERS_LOST == 0, "orders_lost")
        self.go_through()
        self.twin.seam.wait_until_struck()
        if calls_that_fail > 1:
            cycle = self.twin.number(twin.SEQUENCE)
            time.sleep(FAILS_FOR_S)
            demand(self.twin.number(twin.SEQUENCE) > cycle, "no cycle while the disk fails")
        self.finish(True)

    def finish(self, was_struck):
        self.twin.seam.heal()
        mended_s, mended_at = time.time(), self.twin.number(twin.SEQUENCE)
        wait_until(lambda: self.twin.order_result() == twin.DONE, "the order")
        wait_until(lambda: kept_files.saved_unix_s(self.twin.checkpoint.read_bytes()) > mended_s, "a checkpoint")
        wait_until(lambda: self.twin.fault() & OF_FILES == 0, "the faults to be gone")
        wait_until(lambda: self.twin.number(twin.SEQUENCE) >= mended_at + 3, "cycles")
        demand(self.twin.number(twin.OVERRUNS) == 0, f"{self.twin.number(twin.OVERRUNS)} cycles missed")
        tare_um, cycle = self.twin.floats(twin.TARE, 1)[0], self.twin.number(twin.SEQUENCE)
        demand(self.twin.end(signal.SIGTERM) == 0, f"the end by SIGTERM: {self.twin.daemon.returncode}")
        kept_files.unseal(self.twin.checkpoint.read_bytes(), "checkpoint")
        kept_um = 1e6 * kept_files.orders(self.twin.orders.read_bytes())[1]
        demand(abs(tare_um - kept_um) < 1e-3, f"tare {tare_um} um, kept is {kept_um} um")
        demand(self.newest_cycle() >= cycle, "the history did not go on")
        if was_struck:
            self.check_log()
        self.check_folder(may_be_left=was_struck)

    def newest_cycle(self):
        path = self.twin.files / self.history
        if path.suffix == ".csv":
            for each in sorted(self.twin.files.glob("history*.csv")):
                sequences = kept_files.history_sequences(each.read_bytes(), each.name)
            return kept_files.history_sequences(path.read_bytes(), path.name)[-1] if sequences is not None else 0
        database = sqlite3.connect(path)
        demand(database.execute("PRAGMA integrity_check").fetchall() == [("ok",)], "the history is damaged")
        run, sequence = database.execute("SELECT run, sequence FROM cycle ORDER BY id DESC LIMIT 1").fetchone()
        first, last, rows = database.execute("SELECT min(sequence), max(sequence), count(*) FROM cycle WHERE run = ?",
                                             (run,)).fetchone()
        demand(last - first + 1 == rows, "a run with a gap")
        database.close()
        return sequence

    def left_over(self):
        stem, end = self.history.split(".")
        expected = re.compile(rf"twin\.checkpoint(\.orders)?|parameters\.csv|{stem}(\.\d{{6}})?\.{end}|.*\.lock")
        return [each.name for each in self.twin.files.iterdir() if not expected.fullmatch(each.name)]

    def check_folder(self, may_be_left):
        """What could not be removed is, at the next start."""
        if may_be_left and self.left_over():
            self.begin()
            demand(self.twin.end(signal.SIGTERM) == 0, "the end of another start")
        demand(not self.left_over(), f"left beside the files: {self.left_over()}")

    def check_log(self):
        told = collections.Counter()
        for line in self.twin.log().splitlines():
            if " error " in line or " warning " in line:
                told[line.split()[3]] += 1
        demand(not told or max(told.values()) <= MOST_LINES, f"a flood in the log: {self.twin.log()}")

    def told(self):
        return f"{self.twin.log()}{[tuple(call[:5]) for call in self.twin.seam.record()][-12:]}"


def trials_of(lane, share, chance):
    """All, or a share of them."""
    lane.make_files()
    counts = {calls: lane.count_calls(calls) for calls in {calls for _, _, calls, _ in MODES.values()}}
    demand(min(counts.values()) > 0, f"calls that the seam has seen, {counts}: was it loaded?")
    print(f"{lane.history}: {counts[seam.ALL]} calls in a run", flush=True)
    trials = [(mode, number, (mode, number))
              for mode, (_, _, calls, _) in MODES.items() for number in range(1, counts[calls] + 1)]
    chance.shuffle(trials)
    return trials[:share] if share else trials


def main():
    options, programs = options_of(__doc__, trials=0, lanes=4)
    device = twin.Device([28.5, 28.25, 28.0, 21.5, 6000.0, 1.0])
    totals = collections.Counter()
    with tempfile.TemporaryDirectory() as name:
        for history in ("history.csv", "history.sqlite"):
            lanes = [Lane(programs, pathlib.Path(name) / f"{history}.{n}", device.port, history) for n in range(options.lanes)]
            for lane in lanes[1:]:
                lane.make_files()
            trials = trials_of(lanes[0], options.trials // 2, random.Random(options.seed))
            failures = work_off(lanes, trials, totals)
            if failures:
                raise SystemExit("\n".join(failures))
    print(json.dumps(dict(sorted(totals.items())), indent=2))


if __name__ == "__main__":
    main()
