// The pages of `spindle-twin` in a browser: what a person reads there is what the commands give as JSON, CSV and tables;
// nothing is loaded, nothing is complained of.
import assert from "node:assert/strict";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { findingsOfAxe, openPage, startBrowser } from "./browser.js";
import { assembleLumps, buildNetwork, command, makeRun, makeTest, readTable, simulateHeld } from "./commands.js";

const folder = mkdtempSync(join(tmpdir(), "spindle-twin-pages-"));
const files = { network: join(folder, "network.html"), lumps: join(folder, "lumps.html") };
let browser, rings, steady, lumps, run, calibrated, tested, compared, thermal, proposal;

before(async () => {
  rings = buildNetwork(folder);
  command("inspect", rings, "--html", files.network, "--speed", 6000);
  steady = JSON.parse(command("inspect", rings, "--json", "--speed", 6000)).steady_state;
  const rom = assembleLumps(folder);
  command("inspect", rom, "--html", files.lumps);
  lumps = JSON.parse(command("inspect", rom, "--json")).steady_state;
  const log = makeTest(folder, rom);
  for (const name of ["calibration", "compared", "thermal_test", "test", "sensors"]) files[name] = join(folder, `${name}.html`);
  calibrated = JSON.parse(command("calibrate", rom, log, "--accept", "--json", "--html", files.calibration));
  tested = readTable(log);
  compared = JSON.parse(command("compare", rom, log, "--correction", "none", "--to-correction", "estimator", "--json", "--html",
    files.compared));
  thermal = JSON.parse(command("thermal-test-report", log, "--rom", rom, "--json", "-o", files.thermal_test));
  proposal = JSON.parse(command("identify", rom, "--sensors", "winding_sensor", "--test-hours", 0.5, "--json", "--html",
    files.test));
  command("identify", rings, "--html", files.sensors);
  run = makeRun(folder, rings);
  files.run = run.html;
  browser = await startBrowser();
});

after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true });
});

const number = text => Number(text.replace("\u2212", "-").match(/[-+]?[\d.]+(e[-+]?\d+)?/)[0]);
const close = (value, expected, tolerance, what) =>
  assert.ok(Math.abs(value - expected) <= tolerance, `${what}: ${value} is not ${expected} within ${tolerance}`);

// Texts of a table's cells, row by row, without its head.
const tableOf = (page, id) => page.locator(`#${id} tr:not(:has(th))`)
  .evaluateAll(rows => rows.map(row => [...row.cells].map(c => c.textContent)));

// What a chart's legend says after the mouse went to that share of its width: {time, values by series}.
async function pointAt(page, id, share) {
  const box = await boxOf(page, id);
  await page.mouse.move(box.x + 1 + share * (box.width - 2), box.y + box.height / 2);
  return legendOf(page, id);
}

// Where the curves of a chart are, without its axes.
async function boxOf(page, id) {
  const area = page.locator(`#${id} .u-over`);
  await area.scrollIntoViewIfNeeded();
  return area.boundingBox();
}

function legendOf(page, id) {
  return page.locator(`#${id}-legend`).evaluate(legend => ({
    time: legend.querySelector(":scope > b").textContent,
    values: Object.fromEntries([...legend.querySelectorAll("[data-series]")].map(e =>
      [e.dataset.series, e.querySelector("b").textContent])),
  }));
}

test("key points, growth and heats of the network page are those of the JSON", async () => {
  const { page } = await openPage(browser, files.network);
  const facts = Object.fromEntries(await page.locator("#facts div").evaluateAll(list =>
    list.map(fact => [fact.lastChild.textContent, fact.firstChild.textContent])));
  assert.equal(steady.key_points.length, 4);
  for (const point of steady.key_points) close(number(facts[`key point ${point.name}`]), point.rise_K, 0.0051, point.name);
  for (const output of steady.deformations) close(number(facts[output.name]), output.um, 0.0051, output.name);
  const heat_W = steady.balance.reduce((sum, body) => sum + body.source_W, 0);
  close(number(facts["heat in"]), heat_W, 0.051, "heat in");
  close(number(facts["to ambient"]), heat_W, 0.051, "all of it leaves");
  const rows = await tableOf(page, "balance");
  assert.equal(rows.length, steady.balance.length + 1);
  steady.balance.forEach((body, i) => {
    assert.equal(rows[i][0], body.name);
    close(number(rows[i][1]), body.mean_degC, 0.0051, body.name);
    close(rows[i][3] === "·" ? 0 : number(rows[i][3]), body.contact_W, 0.0051, `${body.name} by contact`);
  });
});

