// The page of `spindle-twin report`: a run of the daemon beside its simulated plant.
import { drawChart, onMoment } from "./time_chart.js";
import { addRow, byId, element, fixed, pageData, signed } from "./pages/elements.js";
import { drawSection } from "./pages/section.js";

const run = pageData();
const less = (values, others) => values.map((v, row) => v === null || others[row] === null ? null : v - others[row]);
const above = (values, zero) => values.map(v => v === null ? null : v - zero);
const inkOf = i => ["k1", "k2", "k3"][i % 3];

function chart(id, label, series, options = {}) {
  drawChart(byId(`${id}-legend`), byId(id), { label, time_s: run.time_s, series, ...options });
}

function writeHead() {
  byId("scenario").textContent = `Spindle “${run.spindle}”, ${fixed(run.speed_rpm, 0)} rpm, ambient ` +
    `${fixed(run.ambient_degC, 1)} °C, coolant ${fixed(run.coolant_degC, 1)} °C, ${fixed(run.end_s, 0)} s of model time.`;
  byId("table-title").textContent = `After ${fixed(run.end_s, 0)} s`;
  byId("hottest-title").textContent = `Maximum temperature of the ${run.hottest.name}`;
  addRow(byId("table"), ["rise of", "uncorrected", "twin", "plant", "uncorrected error", "twin error", "twin error / rise",
    "twin's own 2σ"], "th");
  for (const row of run.table) {
    const { name, unit } = row;
    const error = row.twin - row.plant;
    addRow(byId("table"), [name, ...[row.uncorrected, row.twin, row.plant].map(value => `${fixed(value, 2)} ${unit}`),
      `${signed(row.uncorrected - row.plant, 2)} ${unit}`, { text: `${signed(error, 2)} ${unit}`, kind: "twin" },
      `${signed(100 * error / row.plant, 1)} %`, row.twin_sd === null ? "–" : `${fixed(2 * row.twin_sd, 2)} ${unit}`]);
  }
}

// Plant, twin with its band, uncorrected model.
const three = quantity => [
  { name: "plant", values: quantity.plant, ink: "plant", width: 3 },
  { name: "twin", values: quantity.twin, sd: quantity.twin_sd, ink: "twin" },
  { name: "uncorrected", values: quantity.uncorrected, ink: "raw", dashed: true }];

function showKeyPoints() {
  const seen = run.key_points.flatMap(p => [...p.measured, ...p.twin]).filter(v => v !== null);
  const [low, high] = [Math.min(...seen), Math.max(...seen)];
  const margin = 0.08 * (high - low) || 1;
  run.key_points.forEach((point, i) => {
    const box = element("div", {}, byId("key-points"));
    element("h3", {}, box, point.name);
    element("div", { class: "legend", id: `key-point-${i}-legend` }, box);
    element("div", { class: "chart", id: `key-point-${i}` }, box);
    chart(`key-point-${i}`, "temperature, °C", [
      { name: "measured", values: point.measured, ink: "reading", width: 1 },
      { name: "twin", values: point.twin, ink: inkOf(i) }], { range: [low - margin, high + margin] });
  });
}

function showSection() {
  const { outlines, parts } = run.section;
  if (!outlines.length) {
    byId("section-card").remove();
    return;
  }
  const zero = run.hottest.zero;
  const last = run.time_s.length - 1;
  const bodies = row => parts.map(part => {
    const rise_K = part.rises_K[row] ?? 0;
    return { name: part.name, rise_K, tip: `${part.name}: highest ${fixed(zero + rise_K, 2)} °C, ${signed(rise_K, 2)} K` };
  });
  const points = row => run.key_points.map(point => {
    const value = point.twin[row];
    const words = value === null ? "–" : `${fixed(value, 2)} °C`;
    return { name: point.name, at_m: point.at_m, label: `${point.name} ${words}`, tip: `key point ${point.name}: ${words}` };
  });
  const rises = parts.flatMap(part => part.rises_K).filter(v => v !== null);
  const low_K = rises.reduce((a, b) => Math.min(a, b), 0);
  const high_K = rises.reduce((a, b) => Math.max(a, b), low_K + 1e-9);
  const section = drawSection(byId("section"), byId("pointed"),
    { outlines, nodes: [], flows: [], lumps: false, low_K, high_K, bodies: bodies(last), key_points: points(last) });
  const title = row => { byId("section-title").textContent = `The spindle after ${fixed(run.time_s[row], 0)} s`; };
  title(last);
  onMoment(row => {
    title(row);
    section.show(bodies(row), points(row));
  });
}

writeHead();
chart("nose", "elongation, µm", three(run.nose));
showKeyPoints();
showSection();
chart("raw", "rise, K", run.key_points.flatMap((p, i) => [
  { name: p.name, values: above(p.uncorrected, p.zero), ink: inkOf(i) },
  { name: `${p.name} plant`, values: above(p.plant, p.zero), ink: inkOf(i), dashed: true, width: 1.5 }]));
chart("error", "twin − plant, K", run.key_points.map((p, i) =>
  ({ name: p.name, values: less(p.twin, p.plant), ink: inkOf(i) })));
chart("factor", "factor on the described heat", run.factors.map((factor, i) =>
  ({ name: factor.name, values: factor.values, ink: ["twin", "k2", "k3", "plant"][i % 4], dashed: i >= 4, steps: true })),
{ from_zero: true });
chart("hottest", "temperature, °C", three(run.hottest));
