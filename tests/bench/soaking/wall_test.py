"""The daemon at 10 cycles a second by the clock of the wall, on a computer whose processors are all busy.

wall_test.py DAEMON MAKE_SMALL_NETWORK [--minutes N] [--priority ordinary|unit|real-time]
Some seconds beside idle-priority loops, in which every period must be made or counted as missed. With --minutes beside
stress-ng, and at the most one period in ten thousand may be missed.
"""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "system"))

from running_daemon import PROGRAMS, CONFIG, RunningDaemon, main  # noqa: E402
from ports import wait_until  # noqa: E402

PERIOD_S = 0.1
MOST_MISSED = 1e-4
SLACK = 3.0  # periods: a cycle begins within its period, and is published when it ends
SEQUENCE, OVERRUNS = 8, 30
# As firmware/service has them: no unit at all, spindle-twind.service, real-time.conf; that one's memory is locked where
# this computer lets root raise the limit.
PRIORITIES = {"ordinary": [], "unit": ["nice", "-n", "-5"],
              "real-time": ["sh", "-c", 'ulimit -l unlimited 2>/dev/null; exec chrt --fifo 20 "$@"', "sh"]}
OPTIONS = argparse.Namespace(minutes=None, priority="ordinary")


class Wall(RunningDaemon):
    config_text = CONFIG.replace("clock_rate = 10.0", f"period_s = {PERIOD_S}").replace(
        "timeout_s = 2.0", f"timeout_s = 2.0\npoll_s = {PERIOD_S}")

    def start(self, command, **options):
        is_daemon = command[0] == PROGRAMS["daemon"]
        return super().start([*(PRIORITIES[OPTIONS.priority] if is_daemon else []), *command], **options)

    def start_load(self, seconds):
        """All processors busy; gives the process whose output says how much was done, if there is one."""
        if OPTIONS.minutes is None:
            for _ in range(os.cpu_count()):
                self.start(["nice", "-n", "19", "sh", "-c", "while :; do :; done"])
            return None
        return self.start(["stress-ng", "--cpu", 0, "--vm", 1, "--vm-bytes", "256M", "--io", 1, "--switch", 1,
                           "--timeout", f"{seconds:.0f}s", "--metrics-brief", "--temp-path", self.folder],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def counts(self):
        """Cycles made and periods missed, of one answer."""
        words = self.read(SEQUENCE, OVERRUNS + 2 - SEQUENCE)
        number = lambda at: words[at - SEQUENCE] << 16 | words[at - SEQUENCE + 1]  # noqa: E731
        return number(SEQUENCE), number(OVERRUNS)

    def fresh_counts(self):
        """The counts that a new cycle has just published, and the times between which it did: a count may lag behind
        the clock by as long as the daemon had to wait for a processor, but not when its cycle has just been made."""
        earlier_s = time.monotonic()
        cycles = self.counts()[0]
        while True:
            asked_s = time.monotonic()
            counts = self.counts()
            if counts[0] != cycles:
                return earlier_s, time.monotonic(), *counts
            earlier_s = asked_s
            time.sleep(0.1 * PERIOD_S)

    def test_every_period_is_made_or_counted(self):
        self.write_signals()
        self.wait_for_state(1)
        seconds = 4.0 if OPTIONS.minutes is None else 60.0 * OPTIONS.minutes
        load = self.start_load(seconds + 2.0)
        time.sleep(1.0)
        begin_earliest_s, begin_latest_s, cycles, missed = self.fresh_counts()
        last_missed, worst = missed, 0
        while (now_s := time.monotonic()) < begin_latest_s + seconds:
            now_missed = self.counts()[1]
            worst, last_missed = max(worst, now_missed - last_missed), now_missed
            self.write_signals()
            time.sleep(min(1.0, max(0.0, begin_latest_s + seconds - now_s)))
        end_earliest_s, end_latest_s, end_cycles, end_missed = self.fresh_counts()
        passed_s = end_latest_s - begin_latest_s
        cycles, missed = end_cycles - cycles, end_missed - missed
        told = {"priority": OPTIONS.priority, "memory_locked": "memory locked" in self.log_text(),
                "processors": os.cpu_count(), "seconds": round(passed_s, 1),
                "cycles": cycles, "missed": missed, "share": missed / (cycles + missed),
                "most_missed_between_readings": worst, "load_average": os.getloadavg()}
        if load is not None:
            told["load"] = [line for line in load.communicate()[0].splitlines() if "metrc" in line or "fail" in line]
        print(json.dumps(told, indent=2))
        self.assertGreaterEqual(cycles + missed, (end_earliest_s - begin_latest_s) / PERIOD_S - SLACK)
        self.assertLessEqual(cycles + missed, (end_latest_s - begin_earliest_s) / PERIOD_S + SLACK)
        self.assertGreater(cycles, 0)
        self.assertIsNone(self.daemon.poll())
        wait_until(lambda: self.read(10, 1)[0] == 1, "state running")
        if OPTIONS.minutes is not None:
            self.assertEqual(load.returncode, 0, told["load"])
            self.assertLessEqual(told["share"], MOST_MISSED)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("programs", nargs=2)
    parser.add_argument("--minutes", type=float)
    parser.add_argument("--priority", choices=PRIORITIES, default="ordinary")
    parser.parse_args(namespace=OPTIONS)
    if OPTIONS.minutes is not None and shutil.which("stress-ng") is None:
        sys.exit("stress-ng is missing: apt install stress-ng")
    sys.argv = sys.argv[:1] + OPTIONS.programs
    main()
