"""Faults of the device, of the clock on the wall and of the scheduler: what the control gets never makes a step.

campaign_test.py DAEMON MAKE_SMALL_NETWORK CLOCK_SEAM [--hold 2] [--gone 4] [--stop 4] [--lanes 3] [--seed 1]
Each of `--lanes` twins reads a device of its own, at the same machine: a spindle whose heats are 0.8 of what the network
says. The faults are shared out among them, each lasts `--hold` seconds, `gone` and `cable` `--gone` seconds, `stopped`
(SIGSTOP) `--stop` seconds. Meanwhile a client reads prediction and compensation: neither moves by more in a cycle than
the slew limit nor leaves its limit, no number goes back, and the model's time is that of the cycles and of those missed.
Each fault has to be said by state, quality and log, and once it is over the state has to be `running` again.
"""
import argparse
import collections
import datetime
import json
import os
import pathlib
import random
import re
import signal
import sqlite3
import struct
import sys
import tempfile
import threading
import time
import traceback

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "killing"), str(HERE.parents[1] / "system")]

import twin  # noqa: E402
from device import Cable, Device, far_networks_are_possible  # noqa: E402
from kept_files import demand  # noqa: E402
from ports import wait_until  # noqa: E402
from watcher import RUNNING, Watcher  # noqa: E402

CLOCK_RATE, PERIOD_S = 10.0, 1.0  # ten cycles a second
SLEW_UM_PER_S, VALUE_SLEW_UM_PER_S, LIMIT_UM, VALUE_LIMIT_UM = 0.03, 0.02, 60.0, 6.0
CONFIG = """
network = "small.rom"
[serve]
port = {port}
[device]
address = "ADDRESS"
port = {device}
poll_s = 0.1
timeout_s = 0.3
retry_most_s = 1.0
""" + "".join(f'[[sensor]]\nkey_point = "sleeve_{place}"\nregister = {2 * n}\ntype = "float32"\nstale_after_s = 10.0\n'
              for n, place in enumerate(("inner", "middle", "outer"))) + f"""
[cycle]
clock_rate = {{clock_rate}}
compare_uncorrected = true
[signals]
speed = {{{{ source = "device", register = 8, type = "float32", stale_after_s = 10.0 }}}}
load = {{{{ source = "device", register = 10, type = "float32", stale_after_s = 10.0 }}}}
coolant = {{{{ source = "device", register = 6, type = "float32", stale_after_s = 10.0 }}}}
ambient = {{{{ source = "constant", value = 22.0 }}}}
[correction]
law = "estimator"
[output]
slew_um_per_s = {SLEW_UM_PER_S}
limit_um = {LIMIT_UM}
[compensation]
slew_um_per_s = {VALUE_SLEW_UM_PER_S}
limit_um = {VALUE_LIMIT_UM}
[checkpoint]
path = "files/twin.checkpoint"
interval_s = 10.0
[history]
path = "files/history.sqlite"
most_days = 1.0
{{more}}"""

MISSING, STALE, OUT_OF_RANGE, HELD, OVERRUN = 1, 2, 4, 8, 512
CLOCK_STEP_S = 400 * 86400
LINES_A_MINUTE = 6  # of one device


class Fault:
    """`change` of the answers; `quality`: bits of which one has to be up; `line`: what the log says."""

    def __init__(self, name, change, quality=STALE, line=r"does not answer \(", wait_s=0.0):
        self.name, self.change, self.quality, self.line, self.wait_s = name, change, quality, line, wait_s


