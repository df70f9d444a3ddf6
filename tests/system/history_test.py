"""The history in SQLite: replayed, exported, and after kills, on a full and on a read-only disk.

history_test.py DAEMON MAKE_SMALL_NETWORK SPINDLE_TWIN [unittest options]
"""
import csv
import json
import os
import random
import shutil
import signal
import struct
import subprocess
import sys
import time
import unittest

from ports import can_connect, wait_until
from running_daemon import PROGRAMS, RunningDaemon, float32, main

HISTORY_LOST = 128
NOSE_UM = 20  # nose_float32
READ = """
import json, sqlite3, sys
database = sqlite3.connect(f"file:{sys.argv[1]}?mode=rw", uri=True, timeout=20)
print(json.dumps([database.execute("PRAGMA integrity_check").fetchall(),
                  database.execute("SELECT run, sequence FROM cycle ORDER BY id").fetchall()]))
"""
FIRST_TIME = """
import sqlite3, sys
print(*sqlite3.connect(sys.argv[1]).execute("SELECT unix_s FROM cycle ORDER BY id LIMIT 1").fetchone())
"""
MOUNTS = os.geteuid() == 0 and subprocess.run(["unshare", "-m", "true"], capture_output=True).returncode == 0


class History(RunningDaemon):
    clock_rate = 10.0
    path = "history.sqlite"
    where = ()  # in front of a command: where it sees the history

    def setUp(self):
        super().setUp()
        self.stop(signal.SIGKILL)
        for file in self.folder.glob("history*"):
            file.unlink()
        for file in self.folder.glob("twin.checkpoint*"):
            file.unlink()
        text = self.config.read_text().replace('"history.csv"', f'"{self.path}"')
        self.config.write_text(text.replace("clock_rate = 10.0", f"clock_rate = {self.clock_rate}"))

    def stop(self, by=signal.SIGTERM):
        self.daemon.send_signal(by)
        self.daemon.wait(20)

    def tool(self, *arguments):
        return subprocess.run([PROGRAMS["tool"], *map(str, arguments)], capture_output=True, text=True, timeout=120)

    def read_database(self, path):
        return subprocess.run([*self.where, sys.executable, "-c", READ, path], capture_output=True, text=True, timeout=60)

    def runs(self, path):
        """Sequences of each run, by its id, of a database that is whole."""
        result = self.read_database(path)
        self.assertEqual(result.returncode, 0, result.stderr)
        integrity, rows = json.loads(result.stdout)
        self.assertEqual(integrity, [["ok"]])
        runs = {}
        for run, sequence in rows:
            runs.setdefault(run, []).append(int(sequence))
        return runs

    def rows(self):
        """Rows that the file holds now, 0 where it or its tables are not there yet."""
        result = self.read_database(self.folder / self.path)
        return len(json.loads(result.stdout)[1]) if result.returncode == 0 else 0

    def assert_without_gaps(self, runs):
        for run, sequences in runs.items():
            self.assertEqual(sequences, list(range(sequences[0], sequences[0] + len(sequences))), f"run {run}")


