"""kill -9 at random instants, half of them inside a checkpoint: the daemon goes on from the newest state or the one before.

kill_test.py DAEMON MAKE_SMALL_NETWORK FILE_SEAM [--kills 1000] [--seed 1] [--lanes 8]
Beside a twin that is never interrupted and reads the same device, `--lanes` others are killed and started again. Every
second kill strikes a call on the checkpoint's file or folder, within it where it writes; every tenth is followed by one
inside an order's. After each: the file is the newest that got its name or the one that was about to; the daemon goes on
from it, with the tare that was acknowledged last (or ordered since), and leaves nothing beside the files. 60 s of the
model after the start the key points are within 0.1 K of the uninterrupted twin's, or within 0.3 K where the speed has
made a step since the checkpoint, and the nose is within 2 of the standard deviations that the two say together.
A fifth of the kills at an instant come while the daemon starts, the others 400 to 500 s of the model after it: what was
learnt since the last checkpoint is lost with it, and a twin that is killed all the time does not know what the other does.
"""
import collections
import json
import math
import pathlib
import random
import re
import tempfile
import time
import traceback

import kept_files
import seam
import twin
from kept_files import demand
from lanes import options_of, run_side_by_side
from ports import wait_until

CLOCK_RATE, INTERVAL_S, CAUGHT_UP_S, LEARNT_S, WARM_S = 100.0, 100.0, 60.0, 400.0, 1000.0  # all but the rate of the model
NEAR_K, NEAR_WITH_STEP_K, NEAR_SD = 0.1, 0.3, 2.0
HISTORY = '[history]\npath = "files/history.csv"\nparameters = "files/parameters.csv"\n'
EXPECTED = re.compile(r"twin\.checkpoint(\.orders)?|parameters\.csv|history(\.\d{6})?\.csv|.*\.lock")
CALLS_OF_A_WRITING = 8  # open, write, mode, sync, rename, open and sync the folder, remove the other name


class Lane:
    """One daemon that is killed again and again."""

    def __init__(self, programs, folder, machine, seed, totals):
        more = twin.CHECKPOINT.format(interval_s=INTERVAL_S) + HISTORY
        self.twin = twin.Twin(programs, folder, machine.device.port, more, CLOCK_RATE)
        self.machine, self.reference = machine, machine.reference
        self.chance, self.totals = random.Random(seed), totals
        self.allowed = {}  # path: contents that its file may have now
        self.off = []  # of each start: K, standard deviations
        self.tare_um, self.may_be_other = 0.0, True  # while an order was under way

    def note_what_may_stand(self):
        calls = list(self.twin.seam.record())
        for path in (self.twin.checkpoint, self.twin.orders):
            newest, next_one = seam.written_whole(calls, path)
            before = self.allowed.get(path, [None])
            self.allowed[path] = ([newest] if newest is not None else before) + ([next_one] if next_one is not None else [])

    def check_files(self):
        for path, allowed in self.allowed.items():
            found = path.read_bytes() if path.exists() else None
            demand(found in allowed, f"{path.name}: neither the newest nor the one before")
            self.totals[f"{path.suffix[1:]}: " + ("about to be named" if found != allowed[0] else "named last")] += 1
            if found is not None:
                kept_files.unseal(found, "orders" if path == self.twin.orders else "checkpoint")

    def start(self):
        self.twin.seam.heal()
        self.twin.seam.forget()
        had_checkpoint, had_orders = self.twin.checkpoint.exists(), self.twin.orders.exists()
        kept_tare_um = 1e6 * kept_files.orders(self.twin.orders.read_bytes())[1] if had_orders else 0.0
        self.twin.start()
        self.twin.wait_until_it_answers()
        wait_until(lambda: self.twin.read(twin.STATE, 1)[0] in (1, 2), "a prediction")
        tare_um = self.twin.floats(twin.TARE, 1)[0]
        demand(abs(tare_um - kept_tare_um) < 1e-3 + 1e-6 * abs(tare_um), f"tare {tare_um} um, in the file {kept_tare_um} um")
        demand(self.may_be_other or tare_um == self.tare_um, f"tare {tare_um} um, acknowledged was {self.tare_um} um")
        self.tare_um, self.may_be_other = tare_um, False
        demand(self.twin.fault() & twin.ORDERS_LOST == 0, "orders_lost")
        log = self.twin.log()
        if had_checkpoint:
            demand(re.search(r"goes on from \d+ s ago, with what the estimator knew", log), f"not resumed: {log}")
        wait_until(lambda: not self.left_over(), f"nothing but the files, but there is {self.left_over()}; that")
        return had_checkpoint

    def left_over(self):
        """What lies beside the files and was not made by this start."""
        found = [each.name for each in self.twin.files.iterdir() if not EXPECTED.fullmatch(each.name)]
        made = {pathlib.Path(call.path).name for call in self.twin.seam.record() if call.kind == seam.OPENS}
        return [name for name in found if name not in made]

    def compare(self):
        """How far the key points (K) and the nose (in its own standard deviations) are from what the uninterrupted twin says
        a cycle before and a cycle after, 60 s after the start."""
        self.run_until(CAUGHT_UP_S)
        said = []
        for each in (self.reference, self.twin, self.reference):
            said.append([*each.floats(twin.POINTS, 3), each.nose_um()])
            time.sleep(1.0 / CLOCK_RATE)
        off = [max(min(a, b) - mine, mine - max(a, b), 0.0) for a, mine, b in zip(*said)]
        sd_um = math.hypot(*(each.floats(twin.NOSE_SD, 1)[0] for each in (self.reference, self.twin)))
        return max(off[:3]), off[3] / sd_um

    def run_until(self, model_s):
        wait_until(lambda: self.twin.number(twin.MODEL_TIME) >= model_s, f"{model_s} s of the model")

    def kill(self, kind):
        if kind == "instant":
            time.sleep(self.chance.uniform(0.0, INTERVAL_S / CLOCK_RATE))
            if self.chance.random() < 0.3:
                self.may_be_other = True
                self.twin.order_tare()
                time.sleep(self.chance.uniform(0.0, 0.05))
            self.twin.end()
            return
        files = seam.ORDERS if kind == "order" else seam.CHECKPOINT
        action = self.chance.choice((seam.KILLS_BEFORE, seam.KILLS_WITHIN, seam.KILLS_AFTER))
        self.twin.seam.strike(action, files, self.chance.randint(1, CALLS_OF_A_WRITING))
        if kind == "order":
            self.may_be_other = True
            self.twin.order_tare()
        self.twin.gone()

    def live(self, kind):
        """One start and its end."""
        step = self.machine.step_at(self.twin.checkpoint.stat().st_mtime) if self.twin.checkpoint.exists() else 0
        resumed = self.start()
        if kind == "instant" and self.chance.random() < 0.2:
            time.sleep(self.chance.uniform(0.0, 0.2))
            self.twin.end()
        else:
            off_K, off_sd = self.compare()
            if resumed:
                self.off.append((off_K, off_sd, self.machine.step() != step))
            self.run_until(LEARNT_S)
            if self.chance.random() < 0.3:
                self.tare_um = self.twin.take_tare()
            self.kill(kind)
        self.totals[f"kills, {kind}"] += 1
        self.note_what_may_stand()
        self.check_files()

    def run(self, kinds, failures):
        try:
            self.start()
            self.run_until(WARM_S)
            self.kill("instant")
            self.note_what_may_stand()
            while kinds and not failures:
                self.live(kinds.popleft())
            self.start()
            self.compare()
            self.twin.end()
            for path in sorted(self.twin.files.glob("history*.csv")):
                rows = kept_files.history_sequences(path.read_bytes(), path.name, may_end_within=path.name == "history.csv")
                self.totals["rows of histories"] += len(rows)
        except Exception:  # told by the main thread, which ends the others
            failures.append(f"{self.twin.folder.name}: {traceback.format_exc()}")
            self.twin.end()


