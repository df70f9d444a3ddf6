"""The page of commissioning in Chromium beside a daemon whose compensation a simulated control reads by Modbus: what the page
says of sign, unit and scale is what that control does, and the tare waits for what the daemon waits for.

commissioning_test.py DAEMON MAKE_SMALL_NETWORK [unittest options]
With SPINDLE_TWIN_PICTURES=FOLDER it leaves pictures there.
"""
import json
import pathlib
import threading
import time

from pymodbus.client import ModbusTcpClient

from live_page_test import PHONE, PICTURES
from page_commands_test import PASSWORD, Commands
from ports import can_connect, wait_until
from running_daemon import float32, int16, main

TRIAL, ENABLED = 16, 1
SLEW_UM = 5.0  # per second of model time, ten times the default: the way of a test is short
STEPS = ("first zero", "plus", "minus", "zero again")


class Control(threading.Thread):
    """Adds what it makes of the register `compensation` to an axis; the gauge shows how far the nose is from the table."""

    def __init__(self, port, takes):
        super().__init__(daemon=True)
        self.port, self.takes = port, takes
        self.axis_um, self.registers = 0.0, []
        self.stop = threading.Event()

    def run(self):
        client = ModbusTcpClient("127.0.0.1", port=self.port)
        client.connect()
        while not self.stop.wait(0.02):
            reply = client.read_input_registers(1500, 30, slave=1)
            if reply.isError():
                continue
            words = reply.registers
            value_um = float32(*words[8:10])
            if words[3] in (1, 2) and words[6] != 0:
                self.axis_um = self.takes(value_um, self.axis_um)
            if not self.registers or self.registers[-1][0] != words[2]:
                self.registers.append((words[2], value_um))
        client.close()

    def largest_step_um(self):
        """Per cycle that went by."""
        pairs = zip(self.registers, self.registers[1:])
        return max((abs(after - before) / ((second - first) % 65536) for (first, before), (second, after) in pairs), default=0.0)


class Commissioning(Commands):
    config_text = Commands.config_text.replace("clock_rate = 3.0", "clock_rate = 3.0\nperiod_s = 0.3") + (
        f"[compensation]\nslew_um_per_s = {SLEW_UM}\nlimit_um = 30.0\n"
        "[health]\nstuck_K = 50.0\n")  # the device's values never move

    def open(self, **options):
        self.tell(open=f"http://127.0.0.1:{self.http_port}/commissioning", options=options)

    def begin(self, **options):
        """Logged in on the page, the twin running."""
        self.write_signals()
        self.wait_for_state(1)
        self.open_logged_in(**options)

    def open_logged_in(self, **options):
        self.open(**options)
        wait_until(lambda: self.is_shown("login"), "the login", 10)
        self.log_in_by_page(PASSWORD)
        wait_until(lambda: self.is_shown("orders"), "the cards", 10)

    def compensation(self):
        words = self.read(1500, 30)
        return float32(*words[8:10]), words[7]

    def control(self, takes):
        control = Control(self.port, takes)
        self.addCleanup(lambda: (control.stop.set(), control.join()))
        control.start()
        return control

    def go(self, step):
        self.click(f"#trial button[data-step='{step}']")
        wait_until(lambda: "There: read the gauge" in self.text("trial-said"), f"the value of step {step}", 30)
        time.sleep(0.2)  # the control reads it

    def try_out(self, control):
        """As a person does: a value, the gauge, the next. Gives what the page says of it."""
        zero_um = None
        for step in range(len(STEPS)):
            self.go(step)
            zero_um = control.axis_um if zero_um is None else zero_um
            self.enter(f"#trial input[data-step='{step}']", f"{control.axis_um - zero_um:.0f}")
        self.click("#trial-end")
        return self.text("verdict"), self.text("verdict-text")


