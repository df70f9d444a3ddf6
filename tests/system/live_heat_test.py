"""Heat flows and the bands of the correction factors on the daemon's live page in Chromium, beside the JSON of the same cycle
and what `spindle-twin inspect` says of the same network and state.

live_heat_test.py DAEMON MAKE_SMALL_NETWORK SPINDLE_TWIN [unittest options]
With SPINDLE_TWIN_PICTURES=FOLDER it leaves pictures there, of desktop and phone, light and dark.
"""
import http.client
import json
import math
import re
import subprocess

from live_page_test import PHONE, PICTURES, LivePage
from ports import can_connect, wait_until
from running_daemon import PROGRAMS, main


class Beside(LivePage):
    def ask(self, what):
        client = http.client.HTTPConnection("127.0.0.1", self.http_port, timeout=20)
        self.addCleanup(client.close)
        client.request("GET", f"/api/v1/{what}")
        reply = client.getresponse()
        self.assertEqual(reply.status, 200)
        return json.loads(reply.read())

    def start_outlined(self):
        self.daemon.kill()
        self.daemon.wait()
        subprocess.run([PROGRAMS["make_network"], self.folder / "small.rom", "outlined"], check=True)
        self.start_again()
        wait_until(lambda: can_connect(self.http_port), "the HTTP port")

    def look(self, name, section):
        """Nothing for axe, nothing wider than the phone."""
        for window, options in (("desktop", {}), ("phone", PHONE)):
            for scheme in ("light", "dark"):
                self.open(colorScheme=scheme, **options)
                wait_until(lambda: self.table("heat-flows") and self.table("factors"), "the tables", 20)
                if PICTURES:
                    self.tell(evaluate=f"document.getElementById('{section}').scrollIntoView()")
                    self.tell(picture=f"{PICTURES}/{name}_{window}_{scheme}.png")
                wide = self.tell(evaluate="document.documentElement.scrollWidth - document.documentElement.clientWidth")
                self.assertEqual((self.tell(judge=True), wide), ([], 0))
        self.assertEqual(self.tell(seen=True), {"elsewhere": [], "complaints": []})


class Factors(Beside):
    def range_of(self, text):
        return [float(number) for number in re.findall(r"[\d.]+", text)]

    def drawn(self, name):
        """[from, to] of the prior's band and of the estimate's, as factors."""
        bars = self.tell(evaluate="(() => { const row = [...document.querySelectorAll('#factors tbody tr')].find(each => "
                                  f"each.cells[0].textContent === {json.dumps(name)}); const svg = row.querySelector('svg');"
                                  "const rect = svg.querySelector('.prior'), path = svg.querySelector('.estimate');"
                                  "return [[+rect.getAttribute('x'), +rect.getAttribute('x') + +rect.getAttribute('width')],"
                                  "path.getAttribute('d')]; })()")
        ends = [float(x) for x in re.findall(r"M([\d.]+),[\d.]+v8", bars[1])]
        return [[2 ** (4 * (x / 160 - 0.5)) for x in pair] for pair in (bars[0], ends)]

    def test_each_factor_stands_in_its_own_band_and_in_that_of_its_prior(self):
        self.open()
        self.run_well()
        def both():
            cycle = self.text("moment")
            shown, state = self.table("factors"), self.ask("state")
            return (shown, state) if state["registers"]["sequence"]["value"] - self.number(cycle) <= 4 else None
        shown, state = wait_until(both, "page and JSON at nearly one time", 20)
        known = state["factors"]["heat"] | state["factors"]["conductance"]
        values = state["registers"]["heat_factor"]["values"] | state["registers"]["conductance_factor"]["values"]
        self.assertEqual(sorted(shown), sorted(known))
        for name, (kind, factor, own, prior, distance, _) in shown.items():
            band, value = known[name], values[name]
            self.assertAlmostEqual(self.number(factor), value, delta=0.03)
            for text, mean, sd in ((own, math.log(value), band["ln_sd"]), (prior, band["prior_ln_mean"], band["prior_ln_sd"])):
                for edge, sign in zip(self.range_of(text), (-2, 2), strict=True):
                    self.assertAlmostEqual(edge, math.exp(mean + sign * sd), delta=0.05 * edge + 0.006, msg=f"{name}: {text}")
            expected = (math.log(value) - band["prior_ln_mean"]) / band["prior_ln_sd"]
            self.assertAlmostEqual(self.number(distance), expected, delta=0.15)
            self.assertEqual("unusual" in distance, abs(self.number(distance)) > 2)
            drawn_prior, drawn_own = self.drawn(name)
            for edge, sign in zip(drawn_prior, (-2, 2)):
                wanted = math.exp(band["prior_ln_mean"] + sign * band["prior_ln_sd"])
                self.assertAlmostEqual(edge, min(4, max(0.25, wanted)), delta=0.05 * edge)
            for edge, wanted in zip(drawn_own, self.range_of(own), strict=True):
                self.assertAlmostEqual(edge, min(4, max(0.25, wanted)), delta=0.05 * edge)
        self.assertEqual(self.tell(seen=True), {"elsewhere": [], "complaints": []})


