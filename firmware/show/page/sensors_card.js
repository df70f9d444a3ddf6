// The sensors as commissioning looks at them: found, alike, tared, or why not yet. Every reason is the daemon's own word.
import { byId, duration, fixed, signed } from "./pages/elements.js";
import { meaning, sensorWords } from "./words.js";
import { setTable, setText } from "./cells.js";

export const sensorHeads = ["key point", "reading, °C", "difference, K", "tare, K", "found"];
const known = (value, text) => value === null || value === undefined ? "–" : text(value);
const isBelieved = (registers, point) => registers.sensor_quality.names[point] === "good";

function foundWords(words, registers, point) {
  if (!isBelieved(registers, point)) return `no: ${sensorWords(words, registers, point)}`;
  return registers.sensor_tare_wait.name === "nothing" ? "yes, alike" : "yes";
}

// Rows of texts under sensorHeads, of the configured sensors.
export function sensorRows(words, registers) {
  const points = Object.keys(registers.sensor_quality.names)
    .filter(point => registers.sensor_quality.names[point] !== "not_configured");
  const measured = registers.key_point_measured_float32.values;
  return points.map(point => {
    const others = points.filter(other => other !== point && isBelieved(registers, other)).map(other => measured[other]);
    const mean = others.length ? others.reduce((sum, value) => sum + value, 0) / others.length : null;
    const difference = mean === null || measured[point] === null ? null : measured[point] - mean;
    return [point, known(measured[point], value => fixed(value, 3)), known(difference, value => signed(value, 3)),
      known(registers.sensor_tare.values[point], value => signed(value, 3)), foundWords(words, registers, point)];
  });
}

// Why the sensors can or cannot be tared now, and what has been.
export function tareText(words, registers) {
  const wait = registers.sensor_tare_wait.name, point = registers.sensor_tare_point.value;
  if (wait === null) return "";
  const taken = Object.values(registers.sensor_tare.values).some(value => value);
  const before = taken ? "A tare is subtracted. " : "";
  if (wait === "nothing") return `${before}It can be taken now: ${meaning(words, "sensor_tare_wait", wait)}.`;
  const name = point === null ? null : Object.keys(registers.sensor_quality.names)[point];
  const which = name ? ` (${name})` : "";
  return `${before}No tare now: ${meaning(words, "sensor_tare_wait", wait)}${which}.`;
}

function leftText(registers) {
  const left_s = registers.sensor_tare_left.value;
  return left_s === null ? "" : `It is judged again in ${duration(left_s)} of model time.`;
}

export function showSensors(words, registers) {
  setTable(byId("sensors"), sensorHeads, sensorRows(words, registers), true);
  setText(byId("tare-wait"), tareText(words, registers));
  setText(byId("tare-left"), leftText(registers));
}