test("every part, key point and arrow of the section says its numbers to mouse and finger", async () => {
  for (const options of [{}, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true }]) {
    const { page } = await openPage(browser, files.network, options);
    const said = async node => {
      if (options.hasTouch) await node.tap({ force: true });
      else await node.hover({ force: true });
      return page.locator("#pointed").textContent();
    };
    for (const [i, point] of steady.key_points.entries()) {
      const words = await said(page.locator(".key-point").nth(i));
      const at = steady.key_points.filter(p => words.startsWith(`key point ${p.name}:`));
      assert.equal(at.length, 1, words);
      // Two key points of a joint stand at one place: the upper one speaks for both.
      if (!["shaft_surface", "sleeve_bore"].includes(point.name)) assert.equal(at[0].name, point.name);
      close(number(words.split(":")[1]), at[0].rise_K, 0.00051, words);
    }
    const arrows = await page.locator("#section polygon").evaluateAll(list => list.map(arrow => arrow.dataset.tip));
    assert.equal(arrows.length, steady.flows.length);
    for (const flow of steady.flows) {
      const words = arrows.find(text => text.includes(`(${flow.name},`));
      assert.ok(words.startsWith(`${flow.from} → ${flow.to}:`), words);
      close(number(words.split(":")[1]), flow.heat_W, 0.0051, words);
    }
    const bodies = await page.locator("#section path[data-tip]").evaluateAll(list => list.map(body => body.dataset.tip));
    for (const body of steady.balance) {
      const words = bodies.find(text => text.startsWith(body.name));
      close(number(words.split("mean")[1]), body.mean_degC, 0.0051, body.name);
    }
    await page.context().close();
  }
});

test("the warm-up's curves are those of simulate", async () => {
  const { page } = await openPage(browser, files.network);
  const end_s = number((await pointAt(page, "rises", 1)).time);
  const rows = simulateHeld(folder, rings, 6000, end_s / 240, end_s);
  assert.ok(number((await pointAt(page, "rises", 0)).time) <= end_s / 240, "the curves begin at rest");
  for (const share of [0.1, 0.5, 0.9]) {
    for (const [id, columns] of [["rises", steady.key_points.map(p => p.name)], ["growth", ["outer_growth"]]]) {
      const { time, values } = await pointAt(page, id, share);
      const row = rows.time_s.indexOf(number(time));
      close(row, share * 240, 12, "the moment that the mouse is at");
      assert.deepEqual(Object.keys(values), columns);
      for (const name of columns) {
        const expected = id === "rises" ? rows[`${name}_degC`][row] - 27 : rows[`${name}_um`][row];
        close(number(values[name]), expected, 0.0051, `${name} at ${time}`);
      }
    }
  }
});

test("each node of a network of lumps is drawn with its rise", async () => {
  const { page } = await openPage(browser, files.lumps);
  const tips = await page.locator("#section circle[data-tip]").evaluateAll(list => list.map(dot => dot.dataset.tip));
  for (const body of lumps.balance) {
    const words = tips.find(text => text.startsWith(`${body.name}:`));
    close(number(words.split(":")[1]), body.mean_degC - lumps.rest_degC, 0.00051, body.name);
  }
  assert.equal(await page.locator("#certificate tr").count(), 0);
});

test("the table of the run is that of the terminal", async () => {
  const { page } = await openPage(browser, files.run);
  const rows = await tableOf(page, "table");
  const lines = run.table.trim().split("\n").slice(2);
  assert.equal(rows.length, lines.length);
  lines.forEach((line, i) => {
    assert.ok(line.startsWith(rows[i][0]), line);
    const numbers = line.slice(rows[i][0].length).match(/[-+]?\d+\.\d+/g).map(Number);
    rows[i].slice(1).forEach((cell, k) => close(number(cell), numbers[k], 0.0101, `${rows[i][0]}, column ${k + 1}`));
  });
});