class Replay(History):
    def test_a_replay_of_the_database_and_of_its_csv_gives_what_the_daemon_said_to_the_last_digit(self):
        self.start_again()
        self.write_signals()
        self.wait_for_state(1)
        wait_until(lambda: self.read(922, 2)[1] >= 6, "six updates of the estimator")
        self.stop()
        database, export = self.folder / self.path, self.folder / "export.csv"
        listed = self.tool("history", database)
        self.assertEqual((listed.returncode, listed.stderr), (0, ""))
        self.assertEqual(len(listed.stdout.splitlines()), 2)
        self.assertRegex(listed.stdout.splitlines()[1], r"^ +1  20\d\d-\d\d-\d\d .* small$")
        written = self.tool("history", database, "--csv", export)
        self.assertEqual((written.returncode, written.stderr), (0, ""))
        replayed = []
        for log in (database, export):
            out = self.folder / "replayed.csv"
            result = self.tool("replay", self.folder / "small.rom", log, "--config", self.config, "-o", out)
            self.assertEqual(result.returncode, 0, result.stderr)
            replayed.append(out.read_text())
        self.assertEqual(replayed[0], replayed[1])
        said, again = list(csv.DictReader(export.read_text().splitlines())), list(csv.DictReader(replayed[0].splitlines()))
        self.assertEqual(len(said), len(again))
        self.assertGreater(len(said), 25)  # a busy machine misses cycles
        compared = [name for name in said[0] if name.split(".")[0] in ("predicted", "deformation_raw", "predicted_sd", "heat_factor")]
        self.assertGreater(len(compared), 6)
        for told, repeated in zip(said, again):
            for name in compared:
                self.assertEqual(f"{float(told[name]):.9g}" if told[name] else "", repeated[name], name)
        for arguments in (("--run", 99), ("--csv", export, "--run", 99)):
            command = ("replay", self.folder / "small.rom", database) if arguments[0] == "--run" else ("history", database)
            result = self.tool(*command, *arguments)
            self.assertEqual(result.returncode, 1)
            self.assertIn(f"{database}: run: there is no 99; allowed: 1", result.stderr)

    @unittest.skipUnless(MOUNTS, "mounting needs root")
    def test_a_history_on_a_disk_that_cannot_be_written_is_read(self):
        self.start_again()
        self.wait_for_state(2)
        self.stop()
        disk = self.folder / "disk"
        disk.mkdir()
        shutil.copy(self.folder / self.path, disk)
        script = 'mount --bind "$1" "$1" && mount -o remount,ro,bind "$1" && exec "$0" history "$1/history.sqlite"'
        result = subprocess.run(["unshare", "-m", "sh", "-c", script, PROGRAMS["tool"], disk], capture_output=True, text=True)
        self.assertEqual((result.returncode, len(result.stdout.splitlines())), (0, 2), result.stderr)


class Evaluate(History):
    clock_rate = 100.0  # a warm-up within seconds

    def touch_off(self, share):
        """Hands over `share` of the growth that the daemon says, so unsure that it hardly changes what it says next."""
        nose_um = float32(*self.read(NOSE_UM, 2))
        words = struct.unpack(">4H", struct.pack(">2f", share * nose_um, 50.0))
        self.assertFalse(self.client.write_registers(1010, [*words, 0, 1], slave=1).isError())
        return nose_um

    def warm_up(self, share):
        """A run with six touch-offs."""
        self.start_again()
        self.write_signals()
        self.wait_for_state(1)
        before_um = -1.0
        for _ in range(6):
            wait_until(lambda: float32(*self.read(NOSE_UM, 2)) > before_um + 1.0, "growth")  # well above a late answer's
            before_um = self.touch_off(share)
        time.sleep(0.5)
        self.stop()
        (self.folder / "twin.checkpoint").unlink()

    def test_touch_offs_say_whether_the_compensation_helps_and_a_wrong_sign_makes_it_worse(self):
        self.warm_up(1.0)
        helps = self.tool("evaluate", self.folder / self.path, "--json")
        self.assertEqual((helps.returncode, helps.stderr), (0, ""))
        said = json.loads(helps.stdout)
        self.assertEqual((said["whole"]["readings"], said["whole"]["verdict"]), (5, "helps"))
        self.assertLess(said["whole"]["left_rms_um"], 0.2 * said["whole"]["growth_rms_um"])
        self.assertEqual(len(said["weeks"]), 1)
        self.warm_up(-1.0)
        self.warm_up(-1.0)
        worse = self.tool("evaluate", self.folder / self.path)
        self.assertEqual(worse.returncode, 3)
        self.assertIn("the compensation of nose makes it worse; check sign, unit and network", worse.stderr)
        self.assertRegex(worse.stdout, r"(?m)^all +15 .* makes it worse$")

    def test_parts_made_with_the_wrong_sign_are_named(self):
        self.start_again()
        self.write_signals()
        self.wait_for_state(1)
        start_um = float32(*self.read(NOSE_UM, 2))
        start_s = time.time()
        wait_until(lambda: float32(*self.read(NOSE_UM, 2)) > start_um + 6.0 and time.time() > start_s + 6.0, "a warm-up")
        self.stop()
        parts = self.folder / "parts.csv"
        parts.write_text("time_utc,growth_um,compensated\n" + "".join(
            f"{time.strftime('%Y-%m-%d %H:%M:%S', time.gmtime(second))},{2.0 * nose_um},1\n"
            for second, nose_um in self.published_at_whole_seconds(start_s)))
        result = self.tool("evaluate", self.folder / self.path, "--measured", parts)
        self.assertEqual(result.returncode, 3, result.stdout + result.stderr)
        self.assertRegex(result.stdout, r"the control applies -\d\.\d\d times what is published: with the wrong sign")

    def published_at_whole_seconds(self, from_s):
        """(unix second, nose) of the last row before each whole second since `from_s`; a file by hand has no finer."""
        export = self.folder / "export.csv"
        written = self.tool("history", self.folder / self.path, "--csv", export)
        self.assertEqual(written.returncode, 0, written.stderr)
        rows = list(csv.DictReader(export.read_text().splitlines()))
        first_s = json.loads(subprocess.run([sys.executable, "-c", FIRST_TIME, self.folder / self.path],
                                            capture_output=True, text=True, check=True).stdout)
        published = {}
        for row in rows:
            unix_s = first_s + 1e-9 * (float(row["clock_ns"]) - float(rows[0]["clock_ns"]))
            if unix_s >= from_s:
                published[int(unix_s) + 1] = float(row["deformation.nose_um"])
        return list(published.items())[:-1]  # the last second has no row after it