def with_numbers(number):
    return lambda answer: answer[:9] + struct.pack(">f", number) * ((len(answer) - 9) // 4)


def flipped(at):
    return lambda answer: answer[:at] + bytes([answer[at] ^ 1]) + answer[at + 1:]


def shorter(answer):
    return answer[:4] + struct.pack(">H", answer[5] - 2) + answer[6:8] + bytes([answer[8] - 2]) + answer[9:-2]


def exception(code):
    return lambda answer: answer[:4] + bytes([0, 3]) + answer[6:7] + bytes([answer[7] | 0x80, code])


OTHER = r"does not answer \(its answer is of another request, unit, protocol or length\)"
FAULTS = [
    # Beyond all its wires can show: its sensors come back after five minutes of the model on probation.
    Fault("1e30", with_numbers(1e30), OUT_OF_RANGE, None),
    Fault("late", lambda answer: answer, line=r"does not answer \(no answer in time\)", wait_s=0.5),
    Fault("wrong transaction", flipped(1), line=OTHER),
    Fault("wrong protocol", flipped(3), line=OTHER),
    Fault("wrong unit", flipped(6), line=OTHER),
    Fault("wrong function", flipped(7), line=OTHER),
    Fault("length too short", shorter, line=OTHER),
    Fault("bytes too many", lambda answer: answer + b"\0\0", line=OTHER),
    Fault("half an answer", lambda answer: answer[:11], line=r"does not answer \(no answer in time\)"),
    Fault("noise", lambda answer: random.randbytes(40), line=OTHER),
    Fault("exception 2", exception(2), line=r"refuses registers 0 to 11 with exception 2"),
    Fault("exception 6", exception(6), line=r"refuses registers 0 to 11 with exception 6"),
    Fault("not a number", with_numbers(float("nan")), MISSING, None),
    Fault("infinite", with_numbers(float("inf")), MISSING, None),
    Fault("connection reset", lambda answer: None, line=r"does not answer \("),
]


class Machine(twin.Machine):
    """Told by a twin that reads a device without faults."""

    def __init__(self, programs, folder, seed):
        self.numbers = [twin.AMBIENT_DEGC] * 4 + [0.0, 0.0]
        super().__init__(programs, folder, seed, CLOCK_RATE)

    def go_on(self):
        def copy():
            while self.is_on:
                self.numbers = self.device.numbers
                time.sleep(0.5 / self.clock_rate)
        copier = threading.Thread(target=copy)
        copier.start()
        super().go_on()
        copier.join()


class Lane:
    """A twin, its device, and the faults that it has to stand."""

    def __init__(self, programs, folder, machine, number, options, figures):
        self.options, self.figures = options, figures
        cable = Cable(number) if options.has_cables else None
        self.device = Device(machine, cable)
        config = CONFIG.replace("ADDRESS", self.device.address)
        self.twin = twin.Twin(programs, folder, self.device.port, "", CLOCK_RATE, False, config)
        self.clock = folder / "clock"
        self.set_clock(0)
        self.twin.environment = {**os.environ, "LD_PRELOAD": str(options.seam), "CLOCK_SEAM": str(self.clock)}
        self.watcher = None
        self.start()

    def start(self):
        self.twin.start()
        self.twin.wait_until_it_answers()
        wait_until(lambda: self.twin.read(twin.STATE, 1)[0] == RUNNING, "state running")
        self.watcher = Watcher(self.twin.port, PERIOD_S, (SLEW_UM_PER_S * PERIOD_S, LIMIT_UM),
                               (VALUE_SLEW_UM_PER_S * PERIOD_S, VALUE_LIMIT_UM), self.options.stop + 60.0)

    def end(self):
        self.watcher.end()
        self.note_watched()
        self.twin.end()
        self.device.go()
        if self.device.cable:
            self.device.cable.end()

    def note_watched(self):
        self.figures["answers judged"] += 2 * self.watcher.reads
        most = self.figures.setdefault("largest step of the compensation, share of the slew limit", 0.0)
        share = self.watcher.most_step_um / (VALUE_SLEW_UM_PER_S * PERIOD_S)
        self.figures["largest step of the compensation, share of the slew limit"] = max(most, round(share, 4))

    def lines_of_a_minute(self):
        """On the device, in the log."""
        found = re.findall(r"^(\S+ \S+?)\.\d+ \w+ device ", self.twin.log_path.read_text(), re.MULTILINE)
        now = datetime.datetime.fromtimestamp(time.time() + self.ahead_s)
        return sum((now - datetime.datetime.fromisoformat(each)).total_seconds() < 62.0 for each in found)

    def wait_for(self, line, seconds):
        """In the log, where its limit lets the line pass."""
        if line is None or not self.log_has_room:
            return
        wait_until(lambda: re.search(line, self.twin.log()), f"log: {line}", seconds)
        self.figures["lines in the log"] += 1

    def recover(self, name):
        """Back in the state `running`, and two seconds on."""
        began = time.monotonic()
        wait_until(lambda: self.watcher.state == RUNNING or self.watcher.objections, f"running again after {name}")
        took_s = time.monotonic() - began
        self.figures[f"running again after, s: {name}"] = round(took_s, 1)
        time.sleep(min(2.0, self.options.hold))
        self.check(name)

    def check(self, name):
        demand(not self.watcher.objections, f"{name}: {self.watcher.objections[:5]}")

    def stand(self, name, begin, over, hold_s, quality, line):
        self.twin.log_from = self.twin.log_path.stat().st_size
        self.log_has_room = self.lines_of_a_minute() + 2 <= LINES_A_MINUTE
        self.watcher.clear()
        begin()
        began = time.monotonic()
        wait_until(lambda: self.watcher.quality & quality or self.watcher.objections, f"{name}: a bit of {quality}", 10.0)
        self.wait_for(line, 10.0)
        time.sleep(max(0.0, began + hold_s - time.monotonic()))
        demand(2 in self.watcher.states and 3 not in self.watcher.states, f"{name}: states {self.watcher.states}")
        self.check(name)
        over()
        self.recover(name)
        self.figures["faults"] += 1

    def stand_fault(self, fault):
        def begin():
            self.device.change, self.device.wait_s = fault.change, fault.wait_s
        self.stand(fault.name, begin, self.device.be_well, self.options.hold, fault.quality, fault.line)

    def stand_gone(self):
        self.stand("gone", self.device.go, self.device.come, self.options.gone, STALE, r"does not answer \(")

    def stand_cable(self):
        self.stand("cable", self.device.cable.pull, lambda: self.device.cable.pull(out=False), self.options.gone, STALE,
                   r"does not answer \(no answer in time\)")

    def stand_stop(self):
        self.twin.log_from = self.twin.log_path.stat().st_size
        self.watcher.clear()
        before = self.watcher.overruns
        self.watcher.most_away_s = 0.0
        self.twin.daemon.send_signal(signal.SIGSTOP)
        time.sleep(self.options.stop)
        self.twin.daemon.send_signal(signal.SIGCONT)
        wait_until(lambda: self.watcher.overruns > before, "missed cycles")
        wait_until(lambda: re.search(r"\d+ cycles missed", self.twin.log()), "log: cycles missed")
        missed, wanted = self.watcher.overruns - before, self.options.stop * CLOCK_RATE / PERIOD_S
        demand(abs(missed - wanted) < 0.2 * wanted + 5, f"{missed} cycles missed")
        self.recover("stopped")
        demand(self.watcher.most_away_s > 0.8 * self.options.stop, "the client was answered by a stopped process")
        self.figures["faults"] += 1

    def rows(self):
        database = sqlite3.connect(f"file:{self.twin.files / 'history.sqlite'}?mode=ro", uri=True)
        try:
            return database.execute("SELECT count(*) FROM cycle").fetchone()[0]
        finally:
            database.close()

    def set_clock(self, seconds):
        """On the wall, by which it is ahead."""
        if not self.clock.exists():
            self.clock.write_bytes(bytes(8))
        with open(self.clock, "r+b") as file:
            file.write(struct.pack("=q", seconds))
        self.ahead_s = seconds

    def stand_clock(self, seconds, way):
        """No cycle notices, no row goes; and after a kill, with the clock right again, the checkpoint is as old as it is."""
        self.twin.log_from = self.twin.log_path.stat().st_size
        self.watcher.clear()
        rows, overruns = self.rows(), self.watcher.overruns
        self.set_clock(seconds)
        wait_until(lambda: re.search(f"the clock on the wall was set {way} by", self.twin.log()), "log: the clock was set")
        time.sleep(self.options.hold)
        demand(self.watcher.states == {RUNNING}, f"clock set {way}: states {self.watcher.states}")
        demand(self.rows() >= rows, f"clock set {way}: {rows} rows before, {self.rows()} now")
        missed, cycles = self.watcher.overruns - overruns, self.options.hold * CLOCK_RATE / PERIOD_S
        demand(missed < 0.5 * cycles, f"clock set {way}: {missed} cycles missed")
        self.check(f"clock set {way}")
        self.watcher.end()
        self.note_watched()
        self.twin.end()
        self.set_clock(0)
        self.start()
        demand(re.search(r"goes on from \d{1,2} s ago, with what the estimator knew", self.twin.log()),
               f"clock set {way}: not resumed: {self.twin.log()}")
        self.figures["faults"] += 1

    def stand_clocks(self):
        """Rows may be a day old, checkpoints half a day."""
        self.stand_clock(-CLOCK_STEP_S, "back")
        self.stand_clock(CLOCK_STEP_S, "forward")

    def works(self):
        """What this device and this place can be asked to stand, by name."""
        works = {"clock": Lane.stand_clocks, "stopped": Lane.stand_stop, "gone": Lane.stand_gone}
        if self.device.cable:
            works["cable"] = Lane.stand_cable
        return works | {fault.name: lambda lane, fault=fault: lane.stand_fault(fault) for fault in FAULTS}


def work_off(lane, waiting, failures):
    while not failures:
        try:
            name, work = waiting.popleft()
        except IndexError:
            return
        try:
            work(lane)
        except Exception:  # told by the main thread
            failures.append(f"{name}: {traceback.format_exc()}{lane.twin.log()}")


def options_of():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", nargs=3, type=pathlib.Path)
    for name, default in (("hold", 2.0), ("gone", 4.0), ("stop", 4.0)):
        parser.add_argument(f"--{name}", type=float, default=default)
    parser.add_argument("--lanes", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", help="one fault, by its name")
    options = parser.parse_args()
    options.seam = options.programs[2].resolve()
    options.has_cables = far_networks_are_possible()
    return options


def in_own_network():
    """Goes on in a network namespace of its own where it may make one."""
    if os.environ.get("SPINDLE_TWIN_OWN_NETWORK") or not far_networks_are_possible():
        return
    os.environ["SPINDLE_TWIN_OWN_NETWORK"] = "1"
    os.execvp("unshare", ["unshare", "--net", "sh", "-c", 'ip link set lo up && exec "$@"', "_", sys.executable, "-B",
                          *sys.argv])


def main():
    options = options_of()
    in_own_network()
    random.seed(options.seed)
    programs = dict(zip(("daemon", "make_network"), (path.resolve() for path in options.programs)))
    figures, failures, lanes = collections.Counter(), [], []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        machine = Machine(programs, folder / "reference", options.seed)
        try:
            for number in range(options.lanes):
                lanes.append(Lane(programs, folder / f"lane{number}", machine, number, options, figures))
            works = lanes[0].works()
            waiting = collections.deque((each, work) for each, work in works.items() if options.only in (None, each))
            threads = [threading.Thread(target=work_off, args=(lane, waiting, failures)) for lane in lanes]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
        finally:
            for lane in lanes:
                lane.end()
            machine.end()
    if not options.has_cables:
        print("no right to make network namespaces: no cable was pulled")
    print(json.dumps(dict(sorted(figures.items())), indent=2))
    if failures:
        raise SystemExit("\n".join(failures))


if __name__ == "__main__":
    main()
