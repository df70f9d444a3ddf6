"""A power cut behind each call on the daemon's files: what a disk can show then has one valid state, whole and not old.

power_cut_test.py DAEMON MAKE_SMALL_NETWORK FILE_SEAM [--trials 0] [--seed 1] [--lanes 4]
Of a run that goes on from a checkpoint, takes a tare, writes checkpoints, parameters and a history and is killed, and of
the next one, every call is recorded, with CSV files and with SQLite. Behind each of the calls the disk is what was
synced, and of the rest
    least          nothing: neither data nor names
    most           everything, as after a kill
    names          names, and sizes, but none of the data (zeros)
    data           data, but none of the names
    torn           everything but the second half of the last writing
    holes          names, and half of the pages, drawn at random; the others are as they were, or zeros
Checkpoint and orders must be whole, and no older than what was synced with its name. From each such disk the daemon is
started: it goes on from that state with its tare, raises no fault, leaves nothing beside the files, keeps the history
of the run before and writes a whole one. `--trials`: so many disks, drawn at random; 0: all.
"""
import collections
import json
import os
import pathlib
import random
import re
import shutil
import signal
import sqlite3
import tempfile

import kept_files
import seam
import twin
from kept_files import demand
from lanes import options_of, work_off
from ports import wait_until

CLOCK_RATE, INTERVAL_S, PAGE_BYTES = 100.0, 20.0, 4096
MORE = twin.CHECKPOINT + '[history]\nparameters = "files/parameters.csv"\npath = "files/{history}"\n'
ROWS = "SELECT run, min(sequence), max(sequence), count(*) FROM cycle GROUP BY run ORDER BY run"
KINDS = ("least", "most", "names", "data", "torn", "holes")


class File:
    """An inode: what was written, and what of it is synced."""

    def __init__(self, data=b""):
        self.now, self.synced, self.before = bytearray(data), bytes(data), bytes(data)

    def write(self, offset, data):
        self.before = bytes(self.now)
        self.now.extend(bytes(max(0, offset + len(data) - len(self.now))))
        self.now[offset:offset + len(data)] = data

    def resize(self, size):
        self.now = self.now[:size] + bytes(max(0, size - len(self.now)))

    def torn(self, offset, size):
        """Without the second half of its last writing."""
        half = offset + (size + 1) // 2
        return bytes(self.now[:half]) + self.before[half:]

    def holed(self, chance):
        data = bytearray()
        for at in range(0, len(self.now), PAGE_BYTES):
            now = bytes(self.now[at:at + PAGE_BYTES])
            old = self.synced[at:at + PAGE_BYTES]
            data += now if old == now or chance.random() < 0.5 else old + bytes(len(now) - len(old))
        return bytes(data)


class Disk:
    """A folder and what of it is on the disk."""

    def __init__(self, folder, files):
        self.folder = str(folder)
        self.names = {name: File(data) for name, data in files.items()}
        self.synced_names, self.behind = dict(self.names), {}

    def apply(self, call):
        name, other = pathlib.Path(call.path).name, pathlib.Path(call.other).name
        if call.kind == seam.OPENS:
            self.open(call, name)
        elif call.kind == seam.WRITES:
            self.behind[call.file].write(call.number, call.data)
        elif call.kind == seam.RESIZES:
            self.behind[call.file].resize(call.number)
        elif call.kind == seam.SYNCS and self.behind[call.file] is None:
            self.synced_names = dict(self.names)
        elif call.kind == seam.SYNCS:
            self.behind[call.file].synced = bytes(self.behind[call.file].now)
        elif call.kind == seam.RENAMES:
            self.names[other] = self.names.pop(name)
        elif call.kind == seam.REMOVES:
            self.names.pop(name, None)

    def open(self, call, name):
        if call.path == self.folder:
            self.behind[call.file] = None
            return
        file = self.names.setdefault(name, File())
        if call.number & os.O_TRUNC:
            file.resize(0)
        self.behind[call.file] = file

    def shows(self, kind, last, chance):
        """The files after a cut: their names and bytes."""
        names = self.synced_names if kind in ("least", "data") else self.names
        last_file = self.behind.get(last.file) if last.kind == seam.WRITES else None

        def bytes_of(file):
            if kind == "least":
                return file.synced
            if kind == "names":
                return file.synced[:len(file.now)] + bytes(max(0, len(file.now) - len(file.synced)))
            if kind == "torn" and file is last_file:
                return file.torn(last.number, len(last.data))
            return file.holed(chance) if kind == "holes" else bytes(file.now)

        return {name: bytes_of(file) for name, file in names.items()}

    def promised(self, name):
        """What is synced with its name."""
        file = self.synced_names.get(name)
        return file.synced if file else None


class Cut:
    """A disk to start from, and the oldest checkpoint and orders that it may hold."""

    def __init__(self, kind, number, files, checkpoint, orders):
        self.kind, self.number, self.files, self.checkpoint, self.orders = kind, number, files, checkpoint, orders


def cuts_of(folder, base, calls, chance):
    """One for each different disk."""
    disk, seen, cuts = Disk(folder, base), set(), []
    for number, call in enumerate(calls, 1):
        disk.apply(call)
        for kind in KINDS:
            files = disk.shows(kind, call, chance)
            key = hash(tuple(sorted(files.items())))
            if key not in seen:
                seen.add(key)
                cuts.append(Cut(kind, number, files, disk.promised("twin.checkpoint"), disk.promised("twin.checkpoint.orders")))
    return cuts


