// What the daemon's pages say of a sensor, in the register map's words.
import assert from "node:assert/strict";
import { cpSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";

const root = fileURLToPath(new URL("../../", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "spindle-twin-words-"));
cpSync(join(root, "firmware", "show", "page", "words.js"), join(folder, "words.js"));
writeFileSync(join(folder, "package.json"), '{"type": "module"}');
const { sensorWords } = await import(pathToFileURL(join(folder, "words.js")));
after(() => rmSync(folder, { recursive: true }));

const words = {
  sensor_fault: [{ name: "swapped", doc: "shows another place, see sensor_partner; until acknowledged" },
    { name: "stuck", doc: "does not move" }],
  sensor_update: [{ name: "by_partner", doc: "bit 2: read by the sensor of the other place, see sensor_partner" }],
};

function registers({ fault = "swapped", partner = 2, update = [] } = {}) {
  return {
    sensor_quality: { names: { front: "withheld", rear: "good", jacket: "withheld" } },
    sensor_state: { names: { front: "failed", rear: "good", jacket: "failed" } },
    sensor_fault: { names: { front: fault, rear: "none", jacket: fault } },
    sensor_partner: { values: { front: partner, rear: null, jacket: 0 } },
    sensor_update: { set: { front: update, rear: ["fused"], jacket: update } },
    sensor_test_ratio: { values: { front: 0, rear: 0, jacket: 0 } },
  };
}

test("of a sensor that is swapped the other one is named", () => {
  assert.equal(sensorWords(words, registers(), "front"),
    "failed: shows another place; until acknowledged; the other one: jacket");
  assert.match(sensorWords(words, registers(), "jacket"), /the other one: front$/);
  assert.equal(sensorWords(words, registers(), "rear"), "good");
});

test("that its place is read by the other one is said", () => {
  assert.match(sensorWords(words, registers({ update: ["fused", "by_partner"] }), "front"),
    /the other one: jacket; read by the sensor of the other place$/);
});

test("of another fault no other sensor is named", () => {
  for (const partner of [null, 2]) {
    assert.equal(sensorWords(words, registers({ fault: "stuck", partner }), "front"), "failed: does not move");
  }
});
