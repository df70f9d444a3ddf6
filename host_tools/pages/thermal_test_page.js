// The page of `spindle-twin thermal-test-report`: a thermal test after ISO 230-3, to read and to print.
import { drawChart } from "./time_chart.js";
import { addFacts, addRow, byId, duration, fixed, left, pageData } from "./pages/elements.js";

const data = pageData();
const inks = ["twin", "k2", "k3", "plant", "k1", "raw", "reading"];
const minutes = seconds => `${fixed(seconds / 60, 1)} min`;
const clock = (from_s, until_s) => `${minutes(from_s)} to ${minutes(until_s)}`;
const { rotation } = data;

function writeHead() {
  const spindle = data.set_up.find(row => row.name === "spindle");
  if (spindle) byId("title").textContent = `Thermal test after ISO 230-3: ${spindle.text}`;
  byId("state").textContent = `${data.log}, ${duration(data.until_s - data.from_s)}, ${data.rows} rows` +
    (rotation ? `, ${rotation.kind}` : ", the spindle never turns") +
    (data.compensation ? `; compensation: ${data.compensation}.` : "; no compensation was replayed.");
  const facts = [];
  for (const length of rotation?.lengths ?? []) {
    for (const [words, of] of [["measured", length.measured], ["compensated", length.compensated]]) {
      if (of?.whole) facts.push([`range of ${length.name}, ${words}`, `${fixed(of.whole.range, 2)} µm`]);
    }
  }
  addFacts(byId("facts"), facts);
  const unused = data.unused_columns.join(", ");
  byId("unused").textContent = unused ? `Columns of the log that no measured number here is from: ${unused}.` : "";
}

function showSetUp() {
  for (const row of data.set_up) addRow(byId("set-up"), [row.name, left(row.text)]);
  addRow(byId("phases"), ["from", "for", "speed, rpm"], "th");
  for (const phase of data.phases) {
    addRow(byId("phases"), [minutes(phase.from_s), duration(phase.until_s - phase.from_s), fixed(phase.speed_rpm, 0)]);
  }
}

const windows = [["first_15_min", "15 min"], ["first_60_min", "60 min"], ["whole", "whole"]];
const cells = (of, unit) => [...windows.flatMap(([key]) => of[key] ?
  [`${fixed(of[key].range, 2)} ${unit}`, `${fixed(of[key].rate_per_h, 2)} ${unit}/h`] : ["–", "–"]),
of.steepest_15_min_per_h === null ? "–" : `${fixed(of.steepest_15_min_per_h, 2)} ${unit}/h`];
const heads = windows.flatMap(([, words]) => [`range, ${words}`, `rate, ${words}`]);

function showRotation() {
  byId("rotation-text").textContent = !rotation ? "The spindle does not turn in this log." :
    `${clock(rotation.from_s, rotation.until_s)}, ${rotation.kind}. Range: highest minus lowest reading. Rate: last minus ` +
    "first reading by the time between. Steepest: the largest change within 15 min.";
  if (!rotation) return;
  byId("rotation-title").textContent = `Distortion by the rotating spindle, ${rotation.kind}`;
  addRow(byId("rotation"), ["length", ...heads, "steepest"], "th");
  for (const length of rotation.lengths) {
    addRow(byId("rotation"), [`${length.name}, measured`, ...cells(length.measured, length.unit)]);
    if (!length.compensated) continue;
    addRow(byId("rotation"), [`${length.name}, compensated`, ...cells(length.compensated, length.unit)]);
  }
  addRow(byId("temperatures"), ["place", ...heads, "steepest"], "th");
  for (const place of rotation.temperatures) addRow(byId("temperatures"), [place.name, ...cells(place.measured, place.unit)]);
  for (const place of rotation.surroundings) {
    addRow(byId("temperatures"), [place.name, ...cells(place, place.unit)]);
  }
}

function showStandstill(id, of, none) {
  byId(`${id}-text`).textContent = of ? `${clock(of.from_s, of.until_s)}: what moved while the spindle stood, and what its ` +
    "surroundings did." : none;
  if (!of) return;
  addRow(byId(id), ["channel", "range", "change", "rate", "steepest 15 min"], "th");
  for (const one of [...of.lengths, ...of.surroundings]) {
    const known = one.whole;
    const steepest = one.steepest_15_min_per_h;
    addRow(byId(id), [one.name, ...(known ? [`${fixed(known.range, 2)} ${one.unit}`, `${fixed(known.change, 2)} ${one.unit}`,
      `${fixed(known.rate_per_h, 2)} ${one.unit}/h`] : ["–", "–", "–"]),
    steepest === null ? "–" : `${fixed(steepest, 2)} ${one.unit}/h`]);
  }
}

function showTimeConstants() {
  addRow(byId("time-constants"), ["length", "time", "speed, rpm", "τ", "swing", "rms left"], "th");
  for (const one of data.time_constants) {
    const known = one.time_constant_s !== null;
    addRow(byId("time-constants"), [one.name, clock(one.from_s, one.until_s), fixed(one.speed_rpm, 0),
      known ? minutes(one.time_constant_s) : "–", known ? `${fixed(one.swing_um, 2)} µm` : "–",
      known ? `${fixed(one.rms_um, 2)} µm` : "–"]);
  }
}

function showCharts() {
  const { courses } = data;
  const draw = (id, label, series, options = {}) => {
    if (!series.length) byId(id).parentElement.remove();
    else drawChart(byId(`${id}-legend`), byId(id), { label, time_s: courses.time_s, series, joined: true, ...options });
  };
  draw("lengths", "displacement, µm", [
    ...courses.lengths.map((course, i) => ({ name: `${course.name}, measured`, values: course.values,
      ink: ["plant", "k2", "k3"][i % 3] })),
    ...courses.compensated.map((course, i) => ({ name: `${course.name}, compensated`, values: course.values,
      ink: ["twin", "k2", "k3"][i % 3], dashed: i > 0 }))]);
  draw("speed", "speed, rpm", [{ name: "speed", values: courses.speed_rpm, ink: "twin", steps: true }], { from_zero: true });
  draw("courses", "temperature, °C", [
    ...courses.temperatures.map((course, i) => ({ name: course.name, values: course.values, ink: inks[i % inks.length] })),
    ...courses.surroundings.map((course, i) => ({ name: course.name, values: course.values, ink: ["reading", "plant"][i % 2],
      dashed: true }))]);
}

writeHead();
showSetUp();
showRotation();
showTimeConstants();
showStandstill("etve", data.etve, "The log has no standstill of at least ten minutes before the spindle turns: the variation " +
  "of the environment is not told apart from the spindle's.");
showStandstill("cooling", data.cooling, "The log has no standstill of at least ten minutes at its end.");
showCharts();
