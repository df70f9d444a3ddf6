// Letters on the section: no text covers another, and none leaves the drawing, however many there are.
import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { openPage, startBrowser } from "./browser.js";
import { assembleLumps, buildNetwork, command, makeRun } from "./commands.js";

const folder = mkdtempSync(join(tmpdir(), "spindle-twin-labels-"));
const files = Object.fromEntries(["network", "lumps", "sensors", "crowd"].map(name => [name, join(folder, `${name}.html`)]));
const [crowdSize, seed] = [24, 20261124];
let browser;

// The same page with other data.
function withData(file, target, change) {
  const text = readFileSync(file, "utf8");
  const [whole, head, data] = text.match(/(<script id="data"[^>]*>)(.*?)<\/script>/s);
  const changed = JSON.stringify(change(JSON.parse(data))).replaceAll("<", "\\u003c");
  writeFileSync(target, text.replace(whole, () => `${head}${changed}</script>`));
}

// Numbers in 0..1, always the same ones.
function randomNumbers(start) {
  let state = start;
  return () => {
    state = (1664525 * state + 1013904223) % 2 ** 32;
    return state / 2 ** 32;
  };
}

function crowded(data) {
  const next = randomNumbers(seed);
  const points = data.outlines.flatMap(outline => outline.points_m);
  const within = k => {
    const values = points.map(point => point[k]);
    return Math.min(...values) + (0.4 + 0.2 * next()) * (Math.max(...values) - Math.min(...values));
  };
  const sensors = Array.from({ length: crowdSize }, (_, i) =>
    ({ name: `a_sensor_${i}`, part: "shaft", role: "chosen", without_um: 1, at_m: [within(0), within(1)] }));
  sensors[1].at_m = sensors[0].at_m;
  return { ...data, sensors };
}

before(async () => {
  const rings = buildNetwork(folder);
  command("inspect", rings, "--html", files.network, "--speed", 6000);
  command("inspect", assembleLumps(folder), "--html", files.lumps);
  command("identify", rings, "--html", files.sensors);
  withData(files.sensors, files.crowd, crowded);
  files.run = makeRun(folder, rings).html;
  browser = await startBrowser();
});

after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true });
});

// Every line of text on the section, as the browser has drawn it, in px from the drawing's corner.
const textsOf = page => page.locator("#section").evaluate(svg => {
  const frame = svg.getBoundingClientRect();
  const lines = [...svg.querySelectorAll("text")].flatMap(text => {
    const rows = [...text.querySelectorAll("tspan")];
    return rows.length ? rows : [text];
  });
  return { width: frame.width, height: frame.height, texts: lines.map(line => {
    const { left, top, right, bottom } = line.getBoundingClientRect();
    return { words: line.textContent, box: [left - frame.left, top - frame.top, right - frame.left, bottom - frame.top] };
  }) };
});

const overlap = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];

for (const width of [1280, 820, 390]) {
  test(`no two texts of a section overlap and none leaves it, ${width} px`, async () => {
    for (const file of Object.values(files)) {
      const { page } = await openPage(browser, file, { viewport: { width, height: 900 } });
      const drawing = await textsOf(page);
      assert.ok(drawing.texts.length >= 5, `${file} has ${drawing.texts.length} texts`);
      drawing.texts.forEach(({ words, box }, i) => {
        assert.ok(box[0] >= 0 && box[1] >= 0 && box[2] <= drawing.width && box[3] <= drawing.height, `${file}: ${words} leaves`);
        for (const other of drawing.texts.slice(i + 1)) {
          assert.ok(!overlap(box, other.box), `${file}: "${words}" and "${other.words}"`);
        }
      });
      await page.context().close();
    }
  });
}

test("every sensor of a crowd has its label, far ones a line, and those of one place have one in two lines", async () => {
  const { page } = await openPage(browser, files.crowd, { viewport: { width: 1280, height: 900 } });
  const { texts } = await textsOf(page);
  const boxOf = name => texts.find(text => text.words === name)?.box;
  for (let i = 0; i < crowdSize; ++i) assert.ok(boxOf(`a_sensor_${i}`), `a_sensor_${i}`);
  assert.ok(await page.locator("#section line.leader").count() > 0, "lines to far labels");
  const [upper, lower] = [boxOf("a_sensor_0"), boxOf("a_sensor_1")];
  assert.ok(Math.abs(upper[0] + upper[2] - lower[0] - lower[2]) < 1 && lower[1] - upper[1] < 20, "below each other");
});

test("a label whose number grows longer finds another place", async () => {
  const { page } = await openPage(browser, files.run, { viewport: { width: 390, height: 900 } });
  const box = await page.locator("#nose .u-over").boundingBox();
  for (const share of [0, 0.3, 0.9]) {
    await page.mouse.move(box.x + 1 + share * (box.width - 2), box.y + box.height / 2);
    const { texts } = await textsOf(page);
    texts.forEach(({ words, box: own }, i) => texts.slice(i + 1).forEach(other =>
      assert.ok(!overlap(own, other.box), `"${words}" and "${other.words}"`)));
  }
});