test("the run's curves are the rows of the daemon's and the plant's files", async () => {
  const { page } = await openPage(browser, files.run);
  const { twin, plant } = run;
  for (const share of [0.02, 0.3, 0.7, 1]) {
    const nose = await pointAt(page, "nose", share);
    const row = twin.time_s.indexOf(number(nose.time));
    const at = plant.time_s.findIndex(time_s => time_s >= twin.time_s[row]);
    const between = (values, part = (twin.time_s[row] - plant.time_s[at - 1]) / (plant.time_s[at] - plant.time_s[at - 1])) =>
      values[at - 1] + part * (values[at] - values[at - 1]);
    close(number(nose.values.twin), twin["deformation.outer_growth_um"][row], 0.0051, `twin at ${nose.time}`);
    close(number(nose.values.plant), between(plant["deformation.outer_growth_um"]), 0.0051, `plant at ${nose.time}`);
    const point = await pointAt(page, "key-point-1", share);
    const same = twin.time_s.indexOf(number(point.time));
    close(number(point.values.twin), twin["predicted.shaft_surface_degC"][same], 0.0051, `key point at ${point.time}`);
    close(number(point.values.measured), twin["measured.shaft_surface_degC"][same], 0.0051, `reading at ${point.time}`);
    const factor = await pointAt(page, "factor", share);
    const last = twin.time_s.indexOf(number(factor.time));
    close(number(Object.values(factor.values)[0]), twin["heat_factor.shaft"][last], 0.0051, `factor at ${factor.time}`);
  }
});

test("charts and section of the run show the same moment, and zoom together", async () => {
  const { page } = await openPage(browser, files.run);
  const { twin } = run;
  const { time } = await pointAt(page, "nose", 0.4);
  const row = twin.time_s.indexOf(number(time));
  assert.equal(await page.locator("#hottest-legend > b").textContent(), time);
  assert.equal(await page.locator("#section-title").textContent(), `The spindle after ${time}`);
  const label = await page.locator("#section text", { hasText: "centre " }).textContent();
  close(number(label), twin["predicted.centre_degC"][row], 0.0051, label);
  const shaft = await page.locator('#section path[data-tip^="shaft"]').getAttribute("data-tip");
  close(number(shaft.split("highest")[1]), twin["part_maximum.shaft_degC"][row], 0.0101, shaft);
  const box = await boxOf(page, "nose");
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 80);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.75 * box.width, box.y + 82, { steps: 4 });
  await page.mouse.up();
  for (const id of ["nose", "hottest"]) {
    close(number((await pointAt(page, id, 0)).time), 300, 10, `where ${id} begins`);
    close(number((await pointAt(page, id, 1)).time), 450, 10, `where ${id} ends`);
  }
  await page.locator("#hottest .u-over").dblclick();
  for (const id of ["nose", "hottest"]) {
    assert.ok(number((await pointAt(page, id, 0)).time) < 10, `a double click shows all of ${id} again`);
    close(number((await pointAt(page, id, 1)).time), 600, 1, `where ${id} ends`);
  }
});

test("the tables of a thermal test, of a proposed one and of two replays are those of the JSON", async () => {
  const report = (await openPage(browser, files.thermal_test)).page;
  const [measured, left] = await tableOf(report, "rotation");
  const nose = thermal.rotation.lengths[0];
  for (const [row, of] of [[measured, nose.measured], [left, nose.compensated]]) {
    close(number(row[1]), of.first_15_min.range, 0.0051, "range");
    assert.equal(row[3], "–");
    close(number(row[6]), of.whole.rate_per_h, 0.0051, "rate");
  }
  const proposed = (await openPage(browser, files.test)).page;
  const rows = await tableOf(proposed, "compared");
  assert.deepEqual(rows.map(row => row[0]), proposal.compared.map(one => one.name));
  proposal.compared.forEach((one, i) => close(number(rows[i][3]), one.whole.with_sensors_um, 0.0051, one.name));
  const both = (await openPage(browser, files.compared)).page;
  const table = await tableOf(both, "table");
  compared.deformations.forEach((output, i) => close(number(table[i][3]), output.difference.rms_um, 0.00051, output.name));
});

