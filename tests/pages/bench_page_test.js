// The page of tests/bench/run in a browser: bars and table are the rows that it was given; nothing is loaded, nothing is
// complained of.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { openPage, startBrowser } from "./browser.js";

const tables = join(dirname(fileURLToPath(import.meta.url)), "..", "bench", "table");
const same = { run: "this", group: "Network", other_name: "another", kind: "peer", ours: 1e-5, unit: "s", clock: "wall" };
const rows = [
  { ...same, name: "quicker", other: 1e-2, goal: 0.1, means: "much" },
  { ...same, name: "longer", other: 1e-7, kind: "bound", group: "Daemon" },
  { ...same, name: "as long", other: 1e-5, group: "Daemon" },
  { ...same, name: "part", other: 2e-5, group: "Daemon", detail: true },
  { ...same, name: "missing", ours: null, other: null, not_measured: "it is not installed" }];
const program = "import json, sys, page, rows\n" +
  "print(page.page_of({'date': 'today'}, [rows.Row(**fields) for fields in json.loads(sys.argv[1])]))";
const folder = mkdtempSync(join(tmpdir(), "spindle-twin-bench-page-"));
const file = join(folder, "bench.html");
let browser;

before(async () => {
  writeFileSync(file, execFileSync("/usr/bin/python3", ["-B", "-c", program, JSON.stringify(rows)],
    { env: { ...process.env, PYTHONPATH: tables } }));
  browser = await startBrowser();
});

after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true });
});

// Left end and width of each bar and goal in px, from the line of 1, and px per power of ten.
const drawn = page => page.locator("#bars .line:has(.fill)").evaluateAll(lines => lines.map(line => {
  const box = kind => line.querySelector(kind)?.getBoundingClientRect();
  const one = box(".one").left;
  const decades = [...line.querySelectorAll(".decade, .one")].map(mark => mark.getBoundingClientRect().left);
  return { name: line.querySelector(".what").firstChild.textContent, from: box(".fill").left - one,
    to: box(".fill").right - one, goal: box(".goal") ? box(".goal").left + 1 - one : null, decade: decades[1] - decades[0] };
}));

test("a bar goes from 1 to the ratio on an axis of logarithms, and a goal stands at its own", async () => {
  const { page } = await openPage(browser, file);
  const bars = Object.fromEntries((await drawn(page)).map(bar => [bar.name, bar]));
  assert.deepEqual(Object.keys(bars).sort(), ["as long", "longer", "quicker"]);
  const near = (value, expected) => assert.ok(Math.abs(value - expected) < 2.1, `${value} px is not ${expected} px`);
  near(bars.quicker.from, -3 * bars.quicker.decade);
  near(bars.quicker.to, 0);
  near(bars.quicker.goal, -bars.quicker.decade);
  near(bars.longer.from, 0);
  near(bars.longer.to, 2 * bars.longer.decade);
  near(bars["as long"].to, 0);
  assert.equal(bars.longer.goal, null);
});

test("the table has every row, and one that was not measured says why in both", async () => {
  const { page } = await openPage(browser, file);
  const cells = await page.locator("#all tr").evaluateAll(lines => lines.map(line => [...line.cells].map(c => c.textContent)));
  assert.deepEqual(cells.filter(line => line.length > 1).slice(1).map(line => [line[0], line[1], line[2], line[4]]), [
    ["quickermuch", "10.0 µs", "10.0 ms", "1,000 x as quick"],
    ["missing", "", "", "not measured: it is not installed"],
    ["longer", "10.0 µs", "100 ns", "100 x as long"],
    ["as long", "10.0 µs", "10.0 µs", "1.00 x as long"],
    ["part", "10.0 µs", "20.0 µs", "2.00 x as quick"]]);
  assert.equal(await page.locator("#bars .missing").textContent(), "not measured: it is not installed");
});

test("the page loads nothing, complains of nothing and fits a phone", async () => {
  for (const [width, colorScheme] of [[1280, "light"], [360, "dark"]]) {
    const { page, requests, complaints } = await openPage(browser, file, { viewport: { width, height: 800 }, colorScheme });
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(wide <= width, `${wide} px of ${width}`);
    assert.deepEqual([requests, complaints], [[], []]);
  }
});
