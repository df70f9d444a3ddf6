"""The daemon under load from all sides: readers, a PLC, slow clients and malformed frames at once.

load_test.py DAEMON MAKE_SMALL_NETWORK MODBUS_LOAD_CLIENTS [--long]
A few seconds, in which nothing may be lost; --long is a minute at 10 cycles a second, in which answers must be quick too.
"""
import json
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "system"))

from running_daemon import PROGRAMS, CONFIG, RunningDaemon, main  # noqa: E402

LONG = "--long" in sys.argv
SECONDS, READS_PER_S, MALFORMED = (60, 5000, 1_000_000) if LONG else (4, 500, 20_000)
SLOWEST_P99_MS = 50.0
MOST_GROWTH_KB = 4096
SEQUENCE, OVERRUNS = 8, 30


class Load(RunningDaemon):
    config_text = (CONFIG.replace("clock_rate = 10.0", f"period_s = {0.1 if LONG else 1.0}")
                   .replace("[device]", "connections = 256\nconnections_per_host = 256\n[device]", 1))

    def memory_kB(self, which):
        status = pathlib.Path(f"/proc/{self.daemon.pid}/status").read_text()
        return int(next(line for line in status.splitlines() if line.startswith(which)).split()[1])

    def processor_s(self):
        fields = pathlib.Path(f"/proc/{self.daemon.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / 100

    def counter(self, at):
        high, low = self.read(at, 2)
        return high << 16 | low

    def load(self, **options):
        command = [PROGRAMS["clients"], "--port", self.port]
        for name, value in options.items():
            command += [f"--{name.replace('_', '-')}", value]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def test_nothing_is_lost_and_the_cycle_is_not_held_up(self):
        self.write_signals()
        self.wait_for_state(1)
        self.load(seconds=1, reads_per_s=100, malformed=100)  # what is taken once is taken
        memory_kB, cycles, overruns = self.memory_kB("VmRSS"), self.counter(SEQUENCE), self.counter(OVERRUNS)
        processor_s = self.processor_s()
        told = self.load(seconds=SECONDS, reads_per_s=READS_PER_S, malformed=MALFORMED)
        told["daemon"] = {"cycles": self.counter(SEQUENCE) - cycles, "missed": self.counter(OVERRUNS) - overruns,
                          "memory_kB": memory_kB, "growth_kB": self.memory_kB("VmHWM") - memory_kB,
                          "processor_s": round(self.processor_s() - processor_s, 2)}
        print(json.dumps(told, indent=2))
        for kind in ("readers", "plc"):
            self.assertGreater(told[kind]["requests"], 0)
            self.assertEqual((told[kind]["wrong"], told[kind]["missing"]), (0, 0), kind)
        malformed = told["malformed"]
        self.assertEqual(malformed["wrong"], 0)
        self.assertEqual(malformed["frames"], MALFORMED)
        self.assertTrue(all(malformed[what] > 0 for what in ("refused", "ended", "cut")), malformed)
        self.assertGreater(told["slow"]["ended_drips"], 0)
        self.assertEqual(told["daemon"]["missed"], 0)
        self.assertGreater(told["daemon"]["cycles"], 0)
        self.assertLess(told["daemon"]["growth_kB"], MOST_GROWTH_KB)
        self.assertIsNone(self.daemon.poll())
        if LONG:
            self.assertGreater(told["readers"]["requests"], 0.99 * READS_PER_S * SECONDS)
            for kind in ("readers", "plc"):
                self.assertLess(told[kind]["p99_ms"], SLOWEST_P99_MS, kind)


if __name__ == "__main__":
    sys.argv = [argument for argument in sys.argv if argument != "--long"]
    main("clients")