class Input(Commissioning):
    def test_right_sign_and_scale_are_found_right_and_the_value_makes_no_step_on_its_ways(self):
        self.begin()
        control = self.control(lambda value_um, axis_um: value_um)
        verdict, text = self.try_out(control)
        self.assertEqual(verdict, "Right.", text)
        wait_until(lambda: self.compensation()[1] & TRIAL == 0, "the way back", 30)
        self.assertLessEqual(control.largest_step_um(), SLEW_UM * 0.3 * 1.001)
        self.assertEqual(self.compensation()[1] & ENABLED, ENABLED)
        for line in ("anna at 127.0.0.1: trial 10 um", "anna at 127.0.0.1: trial end", "compensation: a trial has begun",
                     "compensation: the trial has ended"):
            self.assert_logged(line)
        self.assertEqual(self.tell(seen=True), {"elsewhere": [], "complaints": []})

    def test_a_wrong_sign_is_caught(self):
        self.begin()
        verdict, text = self.try_out(self.control(lambda value_um, axis_um: -value_um))
        self.assertEqual(verdict, "Wrong sign.", text)
        self.assertIn("compensation.sign", self.text("verdict-change"))

    def test_tenths_of_a_micrometre_taken_for_micrometres_are_caught(self):
        self.begin()
        verdict, text = self.try_out(self.control(lambda value_um, axis_um: 10.0 * value_um))
        self.assertEqual(verdict, "Wrong unit.", text)
        self.assertIn("0.1 µm is taken for 1 µm", text)

    def test_a_control_that_does_not_read_and_one_that_sticks_are_caught(self):
        self.begin()
        control = self.control(lambda value_um, axis_um: 0.0)
        verdict, text = self.try_out(control)
        self.assertEqual(verdict, "Not read.", text)
        def sticky(value_um, axis_um):
            return min(max(axis_um, value_um - 4.0), value_um + 4.0)
        control.takes = sticky
        self.click("#trial-anew")
        verdict, text = self.try_out(control)
        self.assertEqual(verdict, "Sticks, or has play.", text)


class Trial(Commissioning):
    def begin_trial(self, um="10"):
        self.fill(trial_um=um)
        self.click("#trial button[data-step='1']")

    def test_beyond_the_limit_it_is_refused_with_the_reason(self):
        self.begin()
        self.fill(trial_um="40")
        wait_until(lambda: "compensation.limit_um, 30.0" in self.text("trial-notes"), "the warning", 10)
        self.begin_trial("40")
        wait_until(lambda: "refused" in self.text("ordered"), "the refusal", 10)
        self.assertEqual(self.compensation()[1] & TRIAL, 0)

    def test_loading_the_page_again_loses_nothing_and_a_logout_ends_the_trial(self):
        self.begin()
        self.fill(machine="Mill 7 <b>", trial_um="10")
        self.enter("#trial input[data-step='0']", "0.5")
        self.go(1)
        self.tell(reload=True)
        wait_until(lambda: self.is_shown("orders") and "There: read the gauge for +10.0" in self.text("trial-said"),
                   "the trial after the page was loaded again", 20)
        kept = self.tell(evaluate="[document.getElementById('machine').value, document.querySelector('#trial input').value]")
        self.assertEqual(kept, ["Mill 7 <b>", "0.5"])
        self.click("#logout")
        wait_until(lambda: self.compensation()[1] & TRIAL == 0, "the way back after the logout", 30)

    def test_a_restart_in_the_middle_comes_back_to_the_prediction_without_a_step(self):
        self.begin()
        self.go(2)
        before_um, _ = self.compensation()
        self.assertAlmostEqual(before_um, -10.0, delta=0.01)
        self.daemon.terminate()
        self.daemon.wait(20)
        self.start_again()
        wait_until(lambda: self.read(10, 1)[0] in (1, 2), "the prediction")
        control = self.control(lambda value_um, axis_um: value_um)
        wait_until(lambda: len(control.registers) > 1, "some values")
        self.assertLessEqual(control.largest_step_um(), SLEW_UM * 0.3 * 1.001)
        wait_until(lambda: self.compensation()[1] & TRIAL == 0, "the way back", 30)
        self.assertEqual(self.log_in()[0], 200)


class Unattended(Commissioning):
    def test_a_page_that_is_gone_does_not_keep_the_value_and_who_looks_on_sees_what_it_is(self):
        self.begin()
        self.go(1)
        left_s = self.read(1525, 1)[0]
        self.assertLessEqual(left_s, 60)
        self.tell(open=f"http://127.0.0.1:{self.http_port}/", options={})
        wait_until(lambda: "Compensation, trial: a known value that somebody tries" in self.text("messages"), "the word of it", 10)
        wait_until(lambda: self.read(1525, 1)[0] < left_s - 2, "the time to run", 20)
        self.assertNotEqual(self.compensation()[1] & TRIAL, 0)

    def test_it_is_off_without_commands_and_says_so(self):
        text = self.config.read_text()
        self.config.write_text(text[:text.index("[http.commands]")] + text[text.index("[compensation]"):])
        self.daemon.terminate()
        self.daemon.wait(20)
        self.start_again()
        wait_until(lambda: can_connect(self.http_port), "the HTTP port")
        self.open()
        wait_until(lambda: self.is_shown("off"), "the reason", 10)
        self.assertFalse(self.is_shown("orders"))
        self.assertEqual(self.tell(judge=True), [])