def quantiles(numbers):
    numbers.sort()
    of = {"median": 0.5, "90 %": 0.9, "99 %": 0.99, "worst": 1.0}
    return {"number": len(numbers), **{name: round(numbers[int(share * (len(numbers) - 1))], 3) for name, share in of.items()}}


def judge(lanes, told):
    """Adds what came out of the comparisons, and gives what is wrong with it."""
    wrong = []
    off = [each for lane in lanes for each in lane.off]
    for has_step, name, limit_K in ((False, "key points, one speed, K", NEAR_K),
                                    (True, "key points, a step of speed, K", NEAR_WITH_STEP_K)):
        differences_K = [off_K for off_K, _, step in off if step == has_step]
        if differences_K:
            told[name] = {**quantiles(differences_K), f"above {NEAR_K} K": sum(each > NEAR_K for each in differences_K)}
            if differences_K[-1] > limit_K:
                wrong.append(f"{name}: {differences_K[-1]:.3f} from the uninterrupted twin, allowed are {limit_K}")
    told["nose, standard deviations"] = quantiles([off_sd for _, off_sd, _ in off])
    if told["nose, standard deviations"]["worst"] > NEAR_SD:
        wrong.append(f"nose: more than {NEAR_SD} standard deviations from the uninterrupted twin's")
    return wrong


def main():
    options, programs = options_of(__doc__, kills=1000, lanes=8)
    kinds = collections.deque()
    for number in range(options.kills):
        kinds.append("checkpoint" if number % 2 else "instant")
        if number % 10 == 9:
            kinds.append("order")
    totals, failures = collections.Counter(), []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        machine = twin.Machine(programs, folder / "reference", options.seed, CLOCK_RATE)
        try:
            lanes = [Lane(programs, folder / f"lane{n}", machine, options.seed + n, totals) for n in range(options.lanes)]
            run_side_by_side(lanes, lambda lane: lane.run(kinds, failures))
        finally:
            machine.end()
    told = dict(sorted(totals.items()))
    if not failures:
        failures = judge(lanes, told)
    print(json.dumps(told, indent=2))
    if failures:
        raise SystemExit("\n".join(failures))


if __name__ == "__main__":
    main()
