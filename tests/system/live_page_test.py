"""The daemon's live page in Chromium, beside its Modbus server: what a person reads there is what a PLC reads.

live_page_test.py DAEMON MAKE_SMALL_NETWORK [unittest options]
With SPINDLE_TWIN_PICTURES=FOLDER it leaves pictures there, of desktop and phone, light and dark.
"""
import atexit
import functools
import json
import os
import pathlib
import re
import struct
import subprocess
import time

from pymodbus.client import ModbusTcpClient

from ports import can_connect, free_port, wait_until
from running_daemon import CONFIG, PROGRAMS, RunningDaemon, float32, main

DRIVE = pathlib.Path(__file__).resolve().parents[1] / "pages" / "drive.js"
PICTURES = os.environ.get("SPINDLE_TWIN_PICTURES")
PHONE = {"viewport": {"width": 390, "height": 844}, "hasTouch": True, "isMobile": True, "deviceScaleFactor": 2}
NOT_A_NUMBER = struct.unpack(">HH", struct.pack(">f", float("nan")))


@functools.cache
def shared_browser():
    """One for all tests of a program, from the first that needs it: each opens a page that knows nothing of others."""
    browser = subprocess.Popen(["node", DRIVE], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def end():
        """Lets it end by itself: killed, it would leave its profile in the folder for temporary files."""
        browser.stdin.close()
        try:
            browser.wait(20)
        except subprocess.TimeoutExpired:
            browser.kill()
            browser.wait()
    atexit.register(end)
    return browser


class LivePage(RunningDaemon):
    # Slow enough that the device's values, which never move, are not called stuck within a test.
    config_text = CONFIG.replace("clock_rate = 10.0", "clock_rate = 3.0") + (
        '[http]\nport = {http}\nnotice = "Simulated: <b>no machine</b>"\n')

    def start_devices(self):
        self.http_port = free_port()
        return super().start_devices() | {"http": self.http_port}

    def setUp(self):
        super().setUp()
        wait_until(lambda: can_connect(self.http_port), "the HTTP port")
        self.addCleanup(lambda: shared_browser.cache_info().currsize and self.tell(close=True))

    def tell(self, **order):
        browser = shared_browser()
        browser.stdin.write(json.dumps(order) + "\n")
        browser.stdin.flush()
        answer = json.loads(browser.stdout.readline())
        self.assertNotIn("error", answer, order)
        return answer["value"]

    def open(self, **options):
        self.tell(open=f"http://127.0.0.1:{self.http_port}/", options=options)

    def text(self, element):
        return self.tell(evaluate=f"document.getElementById({json.dumps(element)}).textContent")

    def table(self, element):
        """Rows of texts by the name in the first cell."""
        rows = self.tell(evaluate=f"[...document.querySelectorAll('#{element} tbody tr')]"
                                  ".map(row => [...row.cells].map(cell => cell.textContent))")
        return {row[0]: row[1:] for row in rows}

    def facts(self, element):
        pairs = self.tell(evaluate=f"[...document.querySelectorAll('#{element} > div')]"
                                   ".map(fact => [fact.children[1].textContent, fact.children[0].textContent])")
        return dict(pairs[::-1])

    def run_well(self):
        self.write_signals()
        self.wait_for_state(1)
        try:
            wait_until(lambda: "running" in self.text("state"), "the state on the page", 10)
        except AssertionError as error:
            raise AssertionError(f"{error}: {self.tell(seen=True)}") from error

    def wait_for_next_state(self):
        """The page shows one cycle, and then a later one."""
        def shown():
            text = self.text("moment")
            return self.number(text) if re.search(r"\d", text) else None
        cycle = wait_until(shown, "a state", 20)
        wait_until(lambda: (shown() or 0) > cycle, "the next state", 20)

    def write_sensor(self, first, words):
        client = ModbusTcpClient("127.0.0.1", port=self.device_port)
        self.assertTrue(client.connect())
        self.assertFalse(client.write_registers(first, list(words), slave=1).isError())
        client.close()

    def number(self, text):
        return float(re.search(r"[-+]?[\d.]+", text.replace("\u2212", "-")).group())


class Values(LivePage):
    def test_what_is_read_on_the_page_is_what_is_read_by_modbus(self):
        self.open()
        self.run_well()
        def both():
            """Of nearly one cycle: registers are read before and after the page, and the nose hardly moves between."""
            before = self.read(0, 124)
            cycle = self.number(self.text("moment"))
            shown = self.facts("growth"), self.facts("machine"), self.table("temperatures"), self.table("factors")
            same = cycle == self.number(self.text("moment"))
            words = self.read(0, 124)
            between = before[8] << 16 | before[9] <= cycle + 3 and words[8] << 16 | words[9] <= cycle + 15
            still = abs(float32(*before[20:22]) - float32(*words[20:22])) <= 0.1
            return (shown, words) if same and between and still else None
        (growth, machine, temperatures, factors), words = wait_until(both, "page and registers at nearly one time", 30)
        self.assertAlmostEqual(self.number(growth["nose growth minus tare"]), float32(*words[20:22]), delta=0.2)
        self.assertEqual(self.number(machine["speed"]), words[34])
        self.assertEqual(self.number(machine["load"]), words[35] / 10)
        self.assertEqual(self.number(machine["ambient"]), words[37] / 100)
        self.assertEqual(self.text("notice"), "Simulated: <b>no machine</b>")
        self.assertEqual([row[0] for row in temperatures.values()], ["28.50", "28.25", "28.00"])
        for slot, (measured, predicted, band, difference, sensor) in enumerate(temperatures.values()):
            self.assertAlmostEqual(self.number(predicted), words[56 + slot] / 100, delta=0.2)
            self.assertAlmostEqual(self.number(difference), float(measured) - float(predicted), delta=0.011)
            self.assertGreater(self.number(band.removeprefix("± ")), 0)
            self.assertEqual(sensor, "good")
        factor_words = self.read(602, 1)
        heat = [row for row in factors.values() if row[0] == "heat"]
        self.assertAlmostEqual(self.number(heat[0][1]), factor_words[0] / 1000, delta=0.05)
        self.assertEqual(self.tell(seen=True), {"elsewhere": [], "complaints": []})

    def curve(self, chart, series):
        return self.number(self.tell(evaluate=f"document.querySelector('#{chart}-legend [data-series=\"{series}\"] b').textContent"))

    def test_the_curves_end_with_the_numbers_that_stand_beside_them(self):
        self.open()
        self.run_well()
        self.tell(choose=["#point", "sleeve_outer"])
        def both():
            growth, temperatures = self.facts("growth"), self.table("temperatures")["sleeve_outer"]
            curves = [self.curve("growth", "growth"), self.curve("growth", "compensation"), self.curve("point", "predicted"),
                      self.curve("point", "measured")]
            shown = [self.number(text) for text in (growth["nose growth minus tare"], growth["compensation output"],
                                                    temperatures[1], temperatures[0])]
            return shown if shown == curves else None
        first = wait_until(both, "curves and numbers of one moment")
        self.assertEqual(first[3], 28.0)
        self.assertEqual(self.tell(evaluate="document.querySelectorAll('.chart canvas').length"), 2)
        self.assertEqual(self.tell(seen=True), {"elsewhere": [], "complaints": []})

    def test_a_pulled_sensor_shows_within_three_seconds_with_its_reason(self):
        self.open()
        self.run_well()
        self.write_sensor(2, NOT_A_NUMBER)
        pulled = time.monotonic()
        wait_until(lambda: "not a number" in self.table("temperatures")["sleeve_middle"][-1], "the reason", 10)
        self.assertLess(time.monotonic() - pulled, 3.0)
        self.assertIn("Sensor sleeve_middle: reading is not a number", self.text("messages"))
        self.assertIn("degraded", self.text("state"))

    def test_the_page_says_that_the_daemon_is_silent_and_goes_on_after_its_restart(self):
        self.open()
        self.run_well()
        self.daemon.kill()
        self.daemon.wait()
        wait_until(lambda: "No answer from the daemon since" in self.text("silence"), "the alert", 10)
        self.assertFalse(self.tell(evaluate="document.getElementById('silence').hidden"))
        self.start_again()
        wait_until(lambda: self.tell(evaluate="document.getElementById('silence').hidden"), "the page to go on", 10)
        self.run_well()


class Several(LivePage):
    def setUp(self):
        super().setUp()
        own = re.sub(r"\[(serve|http)\]\nport = \d+\n(notice = .*\n)?", "", self.config.read_text()).replace("small.rom", "../small.rom")
        spindles = f"[serve]\nport = {self.port}\n[http]\nport = {self.http_port}\n"
        for unit, name in enumerate(("left", "right"), 1):
            (self.folder / name).mkdir()
            (self.folder / name / "twin.toml").write_text(own)
            spindles += f'[[spindle]]\nname = "{name}"\nunit = {unit}\nconfig = "{name}/twin.toml"\n'
        self.config.write_text(spindles)
        self.daemon.terminate()
        self.daemon.wait(20)
        self.start_again()
        wait_until(lambda: can_connect(self.http_port), "the HTTP port")

    def speed_shown(self):
        text = self.facts("machine").get("speed", "0")
        return self.number(text) if text != "–" else None

    def test_the_spindle_that_is_chosen_is_shown_also_by_its_address(self):
        for unit, rpm in ((1, 3000), (2, 9000)):
            self.assertFalse(self.client.write_register(1000, rpm, slave=unit).isError())
        self.open()
        wait_until(lambda: self.speed_shown() == 3000, "the first spindle", 10)
        self.assertFalse(self.tell(evaluate="document.getElementById('choice').hidden"))
        self.tell(choose=["#spindle", "right"])
        wait_until(lambda: self.speed_shown() == 9000, "the other spindle", 10)
        self.assertEqual(self.tell(evaluate="location.hash"), "#right")
        self.assertEqual(self.tell(judge=True), [])
        self.tell(open=f"http://127.0.0.1:{self.http_port}/#right")
        wait_until(lambda: self.speed_shown() == 9000, "the spindle in the address", 10)
        self.assertEqual(self.tell(seen=True), {"elsewhere": [], "complaints": []})


class Section(LivePage):
    def test_parts_with_outlines_have_the_colours_of_the_scale_and_say_their_temperature(self):
        self.daemon.kill()
        self.daemon.wait()
        subprocess.run([PROGRAMS["make_network"], self.folder / "small.rom", "outlined"], check=True)
        self.start_again()
        wait_until(lambda: can_connect(self.http_port), "the HTTP port")
        self.open()
        self.run_well()
        (shown, told) = wait_until(self.parts_and_registers_of_one_cycle, "page and registers of one cycle", 30)
        self.assertEqual(sorted(shown), ["bearing", "rotor", "sleeve"])
        for slot, name in enumerate(("rotor", "bearing", "sleeve")):
            self.assertAlmostEqual(shown[name], told[slot] / 100, delta=0.06, msg=name)
        self.assertFalse(self.tell(evaluate="document.getElementById('section-place').hidden"))
        self.assertEqual((self.tell(judge=True), self.tell(seen=True)), ([], {"elsewhere": [], "complaints": []}))

    def parts_and_registers_of_one_cycle(self):
        """What the page says of its parts, and the words of the same; None where a cycle has come between."""
        tips = ("[document.getElementById('moment').textContent, [...document.querySelectorAll('#section path[data-tip]')]"
                ".map(part => [part.dataset.tip, part.getAttribute('fill')])]")
        moment, parts = self.tell(evaluate=tips)
        before, words, after = self.read(8, 2), self.read(402, 3), self.read(8, 2)
        if before != after or self.number(moment) != after[0] << 16 | after[1]:
            return None
        shown = {}
        for tip, colour in parts:
            name, degC = re.match(r"(\w+): highest ([\d.]+) °C", tip).groups()
            self.assertRegex(colour, r"^rgb\(\d+,\d+,\d+\)$")
            shown[name] = float(degC)
        return shown, words

    def test_parts_without_outlines_stand_in_their_list(self):
        self.open()
        self.run_well()
        self.assertEqual(self.tell(evaluate="[document.getElementById('section-place').hidden,"
                                            " document.getElementById('all-parts').open]"), [True, True])


class Days(LivePage):
    config_text = LivePage.config_text.replace('"history.csv"', '"history.sqlite"')

    def pressed(self):
        return self.tell(evaluate="[...document.querySelectorAll('#days-choices [aria-pressed=true]')].map(one => one.textContent)")

    def press(self, text):
        self.tell(evaluate=f"[...document.querySelectorAll('#days-choices button')].find(one => one.textContent === '{text}').click()")

    def wait_for_span(self, text):
        wait_until(lambda: text in self.text("days-span"), f"the points' {text}", 20)

    def test_hours_and_days_come_from_the_history_and_change_with_the_button(self):
        self.run_well_before_the_page()
        self.open()
        self.wait_for_span("48 s")
        self.assertEqual(self.pressed(), ["8 h"])
        self.press("1 h")
        self.wait_for_span("6 s")
        self.assertEqual(self.pressed(), ["1 h"])
        self.tell(choose=["#point", "sleeve_outer"])
        wait_until(lambda: "sleeve_outer" in self.text("days-point-title"), "the key point's name", 10)
        shown = self.tell(evaluate="[...document.querySelectorAll('#days .chart')].map(one => one.querySelectorAll('canvas').length)")
        self.assertEqual(shown, [1, 1])
        last = "document.querySelector('#days-point-legend [data-series=measured] b').textContent"
        self.assertEqual(self.tell(evaluate=last), "28.00")
        self.press("7 d")
        self.wait_for_span("16.8 min")
        self.assertEqual((self.text("days-said"), self.pressed()), ("", ["7 d"]))
        self.assertEqual((self.tell(judge=True), self.tell(seen=True)), ([], {"elsewhere": [], "complaints": []}))

    def run_well_before_the_page(self):
        self.write_signals()
        self.wait_for_state(1)
        time.sleep(8)  # of rows, more than one span of an hour

    def test_a_history_that_cannot_be_read_is_said_and_the_page_goes_on(self):
        self.run_well_before_the_page()
        self.open()
        self.wait_for_span("48 s")
        (self.folder / "history.sqlite").unlink()
        self.press("24 h")
        wait_until(lambda: "The history cannot be read: " in self.text("days-said"), "the reason", 20)
        self.wait_for_next_state()
        self.assertEqual(self.tell(judge=True), [])

    def test_without_a_history_in_sqlite_there_is_no_such_card(self):
        self.config.write_text(self.config.read_text().replace("history.sqlite", "history.csv"))
        self.daemon.terminate()
        self.daemon.wait(20)
        self.start_again()
        wait_until(lambda: can_connect(self.http_port), "the HTTP port")
        self.open()
        self.run_well()
        self.assertTrue(self.tell(evaluate="document.getElementById('days').hidden"))
        self.assertEqual(self.tell(seen=True), {"elsewhere": [], "complaints": []})


class Look(LivePage):
    def test_no_finding_of_axe_on_desktop_and_phone_in_light_and_dark_and_nothing_wider_than_the_phone(self):
        self.write_signals()
        self.wait_for_state(1)
        for window, options in (("desktop", {}), ("phone", PHONE)):
            for scheme in ("light", "dark"):
                self.open(colorScheme=scheme, **options)
                wait_until(lambda: "28.50" in str(self.table("temperatures")), "the values on the page")
                if PICTURES:
                    time.sleep(6)  # of curves
                    self.tell(picture=f"{PICTURES}/live_page_{window}_{scheme}.png")
                wide = self.tell(evaluate="document.documentElement.scrollWidth - document.documentElement.clientWidth")
                self.assertEqual((self.tell(judge=True), wide), ([], 0))
        self.write_sensor(2, NOT_A_NUMBER)
        wait_until(lambda: "Sensor sleeve_middle" in self.text("messages"), "the missing sensor on the page")
        self.assertEqual(self.tell(judge=True), [])


if __name__ == "__main__":
    main()