test("a finger on a chart scrolls the page, and a tap points at a moment in all charts", async () => {
  const phone = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true };
  const { page } = await openPage(browser, files.run, phone);
  const box = await boxOf(page, "nose");
  await page.touchscreen.tap(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
  const { time, values } = await legendOf(page, "nose");
  close(number(time), 300, 15, "the moment under the finger");
  close(number(values.twin), run.twin["deformation.outer_growth_um"][run.twin.time_s.indexOf(number(time))], 0.0051, time);
  assert.equal((await legendOf(page, "hottest")).time, time);
  const finger = await page.context().newCDPSession(page);
  const top = await page.evaluate("scrollY");
  const at = step => ({ x: box.x + 0.5 * box.width, y: box.y + 0.9 * box.height - 10 * step });
  await finger.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: [at(0)] });
  for (let step = 1; step <= 12; ++step) {
    await finger.send("Input.dispatchTouchEvent", { type: "touchMove", touchPoints: [at(step)] });
  }
  await finger.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  await page.waitForFunction(`scrollY > ${top + 50}`);
  close(number((await pointAt(page, "nose", 0)).time), 0, 10, "a finger does not zoom");
});

test("parameters, chi-square, fit and hold-out of a calibration are those of the JSON", async () => {
  const { page } = await openPage(browser, files.calibration);
  const facts = Object.fromEntries(await page.locator("#facts div").evaluateAll(list =>
    list.map(fact => [fact.lastChild.textContent, fact.firstChild.textContent])));
  close(number(facts["chi-square per reading"]), calibrated.chi_square_per_reading, 0.0051, "chi-square");
  close(number(facts["promised for the nose after 4 h without a sensor, 1σ"]), calibrated.promised_um, 0.0051, "promise");
  assert.equal(facts.verdict, calibrated.fits ? "fits" : "does not fit");
  const parameters = await tableOf(page, "parameters");
  assert.ok(parameters.length > 10, `${parameters.length} parameters`);
  assert.deepEqual(parameters.map(row => row[0]), calibrated.parameters.map(one => one.name));
  calibrated.parameters.forEach((one, i) => ["prior", "prior_deviation", "value", "deviation"].forEach((key, k) =>
    close(number(parameters[i][k + 1]), one[key], 0.00051, `${one.name}, ${key}`)));
  for (const [id, channels] of [["fit", calibrated.channels], ["held-out", calibrated.held_out]]) {
    const rows = await tableOf(page, id);
    assert.deepEqual(rows.map(row => row[0]), ["front_seat, log 1", "winding_sensor, log 1", "nose, log 1"]);
    channels.forEach((channel, i) => {
      const unit = channel.name === "nose" ? "um" : "K";
      const means = id === "fit" ? [] : [channel[`mean_${unit}`], channel[`mean_deviation_${unit}`]];
      const told = [channel.readings, channel[`rms_${unit}`], channel[`expected_rms_${unit}`], ...means,
        channel.autocorrelation, channel.outliers];
      told.forEach((value, k) => close(number(rows[i][k + 1]), value, 0.0051, `${id}, ${channel.name}, column ${k + 1}`));
    });
  }
});

test("a calibration's curves are means of a minute of the log's readings, and end with what is left of them", async () => {
  const { page } = await openPage(browser, files.calibration);
  const columns = ["measured.front_seat_degC", "measured.winding_sensor_degC", "measured.nose_um"];
  for (const [k, column] of columns.entries()) {
    const rms = { left: 0, sd: 0 };
    const { channels } = await page.evaluate("JSON.parse(document.getElementById('data').textContent).tests[0]");
    for (const of of Object.keys(rms)) rms[of] = Math.hypot(...channels[k][of]) / Math.sqrt(channels[k][of].length);
    const { name, ...told } = calibrated.channels[k];
    close(rms.left, told.rms_um ?? told.rms_K, 2e-4, `rms of the curve of what ${name} leaves`);
    close(rms.sd, told.expected_rms_um ?? told.expected_rms_K, 2e-4, `rms of ${name}'s band`);
    for (const share of [0.4, 1]) {
      const { time, values } = await pointAt(page, `test-0-${k}`, share);
      const minute = tested[column].filter((_, row) => tested.time_s[row] > number(time) - 60 &&
        tested.time_s[row] <= number(time));
      assert.ok(minute.length > 1, `${minute.length} readings in a minute`);
      const mean = minute.reduce((sum, value) => sum + value) / minute.length;
      close(number(values.measured), mean, 0.0051, `${name} at ${time}`);
      const { left } = (await pointAt(page, `test-0-${k}-left`, share)).values;
      close(number(left), number(values.measured) - number(values.after), 0.0151, `what is left of ${name} at ${time}`);
    }
  }
  const { values } = await pointAt(page, "test-0-2", 0);
  assert.equal(values.before, values.measured, "a probe's zero is unknown: the model begins where it does");
});

