"""Whether the compensation helps, on the daemon's live page in Chromium and as JSON, beside `spindle-twin evaluate` of the
same history: real touch-offs by Modbus, over what the history takes for three weeks.

live_benefit_test.py DAEMON MAKE_SMALL_NETWORK SPINDLE_TWIN [unittest options]
With SPINDLE_TWIN_PICTURES=FOLDER it leaves pictures there, of desktop and phone, light and dark.
"""
import http.client
import json
import sqlite3
import struct
import subprocess
import time

from live_page_test import PHONE, PICTURES, LivePage
from ports import can_connect, wait_until
from running_daemon import PROGRAMS, float32, main

NOSE_UM = 20  # nose_float32
WEEK_S = 7 * 86400
KEYS = ("readings", "growth_rms_um", "growth_worst_um", "left_rms_um", "left_worst_um", "verdict")


class Benefit(LivePage):
    # A warm-up within seconds; that the device's values never move is no matter here.
    config_text = LivePage.config_text.replace("clock_rate = 3.0", "clock_rate = 100.0").replace(
        '"history.csv"', '"history.sqlite"').replace("[checkpoint]\n", "").replace('path = "twin.checkpoint"\n', "").replace(
        "interval_s = 5.0\n", "")

    def setUp(self):
        """The sensors never move, so the growth of a start is soon corrected: each warm-up is a start of its own."""
        super().setUp()
        self.stop()
        for file in self.folder.glob("history*"):
            file.unlink()

    def start_again(self):
        super().start_again()
        wait_until(lambda: can_connect(self.http_port), "the HTTP port")

    def touch_off(self, share):
        """Hands over `share` of the growth that the daemon says, so unsure that it hardly changes what it says next."""
        nose_um = float32(*self.read(NOSE_UM, 2))
        words = struct.unpack(">4H", struct.pack(">2f", share * nose_um, 50.0))
        self.assertFalse(self.client.write_registers(1010, [*words, 0, 1], slave=1).isError())
        return nose_um

    def warm_up(self, share, touch_offs=5):
        self.start_again()
        self.write_signals()
        self.wait_for_state(1)
        before_um = self.touch_off(share)
        for n in range(1, touch_offs):
            least_um = 3.0 if n == 1 else 0.4  # alike, so that they tell
            wait_until(lambda: float32(*self.read(NOSE_UM, 2)) > before_um + least_um, "growth")
            before_um = self.touch_off(share)
        time.sleep(0.5)

    def stop(self):
        self.daemon.terminate()
        self.assertEqual(self.daemon.wait(20), 0)

    def weeks_pass(self, weeks):
        """What is in the history was then."""
        with sqlite3.connect(self.folder / "history.sqlite") as file:
            file.execute("UPDATE cycle SET unix_s = unix_s - ?", (weeks * WEEK_S,))

    def growth(self):
        client = http.client.HTTPConnection("127.0.0.1", self.http_port, timeout=20)
        self.addCleanup(client.close)
        client.request("GET", "/api/v1/growth")
        reply = client.getresponse()
        body = reply.read()
        self.assertEqual(reply.status, 200, body)
        return json.loads(body)

    def evaluated(self):
        result = subprocess.run([PROGRAMS["tool"], "evaluate", self.folder / "history.sqlite", "--json"], capture_output=True,
                                text=True, timeout=60)
        self.assertIn(result.returncode, (0, 3), result.stderr)
        return json.loads(result.stdout)

    def verdict(self):
        return self.tell(evaluate="document.querySelector('#benefit .verdict')?.textContent ?? ''")

    def warns(self):
        return self.tell(evaluate="document.querySelector('#benefit .verdict').classList.contains('worse')")

    def look(self, name):
        """Nothing for axe, nothing wider than the phone."""
        for window, options in (("desktop", {}), ("phone", PHONE)):
            for scheme in ("light", "dark"):
                self.open(colorScheme=scheme, **options)
                wait_until(self.verdict, "the verdict", 20)
                if PICTURES:
                    self.tell(evaluate="document.getElementById('benefit').scrollIntoView()")
                    self.tell(picture=f"{PICTURES}/{name}_{window}_{scheme}.png")
                wide = self.tell(evaluate="document.documentElement.scrollWidth - document.documentElement.clientWidth")
                self.assertEqual((self.tell(judge=True), wide), ([], 0))
        self.assertEqual(self.tell(seen=True), {"elsewhere": [], "complaints": []})

    def test_weeks_on_the_page_are_those_of_the_json_and_of_evaluate_and_a_wrong_sign_is_warned_of(self):
        # So few readings of what is right that the wrong sign after them tells, whatever the growth is by a touch-off.
        self.warm_up(1.0, 4)
        self.stop()
        self.weeks_pass(1)
        self.warm_up(0.8, 4)
        self.open()
        wait_until(lambda: " the compensation has left " in self.verdict(), "the verdict", 20)
        self.assertFalse(self.warns())
        self.stop()
        self.weeks_pass(1)
        self.warm_up(-1.0, 9)
        shown, found = self.growth(), self.evaluated()
        self.assertTrue(shown["is_whole"])
        nose = shown["outputs"][0]
        self.assertEqual((nose["output"], nose["stretches"], nose["touch_offs"]), ("nose", 3, 17))
        self.assertEqual(len(nose["weeks"]), 3)
        for told, expected in zip([nose["whole"], *nose["weeks"]], [found["whole"], *found["weeks"]]):
            for key in KEYS:
                same = self.assertEqual if key in ("readings", "verdict") else self.assertAlmostEqual
                same(told[key], expected[key], **({} if same == self.assertEqual else {"delta": 0.001}))
        self.assertEqual([week["verdict"] for week in nose["weeks"]], ["helps", "helps", "makes it worse"])
        self.open()
        wait_until(lambda: "worse" in self.verdict(), "the warning", 20)
        self.assertTrue(self.warns())
        self.assertIn(f"has left {nose['whole']['left_rms_um']:.1f} µm of {nose['whole']['growth_rms_um']:.1f} µm", self.verdict())
        self.assertIn("likely a wrong sign", self.verdict())
        rows = self.tell(evaluate="[...document.querySelectorAll('#benefit tbody tr')].map(row => "
                                  "[...row.cells].map(cell => cell.textContent))")
        self.assertEqual(len(rows), 4)
        for row, told in zip(rows, [*nose["weeks"][::-1], nose["whole"]]):
            self.assertEqual((row[1], row[7]), (str(told["readings"]), told["verdict"]))
            for text, key in zip(row[2:6], KEYS[1:5]):
                self.assertAlmostEqual(self.number(text), told[key], delta=0.051)
        bars = self.tell(evaluate="[...document.querySelectorAll('#benefit tbody tr')].map(row => "
                                  "[...row.querySelectorAll('rect')].map(bar => bar.getBoundingClientRect().width))")
        for (growth, left), told in zip(bars, [*nose["weeks"][::-1], nose["whole"]]):
            self.assertAlmostEqual(left / growth, told["left_rms_um"] / told["growth_rms_um"], delta=0.02)
        self.look("benefit")

    def test_too_few_touch_offs_are_said(self):
        self.warm_up(1.0, 2)
        self.open()
        wait_until(lambda: self.verdict().startswith("Too few touch-offs to say: of 2, 1 can be compared"), "that there are too few", 20)
        self.assertFalse(self.warns())
        self.assertEqual(self.growth()["outputs"][0]["whole"]["verdict"], "too few readings")

    def test_a_lost_history_is_said_and_the_page_goes_on(self):
        self.start_again()
        self.write_signals()
        (self.folder / "history.sqlite").unlink()
        (self.folder / "history.sqlite").mkdir()  # a file would be begun anew
        self.open()
        wait_until(lambda: "The history cannot be read: " in self.text("benefit-said"), "the reason", 20)
        self.wait_for_next_state()


if __name__ == "__main__":
    main("tool")
