"""A client that reads a twin's prediction and the block for the control some fifty times a second, and says what is wrong
with any two answers behind one another."""
import math
import socket
import struct
import threading
import time

from running_daemon import float32

PREDICTION, COMPENSATION, WORDS = 7, 1500, 30  # blocks: their first register, how many
RUNNING = 1
ROUNDING_UM = 1e-4  # of a float32 register


def long(words, at):
    return words[at] << 16 | words[at + 1]


class Connection:
    """Modbus/TCP by hand, because a client that waits for half a minute is one of the cases."""

    def __init__(self, port, patience_s):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=patience_s)
        self.transaction = 0

    def words(self, first, count):
        self.transaction = (self.transaction + 1) & 0xFFFF
        self.socket.sendall(struct.pack(">HHHBBHH", self.transaction, 0, 6, 1, 4, first, count))
        answer = b""
        while len(answer) < 9 + 2 * count:
            more = self.socket.recv(9 + 2 * count - len(answer))
            if not more:
                raise AssertionError("the daemon closed the connection")
            answer += more
        if struct.unpack(">H", answer[:2])[0] != self.transaction or answer[7] != 4:
            raise AssertionError(f"the daemon's answer is {answer.hex()}")
        return struct.unpack(f">{count}H", answer[9:])


class Stream:
    """Answers of one block in their order."""

    def __init__(self, name, limits):
        self.name, self.limits, self.before = name, limits, None

    def objections(self, sequence, value_um):
        """`limits`: um a cycle, um."""
        most_um, limit_um = self.limits
        if not math.isfinite(value_um):
            yield f"{self.name} is {value_um}"
            return
        if abs(value_um) > limit_um + ROUNDING_UM:
            yield f"{self.name} {value_um} um, its limit is {limit_um} um"
        if self.before is not None:
            cycles, step_um = sequence - self.before[0], abs(value_um - self.before[1])
            if cycles < 0:
                yield f"{self.name}: sequence {sequence} behind {self.before[0]}"
            elif step_um > cycles * most_um + ROUNDING_UM:
                yield f"{self.name} moved by {step_um} um in {cycles} cycles, allowed are {most_um} um in each"
        self.before = sequence, value_um


class Watcher:
    """Begins once the twin predicts. `objections` has what was wrong, `seen` the states and bits since clear()."""

    def __init__(self, port, period_s, nose_limits, value_limits, patience_s):
        self.connection = Connection(port, patience_s)
        self.period_s, self.objections, self.reads, self.most_away_s = period_s, [], 0, 0.0
        self.nose, self.value = Stream("nose", nose_limits), Stream("compensation", value_limits)
        self.model_s, self.lead_s, self.most_step_um = None, None, 0.0
        self.clear()
        self.read_prediction()
        self.is_on = True
        self.thread = threading.Thread(target=self.go_on)
        self.thread.start()

    def clear(self):
        self.states, self.quality, self.rungs = set(), 0, set()

    def end(self):
        self.is_on = False
        self.thread.join()
        self.connection.socket.close()

    def go_on(self):
        try:
            last = time.monotonic()
            while self.is_on and len(self.objections) < 20:
                self.read_prediction()
                self.read_compensation()
                self.reads += 1
                now = time.monotonic()
                self.most_away_s, last = max(self.most_away_s, now - last), now
                time.sleep(0.02)
        except Exception as error:  # told by the lane
            self.objections.append(repr(error))

    def read_prediction(self):
        words = self.connection.words(PREDICTION, WORDS)
        sequence, self.state, quality = long(words, 1), words[3], words[4]
        self.overruns, model_s = long(words, 23), long(words, 25)
        self.states.add(self.state)
        self.quality |= quality
        self.objections += self.nose.objections(sequence, float32(words[13], words[14]))
        # Each period counts, whether a cycle began it or not.
        lead_s = model_s - self.period_s * (sequence + self.overruns)
        if self.lead_s is None:
            self.lead_s = lead_s
        if abs(lead_s - self.lead_s) > 1.0:
            self.objections.append(f"the model's time is off its cycles by {lead_s - self.lead_s} s")
        if self.model_s is not None and model_s < self.model_s:
            self.objections.append(f"the model's time {model_s} s behind {self.model_s} s")
        self.model_s = model_s

    def read_compensation(self):
        words = self.connection.words(COMPENSATION, WORDS)
        self.rungs.add(words[6])
        before = self.value.before
        self.objections += self.value.objections(long(words, 0), float32(words[8], words[9]))
        if before is not None and self.value.before[0] > before[0]:
            cycles = self.value.before[0] - before[0]
            self.most_step_um = max(self.most_step_um, abs(self.value.before[1] - before[1]) / cycles)
