// What the page of commissioning says of a control from the four readings of a gauge: every mistake by its name, whatever the
// gauge's noise, and none where there is none.
import assert from "node:assert/strict";
import { cpSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";

// As the page has it: the files of pages/ beside those of the daemon's pages.
const root = fileURLToPath(new URL("../../", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "spindle-twin-judge-"));
cpSync(join(root, "pages"), join(folder, "pages"), { recursive: true });
cpSync(join(root, "firmware", "show", "page", "judge_input.js"), join(folder, "judge_input.js"));
writeFileSync(join(folder, "package.json"), '{"type": "module"}');
const { judgeInput } = await import(pathToFileURL(join(folder, "judge_input.js")));
after(() => rmSync(folder, { recursive: true }));

const toStep = (value, step) => Math.round(value / step) * step;

// A control that moves the nose by factor times the value, with play, read by a gauge with steps, `phase` of one off.
function tried(factor, { amount = 10, sign = 1, play = 0, step = 1, phase = 0, slip = 0 } = {}) {
  let axis = 0;
  const steps = [0, amount, -amount, 0].map((value, i) => {
    const wanted = factor * value;
    axis = Math.min(Math.max(axis, wanted - play / 2), wanted + play / 2);
    return { value_um: value, gauge_um: toStep(axis + phase * step + (i === 3 ? slip : 0), step) };
  });
  return judgeInput(steps, sign, step);
}

test("a control that does what it should is right, wherever the gauge's steps lie and however small they are", () => {
  for (const step of [0.1, 0.2, 0.5, 1, 2]) {
    for (let phase = 0; phase < 1; phase += 0.05) {
      assert.equal(tried(1, { step, phase }).verdict, "right", `steps of ${step}, ${phase} of one off`);
      assert.equal(tried(-1, { step, phase, sign: -1 }).verdict, "right", "with sign −1");
    }
  }
});

test("a wrong sign is found with either compensation.sign, and never taken for anything else", () => {
  for (let phase = 0; phase < 1; phase += 0.05) {
    for (const factor of [0.1, 0.5, 1, 2, 10, 25.4, 1000]) {
      for (const sign of [1, -1]) {
        assert.equal(tried(-sign * factor, { sign, phase, step: 0.1 }).verdict, "wrong_sign", `${factor}, sign ${sign}`);
      }
    }
  }
  assert.match(tried(-1).change, /compensation\.sign, which is \+1 now/);
  assert.match(tried(-10).text, /0\.1 µm is taken for 1 µm/);
});

test("a wrong unit is named", () => {
  const names = { 1e4: /0\.1 µm, is taken for millimetres/, 1000: /micrometres are taken for millimetres/,
    10: /0\.1 µm is taken for 1 µm/, 25.4: /thousandths of an inch/, 2.54: /ten-thousandths of an inch/, 2: /added twice/,
    0.5: /diameter/, 0.1: /counts 0\.1 µm/, [1 / 25.4]: /thousandths of an inch are taken for thousandths of a millimetre/ };
  for (const [factor, words] of Object.entries(names)) {
    const said = tried(Number(factor), { step: 0.1 });
    assert.equal(said.verdict, "wrong_unit", factor);
    assert.ok(Math.abs(said.unit / factor - 1) < 1e-9, `${factor}: ${said.unit}`);
    assert.match(said.text, words);
  }
  for (const factor of [10, 25.4, 1000]) assert.equal(tried(factor).unit, factor, "with a gauge of 1 µm");
});

test("nothing read is said, with what would look the same on this gauge", () => {
  const coarse = tried(0), fine = tried(0, { step: 0.1, amount: 20 });
  assert.deepEqual([coarse.verdict, fine.verdict], ["not_read", "not_read"]);
  assert.match(coarse.text, /below 7\.5 %/);
  assert.match(fine.text, /below 0\.4 %/);
  assert.equal(tried(0.001, { step: 0.1 }).verdict, "not_read");
  for (let phase = 0; phase < 1; phase += 0.05) assert.equal(tried(0, { phase }).verdict, "not_read");
});

test("a scale that is off is told in per cent, as far as the gauge knows", () => {
  assert.match(tried(1.3, { step: 0.1 }).text, /30 % too far/);
  assert.match(tried(0.8, { step: 0.1 }).text, /20 % too short/);
  assert.equal(tried(1.1, { step: 0.1 }).verdict, "wrong_scale");
  assert.match(tried(1.1).text, /within 15 %/);
});

test("play, friction and a knocked gauge are told from a wrong scale", () => {
  for (const play of [5, 8, 15]) assert.equal(tried(1, { play }).verdict, "sticks", `${play} µm of play`);
  assert.equal(tried(1, { slip: 5 }).verdict, "sticks");
  assert.match(tried(-1, { play: 6 }).text, /the sign seems to be wrong/);
  assert.equal(tried(10, { play: 3 }).verdict, "wrong_unit", "3 µm of 100");
});

test("without four readings nothing is concluded", () => {
  const steps = [0, 10, -10, 0].map(value => ({ value_um: value, gauge_um: value }));
  for (let i = 0; i < 4; ++i) {
    for (const wrong of [null, NaN, "7"]) {
      const some = steps.map((step, k) => k === i ? { ...step, gauge_um: wrong } : step);
      assert.equal(judgeInput(some, 1, 1).verdict, "incomplete");
    }
  }
  assert.equal(judgeInput(steps.map(step => ({ ...step, value_um: 3 })), 1, 1).verdict, "incomplete");
});