class WithoutEstimator(Beside):
    config_text = LivePage.config_text.replace('law = "estimator"', 'law = "paper"')

    def test_the_published_law_knows_no_bands_and_the_page_says_so(self):
        self.open()
        self.run_well()
        rows = wait_until(lambda: self.table("factors"), "the factors", 20)
        self.assertTrue(all(row[2:5] == ["–", "–", "–"] for row in rows.values()), rows)
        self.assertEqual(self.tell(seen=True), {"elsewhere": [], "complaints": []})


class Heat(Beside):
    # Without correction, the surroundings as the network was made for, and long enough for its steady state.
    config_text = (LivePage.config_text.replace("clock_rate = 3.0", "clock_rate = 200.0").replace('law = "estimator"', 'law = "none"')
                   .replace('coolant = {{ source = "device", register = 6, type = "float32" }}',
                            'coolant = {{ source = "constant", value = 27.0 }}')
                   .replace("value = 22.0", "value = 27.0"))

    def sums(self, scene, heat):
        """What each body stores, and all that goes outside."""
        stored = {body["name"]: made for body, made in zip(scene["bodies"], heat["made_W"], strict=True)}
        outside = 0.0
        for flow, watts in zip(scene["flows"], heat["flow_W"], strict=True):
            stored[flow["from"]] -= watts
            if flow["outside"]:
                outside += watts
            else:
                stored[flow["to"]] += watts
        return stored, outside

    def inspected(self):
        page = self.folder / "network.html"
        result = subprocess.run([PROGRAMS["tool"], "inspect", self.folder / "small.rom", "--html", page], capture_output=True,
                                text=True, timeout=60)
        self.assertEqual(result.returncode, 0, result.stderr)
        data = re.search(r'<script id="data" type="application/json">(.*?)</script>', page.read_text(), re.S)
        return {flow["name"]: flow["heat_W"] for flow in json.loads(data.group(1))["flows"]}

    def test_in_the_steady_state_page_and_json_say_what_inspect_says_and_every_balance_closes(self):
        self.start_outlined()
        self.write_signals()
        wait_until(lambda: self.read(10, 1)[0] in (1, 2), "a prediction")
        scene = self.ask("scene")
        def settled():
            heat = self.ask("state")["heat"]
            stored, outside = self.sums(scene, heat)
            return heat if max(map(abs, stored.values())) < 0.01 and outside > 1.0 else None
        heat = wait_until(settled, "the steady state", 60)
        stored, outside = self.sums(scene, heat)
        self.assertAlmostEqual(sum(heat["made_W"]), outside, delta=0.02)
        told = {flow["name"]: watts for flow, watts in zip(scene["flows"], heat["flow_W"])}
        for name, watts in self.inspected().items():
            self.assertAlmostEqual(told[name], watts, delta=0.02, msg=name)
        self.open()
        rows = wait_until(lambda: self.table("heat-flows"), "the flows on the page", 20)
        self.assertEqual(len(rows), len(told))
        watts = [float(row[1]) for row in rows.values()]
        self.assertEqual(watts, sorted(watts, reverse=True))
        for shown, expected in zip(watts, sorted(map(abs, told.values()), reverse=True)):
            self.assertAlmostEqual(shown, expected, delta=0.03)
        facts = self.facts("heat-facts")
        self.assertAlmostEqual(self.number(facts["made in the spindle"]), sum(heat["made_W"]), delta=0.06)
        self.assertAlmostEqual(self.number(facts["to coolant"]) + self.number(facts["to ambient"]), outside, delta=0.12)
        for made, given, left in self.table("heat-balance").values():
            self.assertAlmostEqual(self.number(made) - self.number(given), self.number(left), delta=0.02)
        def arrows():
            tips = self.tell(evaluate="[...document.querySelectorAll('#section polygon[data-tip]')].map(one => one.dataset.tip)")
            return tips if len(tips) == len(told) else None
        for tip in wait_until(arrows, "the arrows of the section", 20):
            number, name = re.search(r": ([\d.]+) W \((\w+), ", tip).groups()
            self.assertAlmostEqual(float(number), abs(told[name]), delta=0.03 * max(map(abs, told.values())) + 0.01)
        self.look("heat", "parts-title")


if __name__ == "__main__":
    main("tool")