class Lane:
    """Starts a daemon from disks."""

    def __init__(self, programs, folder, device_port, history):
        self.history = history
        self.twin = twin.Twin(programs, folder, device_port, MORE.format(interval_s=INTERVAL_S, history=history), CLOCK_RATE)

    def start(self):
        self.twin.start()
        self.twin.wait_until_it_answers()
        wait_until(lambda: self.twin.read(twin.STATE, 1)[0] in (1, 2), "a prediction")

    def run_some(self, cycles):
        wait_until(lambda: self.twin.number(twin.SEQUENCE) >= cycles, f"{cycles} cycles")

    def record(self):
        """The files of a run that ended well, and all calls of the next two."""
        self.start()
        self.twin.take_tare()
        self.run_some(60)
        demand(self.twin.end(signal.SIGTERM) == 0, "the daemon's end")
        base = {path.name: path.read_bytes() for path in self.twin.files.iterdir() if path.suffix != ".lock"}
        self.twin.seam.forget()
        for _ in range(2):
            self.start()
            self.twin.take_tare()
            self.run_some(60)
            self.twin.end()
        return base, list(self.twin.seam.record())

    def put(self, files):
        shutil.rmtree(self.twin.files)
        self.twin.files.mkdir()
        for name, data in files.items():
            (self.twin.files / name).write_bytes(data)

    def trial(self, cut, base):
        demand("twin.checkpoint" in cut.files, "no checkpoint")
        saved_s = kept_files.saved_unix_s(cut.files["twin.checkpoint"])
        demand(saved_s >= kept_files.saved_unix_s(cut.checkpoint), "an older checkpoint than the one that was synced")
        revision, tare_m = kept_files.orders(cut.files["twin.checkpoint.orders"])
        demand(revision >= kept_files.orders(cut.orders)[0], "older orders than those that were synced")
        self.put(cut.files)
        self.twin.seam.forget()
        self.start()
        tare_um, fault = self.twin.floats(twin.TARE, 1)[0], self.twin.fault()
        self.run_some(10)
        self.twin.end()
        demand(abs(tare_um - 1e6 * tare_m) < 1e-3, f"tare {tare_um} um, in the file {1e6 * tare_m} um")
        demand(fault == 0, f"fault {fault}")
        demand("with what the estimator knew" in self.twin.log(), "not resumed")
        # A cycle has ten milliseconds here, and the fake device's constant readings are stuck before and after.
        demand(not re.search(r" error | warning (?!\d+ cycles missed|sensor \S+: failed, stuck)", self.twin.log()), "a complaint")
        self.check_history(base)
        expected = re.compile(r"twin\.checkpoint(\.orders)?|parameters\.csv|history.*|.*\.lock")
        written_now = [pathlib.Path(call.path).name for call in self.twin.seam.record() if call.kind == seam.OPENS]
        left = [path.name for path in self.twin.files.iterdir()
                if not expected.fullmatch(path.name) and path.name not in written_now]
        demand(not left, f"left beside the files: {left}")

    def check_history(self, base):
        if self.history.endswith(".sqlite"):
            self.check_database(base)
            return
        wanted = [kept_files.history_sequences(data, name) for name, data in base.items() if name.startswith("history")]
        found = []
        for path in sorted(self.twin.files.glob("history*.csv")):
            found.append(kept_files.history_sequences(path.read_bytes(), path.name, may_end_within=path.name == self.history))
        demand(all(each in found for each in wanted), "rows of the run before are lost")

    def check_database(self, base):
        demand(not list(self.twin.files.glob("history.0*")), "the database was put aside")
        database = sqlite3.connect(self.twin.files / self.history)
        demand(database.execute("PRAGMA integrity_check").fetchall() == [("ok",)], "the history is damaged")
        rows = database.execute(ROWS).fetchall()
        database.close()
        demand(all(last - first + 1 == count for _, first, last, count in rows), f"a run with a gap: {rows}")
        demand(rows and rows[0] == base, f"rows of the run before are lost: {rows}, there were {base}")

    def told(self):
        return self.twin.log()


def rows_of_database(folder, base):
    for name, data in base.items():
        (folder / name).write_bytes(data)
    database = sqlite3.connect(folder / "history.sqlite")
    row = database.execute(ROWS).fetchone()
    database.close()
    return row


def main():
    options, programs = options_of(__doc__, trials=0, lanes=4)
    device = twin.Device([28.5, 28.25, 28.0, 21.5, 6000.0, 1.0])
    totals, failures, chance = collections.Counter(), [], random.Random(options.seed)
    with tempfile.TemporaryDirectory() as name:
        for history in ("history.csv", "history.sqlite"):
            lanes = [Lane(programs, pathlib.Path(name) / f"{history}.{n}", device.port, history) for n in range(options.lanes)]
            base, calls = lanes[0].record()
            demand(calls, "calls that the seam has seen: was it loaded?")
            cuts = cuts_of(lanes[0].twin.files, base, calls, chance)
            totals[f"{history}: calls"] = len(calls)
            if history.endswith(".sqlite"):
                other = pathlib.Path(name) / "base"
                other.mkdir()
                base = rows_of_database(other, base)
            chance.shuffle(cuts)
            chosen = cuts[:options.trials // 2] if options.trials else cuts
            failures += work_off(lanes, [(cut.kind, cut.number, (cut, base)) for cut in chosen], totals)
    print(json.dumps(dict(sorted(totals.items())), indent=2))
    if failures:
        raise SystemExit("\n".join(failures))


if __name__ == "__main__":
    main()