class Kills(History):
    clock_rate = 1000.0  # a cycle each millisecond

    def test_a_kill_at_any_moment_leaves_a_whole_file_and_each_start_begins_a_run(self):
        rows = 0  # of the file; what was once read in it stays
        starts_seen = 0
        chance = random.Random(1)
        for start in range(10):
            self.start_again()
            wait_until(lambda: self.read(8, 2)[1] > 50, "fifty cycles")
            if start % 2 == 0:  # the others are killed also before their first row is written
                wait_until(lambda: self.rows() > rows, "rows of this start in the file")
                rows = self.rows()
                starts_seen += 1
            time.sleep(chance.uniform(0.05, 0.4))
            self.stop(signal.SIGKILL)
            runs = self.runs(self.folder / self.path)
            self.assert_without_gaps(runs)
            self.assertGreaterEqual(sum(map(len, runs.values())), rows)
            self.assertGreaterEqual(len(runs), starts_seen)
            rows = sum(map(len, runs.values()))
        self.assertEqual(self.tool("history", self.folder / self.path).returncode, 0)


@unittest.skipUnless(MOUNTS, "mounting needs root")
class Disks(History):
    clock_rate = 1000.0
    path = "disk/history.sqlite"

    def start_on(self, script):
        """A daemon that sees a disk of its own, as `script` makes it of the folder $1."""
        self.disk = self.folder / "disk"
        self.disk.mkdir()
        self.daemon = self.start(["unshare", "-m", "sh", "-c", script + ' && exec "$0" "$2"', PROGRAMS["daemon"],
                                  self.disk, self.config], stderr=self.log)
        wait_until(lambda: can_connect(self.port), "the daemon's port")
        self.client.close()
        self.assertTrue(self.client.connect())
        self.where = ("nsenter", "-t", str(self.daemon.pid), "-m")

    def on_the_disk(self, *command):
        subprocess.run([*self.where, *map(str, command)], check=True)

    def is_lost(self):
        return self.read(12, 1)[0] & HISTORY_LOST

    def newest_run(self):
        runs = self.runs(self.disk / "history.sqlite")
        self.assert_without_gaps(runs)
        return max(runs)

    def test_on_a_full_disk_rows_are_counted_the_cycle_goes_on_and_so_does_the_history_when_there_is_room(self):
        self.start_on('mount -t tmpfs -o size=24M tmpfs "$1" && head -c 18M /dev/zero > "$1/ballast"')
        wait_until(self.is_lost, "the disk to be full")
        wait_until(lambda: self.read(1432, 2) != [0, 0], "lost rows to be counted")
        before = self.read(8, 2)
        wait_until(lambda: self.read(8, 2) > before, "the cycle to go on")
        last = self.newest_run()
        self.on_the_disk("rm", self.disk / "ballast")
        wait_until(lambda: not self.is_lost(), "the history to go on")
        wait_until(lambda: self.newest_run() > last, "a run of its own")
        self.assert_logged("is written again")

    def test_a_read_only_disk_is_a_fault_until_it_can_be_written(self):
        self.start_on('mount -t tmpfs -o ro tmpfs "$1"')
        wait_until(self.is_lost, "the fault")
        self.on_the_disk("mount", "-o", "remount,rw", self.disk)
        wait_until(lambda: not self.is_lost(), "the history to be written")
        wait_until(self.newest_run, "rows")


if __name__ == "__main__":
    PROGRAMS["tool"] = os.path.abspath(sys.argv.pop(3))
    main()