// How often each ink stands on the charts of an area.
const inksOn = (page, id, inks) => page.evaluate(([area, names]) => {
  const canvas = [...document.querySelectorAll(`#${area} canvas`)];
  const style = getComputedStyle(document.documentElement);
  const colour = name => style.getPropertyValue(`--${name}`).match(/[\da-f]{2}/g).map(h => parseInt(h, 16));
  return names.map(name => Math.max(...canvas.map(one => {
    const { data } = one.getContext("2d").getImageData(0, 0, one.width, one.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
      if (data[i + 3] > 250 && colour(name).every((c, k) => Math.abs(c - data[i + k]) <= 2)) ++count;
    }
    return count;
  })));
}, [id, inks]);

test("every curve is on its chart, in light and dark and on paper", async () => {
  const least = 30, tries = 200;
  for (const [colorScheme, media] of [["light", "screen"], ["dark", "screen"], ["dark", "print"]]) {
    const { page } = await openPage(browser, files.run, { colorScheme });
    await page.emulateMedia({ media });
    for (const [id, inks] of [["nose", ["plant", "twin", "raw"]], ["key-point-1", ["k2"]], ["factor", ["twin"]]]) {
      let drawn = await inksOn(page, id, inks);  // charts draw anew some while after the medium has changed
      for (let n = 0; n < tries && drawn.some(pixels => pixels <= least); ++n) {
        await page.waitForTimeout(50);
        drawn = await inksOn(page, id, inks);
      }
      drawn.forEach((pixels, i) => assert.ok(pixels > least, `${inks[i]} of ${id}: ${pixels} pixels (${colorScheme}, ${media})`));
    }
    const ground = await page.evaluate("getComputedStyle(document.body).backgroundColor");
    if (media === "print") assert.equal(ground, "rgb(255, 255, 255)");
    await page.context().close();
  }
});

test("a phone shows the numbers that tables are ranked by without scrolling sideways", async () => {
  const phone = { viewport: { width: 360, height: 800 }, hasTouch: true, isMobile: true };
  const { page } = await openPage(browser, files.network, phone);
  for (const [id, unit] of [["flows", "W"], ["sensitivities", "µm"]]) {
    const ends = await page.locator(`#${id}`).evaluate((table, head) => {
      const column = [...table.rows[0].cells].findIndex(cell => cell.textContent === head);
      return [...table.rows].map(row => row.cells[column].getBoundingClientRect().right);
    }, unit);
    assert.ok(ends.length > 2 && Math.max(...ends) <= 360, `${id} reaches ${Math.max(...ends)} px`);
  }
});

test("no page loads or complains, none is wider than a phone, and axe-core finds nothing in light and dark", async () => {
  for (const file of Object.values(files)) {
    const looks = [[1280, "light", ["light"]], [820, "dark", []], [360, "dark", ["dark", "light"]]];
    for (const [width, colorScheme, judged] of looks) {
      const { page, requests, complaints } = await openPage(browser, file, { viewport: { width, height: 844 }, colorScheme });
      for (const scheme of judged) {
        await page.emulateMedia({ colorScheme: scheme });
        assert.deepEqual(await findingsOfAxe(page), [], `${file}, ${width} px, ${scheme}`);
      }
      await page.setViewportSize({ width: width - 20, height: 844 });
      await page.mouse.wheel(0, 3000);
      await page.emulateMedia({ colorScheme: colorScheme === "dark" ? "light" : "dark" });
      const wide = await page.evaluate(() => document.documentElement.scrollWidth);
      assert.ok(wide <= width - 20, `${file} needs ${wide} px of ${width - 20}`);
      assert.deepEqual([requests, complaints], [[], []], file);
      await page.context().close();
    }
  }
});