class Sensors(Commissioning):
    # At rest, isothermal at what the device's sensors show on the average; a minute of rest is six seconds.
    config_text = (Commissioning.config_text.replace("clock_rate = 3.0\nperiod_s = 0.3", "clock_rate = 10.0")
                   .replace("value = 22.0", "value = 28.25")
                   .replace('coolant = {{ source = "device", register = 6, type = "float32" }}',
                            'coolant = {{ source = "constant", value = 28.25 }}')
                   + "[health.tare]\nrest_s = 60.0\nblock_s = 20.0\nmodel_spread_K = 0.5\n")

    def turn(self, rpm, load):
        self.assertFalse(self.client.write_registers(1000, [rpm, load], slave=1).isError())

    def test_the_tare_says_what_it_waits_for_is_refused_until_then_and_done_when_isothermal(self):
        self.begin()
        wait_until(lambda: "the spindle turns or has load" in self.text("tare-wait"), "the reason", 10)
        self.click("[data-command='sensors'][data-value='tare']")
        wait_until(lambda: "Tare the sensors: refused" in self.text("ordered"), "the refusal", 10)
        self.turn(0, 0)
        wait_until(lambda: "not for long enough yet" in self.text("tare-wait"), "the next reason", 10)
        wait_until(lambda: "It can be taken now" in self.text("tare-wait"), "an isothermal machine", 60)
        self.assertEqual([row[-1] for row in self.table("sensors").values()], ["yes, alike"] * 3)
        self.click("[data-command='sensors'][data-value='tare']")
        wait_until(lambda: "Tare the sensors: done" in self.text("ordered"), "the tare", 10)
        wait_until(lambda: self.read(1198, 1) == [1], "the tare in the registers", 10)
        tares = [int16(word) / 1000 for word in self.read(1182, 3)]
        for taken, wanted in zip(tares, (0.25, 0.0, -0.25)):
            self.assertAlmostEqual(taken, wanted, delta=0.01)
        wait_until(lambda: [self.number(row[2]) for row in self.table("sensors").values()] == tares, "the tare on the page", 10)
        self.assertEqual(self.tell(seen=True), {"elsewhere": [], "complaints": []})


class WarmUpAndReport(Commissioning):
    def report(self):
        """The text of the file that the browser is given."""
        self.tell(evaluate="{ window.saved = null; const make = URL.createObjectURL; URL.createObjectURL = blob => "
                           "{ blob.text().then(text => { window.saved = text; }); return make(blob); }; }")
        self.click("#save")
        return wait_until(lambda: self.tell(evaluate="window.saved"), "the report", 10)

    def test_a_recorded_warm_up_and_a_trial_stand_in_a_report_that_needs_nothing_else(self):
        self.begin()
        self.fill(machine='Mill <img src="x" onerror="alert(1)">', remarks="<script>alert(2)</script>")
        self.click("#warm-begin")
        self.fill(length_um="-3.5", length_sd="2")
        self.click("#length button")
        verdict, _ = self.try_out(self.control(lambda value_um, axis_um: -value_um))
        wait_until(lambda: self.tell(evaluate="document.querySelectorAll('#warm-growth path').length") == 2, "the curves", 20)
        self.click("#warm-end")
        text = self.report()
        if PICTURES:
            (pathlib.Path(PICTURES) / "commissioning_report.html").write_text(text)
        self.assertTrue(text.startswith("<!DOCTYPE html>\n<html lang=\"en\">"))
        for wanted in (verdict, "anna", "SHA-256", "certificate of 20 cases", "Simulated: &lt;b&gt;no machine&lt;/b&gt;", "<svg",
                       "Mill &lt;img src=", "&lt;script&gt;alert(2)", "−3.50", "sleeve_middle"):
            self.assertIn(wanted, text)
        for unwanted in ("<script", "<img", "http://127", "<link"):
            self.assertNotIn(unwanted, text)
        self.assertEqual(self.tell(seen=True), {"elsewhere": [], "complaints": []})


class Look(Commissioning):
    def test_no_finding_of_axe_and_nothing_wider_than_the_phone(self):
        self.write_signals()
        self.wait_for_state(1)
        for window, scheme, options in (("desktop", "light", {}), ("phone", "dark", PHONE)):
            self.open_logged_in(colorScheme=scheme, **options)
            self.click("#warm-begin")
            self.go(1)
            self.enter("#trial input[data-step='1']", "10")
            wait_until(lambda: self.tell(evaluate="document.querySelectorAll('#warm-points path').length") == 3, "the curves", 20)
            if PICTURES:
                time.sleep(6)
                self.tell(picture=f"{PICTURES}/commissioning_{window}_{scheme}.png")
            wide = self.tell(evaluate="document.documentElement.scrollWidth - document.documentElement.clientWidth")
            self.assertEqual((self.tell(judge=True), wide), ([], 0))
            self.click("#trial-end")


if __name__ == "__main__":
    main()
