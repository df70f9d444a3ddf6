"""The compensation block as a control reads it: one block, no step by switching, loss or restart.

compensation_test.py DAEMON MAKE_SMALL_NETWORK [unittest options]
"""
import signal
import time

from ports import wait_until
from running_daemon import RunningDaemon, float32, main

BLOCK = 1500
SWITCH = 1029
ENABLED, ESTIMATOR, OPEN_LOOP, HOLD = 1, 1, 3, 4
SLEW_UM_PER_S = 0.5
CLOCK_RATE = 10.0


class Block(RunningDaemon):
    def setUp(self):
        super().setUp()
        self.config.write_text(self.config.read_text() + "[compensation]\nlook_ahead_min = 15\nsign = -1\n")
        self.daemon.terminate()
        self.daemon.wait(20)
        self.start_again()

    def block(self):
        words = self.read(BLOCK, 25)
        return {"sequence": words[0] << 16 | words[1], "state": words[3], "rung": words[6], "bits": words[7],
                "um": float32(*words[8:10]), "cdab": float32(words[11], words[10]),
                "int32": (words[12] << 16 | words[13]) - (1 << 32 if words[12] > 32767 else 0), "age": words[15],
                "sd": float32(*words[16:18]), "forecast": float32(*words[22:24]), "settled": words[24]}

    def largest_step(self, seconds):
        """Between two cycles, over so much clock time."""
        largest, before = 0.0, self.block()
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            now = self.block()
            cycles = now["sequence"] - before["sequence"]
            if cycles > 0:
                largest = max(largest, abs(now["um"] - before["um"]) / cycles)
            before = now
        return largest

    def test_all_forms_agree_and_the_sign_is_the_configured_one(self):
        self.write_signals()
        self.wait_for_state(1)
        wait_until(lambda: self.block()["um"] < -0.5, "a growth")
        block = self.block()
        self.assertEqual(block["rung"], ESTIMATOR)
        self.assertEqual(block["um"], block["cdab"])
        self.assertAlmostEqual(block["int32"] / 10, block["um"], delta=0.051)
        self.assertGreater(block["sd"], 0.0)
        wait_until(lambda: self.block()["settled"] != 65535, "a whole round of the forecast")
        self.assertLess(self.block()["forecast"], 0.0)

    def test_switching_is_no_step_and_outlives_a_kill(self):
        self.write_signals()
        self.wait_for_state(1)
        wait_until(lambda: self.block()["um"] < -1.0, "a growth")
        self.client.write_register(SWITCH, 0, slave=1)
        self.assertLessEqual(self.largest_step(2.0), SLEW_UM_PER_S * 1.01)
        wait_until(lambda: self.block()["um"] == 0.0, "the way to zero")
        self.assertEqual(self.block()["bits"] & ENABLED, 0)
        wait_until(lambda: self.read(1420, 1) == [2], "the order is on the disk")
        self.daemon.send_signal(signal.SIGKILL)
        self.daemon.wait(20)
        self.start_again()
        self.write_signals()
        wait_until(lambda: self.block()["state"] in (1, 2), "a prediction")
        self.assertEqual(self.block()["um"], 0.0)
        self.assertEqual(self.read(SWITCH, 1, holding=True), [0])
        self.client.write_register(SWITCH, 1, slave=1)
        self.assertLessEqual(self.largest_step(2.0), SLEW_UM_PER_S * 1.01)
        wait_until(lambda: self.block()["um"] < -1.0, "back")

    def test_a_restart_goes_on_from_where_it_was(self):
        self.write_signals()
        self.wait_for_state(1)
        wait_until(lambda: self.block()["um"] < -2.0, "a growth")
        before = self.block()["um"]
        self.daemon.terminate()
        self.daemon.wait(20)
        self.start_again()
        after = wait_until(lambda: (lambda um: um if um == um else None)(self.block()["um"]), "a value")
        self.assertLess(abs(after - before), 1.0)

    def test_the_device_gone_it_goes_on_in_the_open_loop_without_a_step(self):
        self.write_signals()
        self.wait_for_state(1)
        self.device.kill()
        self.device.wait()
        largest = self.largest_step(2.0)
        wait_until(lambda: self.block()["rung"] == OPEN_LOOP, "the open loop")
        self.assertEqual(self.block()["age"], 0)
        self.assertLessEqual(max(largest, self.largest_step(1.0)), SLEW_UM_PER_S * 1.01)


if __name__ == "__main__":
    main()
