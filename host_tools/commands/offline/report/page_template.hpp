#pragma once

namespace spindle_twin::host_tools {

/// The page around the charts: layout, table and chart options. Marks between @ are filled in by run_page().
inline constexpr const char* page_template = R"HTML(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Simulated spindle: plant, twin, uncorrected model</title>
<style>@DYGRAPHS_CSS@</style>
<style>
:root { color-scheme: light dark; --page: #fff; --card: #f6f7f9; --text: #1b1f24; --soft: #59636e; --reading: #8b96a3; --line: #d5dae0; --grid: #c3cad2;
  --warn: #fff3cd; --warn-text: #664d03; --k1: #0b62c4; --k2: #b54708; --k3: #157347; --twin: #0b62c4;
  --plant: #1b1f24; --raw: #c02434; }
@media (prefers-color-scheme: dark) {
  :root { --page: #14171b; --card: #1c2026; --text: #e6e9ed; --soft: #9aa4af; --reading: #7c8792; --line: #343b44; --grid: #4a535e;
    --warn: #3a3015; --warn-text: #ffe08a; --k1: #6cb2ff; --k2: #ffa25c; --k3: #63d297; --twin: #6cb2ff;
    --plant: #e6e9ed; --raw: #ff7b86; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1240px; padding: 24px; background: var(--page); color: var(--text);
  font: 15px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
h1 { font-size: 24px; margin: 0 0 4px; }
h2 { font-size: 16px; margin: 0 0 2px; }
p { margin: 0 0 12px; color: var(--soft); }
.label { display: inline-block; padding: 4px 12px; border-radius: 4px; background: var(--warn); color: var(--warn-text);
  font-weight: 600; margin-bottom: 14px; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: 5px 10px; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
th { color: var(--soft); font-weight: 600; font-size: 13px; }
th:first-child, td:first-child { text-align: left; }
td.twin { font-weight: 600; color: var(--twin); }
section { background: var(--card); border: 1px solid var(--line); border-radius: 8px; padding: 14px 16px; margin: 16px 0; }
section > p { font-size: 13px; margin-bottom: 8px; }
.row { display: grid; grid-template-columns: repeat(3, minmax(0, 1fr)); gap: 18px; }
.pair { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: 16px; }
.pair > section { margin: 0; }
@media (max-width: 900px) { .row, .pair { grid-template-columns: minmax(0, 1fr); } }
.legend { min-height: 22px; font-size: 12.5px; color: var(--text); }
.legend b { font-weight: 600; }
.chart { width: 100%; height: 300px; }
.row .chart { height: 250px; }
.dygraph-axis-label, .dygraph-label { color: var(--text) !important; }
.dygraph-axis-label { font-size: 12px; }
.dygraph-label { font-size: 12.5px; }
.dygraph-legend { background: transparent !important; }
footer { color: var(--soft); font-size: 13px; }
</style>
</head>
<body>
<h1>Thermal twin against its plant</h1>
<p id="scenario"></p>
<div class="label">Simulated spindle: the "measured" values come from a finite-element model, no hardware was involved.</div>
<section>
  <h2 id="table-title"></h2>
  <p>Rises above the start; plant = what really happens in the simulated spindle, twin = what the daemon published,
  uncorrected = the same network without correction. Errors are against the plant, the share is of the plant's rise;
  2σ is what the twin itself says of its error.</p>
  <div class="scroll"><table id="table"></table></div>
</section>
<section>
  <h2>Nose elongation (the paper's Fig. 11)</h2>
  <p>Forward growth of the nose. Plant against twin and uncorrected model; the steps of the twin are its corrections, the band
  is its own ±2σ.</p>
  <div class="legend" id="nose-legend"></div><div class="chart" id="nose"></div>
</section>
<section>
  <h2>Temperatures at the key points (the paper's Fig. 10)</h2>
  <p>Readings with sensor noise and offset, and the twin. One panel per sensor, same scale.</p>
  <div class="row" id="key-points"></div>
</section>
<div class="pair">
  <section>
    <h2>Rise at the key points, uncorrected (Fig. 8)</h2>
    <p>The model as described, and what the plant really does (dashed).</p>
    <div class="legend" id="raw-legend"></div><div class="chart" id="raw"></div>
  </section>
  <section>
    <h2>Error of the twin at the key points</h2>
    <p>Twin minus plant, without sensor noise.</p>
    <div class="legend" id="error-legend"></div><div class="chart" id="error"></div>
  </section>
  <section>
    <h2>Heat factor</h2>
    <p>What the correction multiplies the described heat by.</p>
    <div class="legend" id="factor-legend"></div><div class="chart" id="factor"></div>
  </section>
  <section>
    <h2 id="hottest-title"></h2>
    <p>A place that no sensor reaches. The band is the twin's own ±2σ.</p>
    <div class="legend" id="hottest-legend"></div><div class="chart" id="hottest"></div>
  </section>
</div>
<footer><p>Drag to zoom, double-click to reset; all charts move together. Charts: dygraphs (MIT licence).</p></footer>
<script>@DYGRAPHS_JS@</script>
<script>@SYNCHRONIZER_JS@</script>
<script>
"use strict";
const run = @DATA@;
const byId = id => document.getElementById(id);
const ink = name => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
const signed = (value, digits) => (value < 0 ? "\u2212" : "+") + Math.abs(value).toFixed(digits);

byId("scenario").textContent = `Spindle “${run.spindle}”, ${run.speed_rpm.toFixed(0)} rpm, ambient ` +
  `${run.ambient_degC.toFixed(1)} °C, coolant ${run.coolant_degC.toFixed(1)} °C, ${run.end_s.toFixed(0)} s of model time.`;
byId("table-title").textContent = `After ${run.end_s.toFixed(0)} s`;
byId("hottest-title").textContent = `Maximum temperature of the ${run.hottest.name}`;

function addRow(cells, tag) {
  const row = byId("table").insertRow();
  cells.forEach((text, i) => {
    const cell = document.createElement(tag);
    cell.textContent = text;
    if (tag === "td" && i === 5) cell.className = "twin";
    row.append(cell);
  });
}
addRow(["rise of", "uncorrected", "twin", "plant", "uncorrected error", "twin error", "twin error / rise",
  "twin's own 2σ"], "th");
for (const [name, unit, raw, twin, plant, sd] of run.table) {
  addRow([name, `${raw.toFixed(2)} ${unit}`, `${twin.toFixed(2)} ${unit}`, `${plant.toFixed(2)} ${unit}`,
    `${signed(raw - plant, 2)} ${unit}`, `${signed(twin - plant, 2)} ${unit}`,
    `${signed(100 * (twin - plant) / plant, 1)} %`, sd === null ? "–" : `${(2 * sd).toFixed(2)} ${unit}`], "td");
}

const rise = (values, zero) => values.map(v => v === null ? null : v - zero);
const table = columns => run.time_s.map((t, i) => [t, ...columns.map(c => c[i])]);
const dashed = [7, 4];
const charts = [];

// series: [label, column, ink name, options]
function chart(id, unit, series, extra) {
  const colours = () => series.map(s => ink(s[2]));
  const graph = new Dygraph(byId(id), table(series.map(s => s[1])), Object.assign({
    labels: ["model time", ...series.map(s => s[0])],
    colors: colours(), strokeWidth: 2, legend: "always", labelsDiv: byId(id + "-legend"),
    series: Object.fromEntries(series.map(s => [s[0], s[3] || {}])),
    xlabel: "model time, s", ylabel: unit, gridLineColor: ink("grid"), axisLineColor: ink("soft"),
    highlightCircleSize: 3, digitsAfterDecimal: 2, labelsKMB: false,
    axes: { x: { valueFormatter: t => `${t.toFixed(0)} s`, axisLabelFormatter: t => t.toFixed(0), pixelsPerLabel: 60 },
            y: { axisLabelWidth: 44 } },
  }, extra || {}));
  graph.paint = () => graph.updateOptions({ colors: colours(), gridLineColor: ink("grid"), axisLineColor: ink("soft") });
  charts.push(graph);
}

// With a band every value is [low, value, high].
const banded = (values, sd) => values.map((v, i) => {
  const half = sd && sd[i] ? 2 * sd[i] : 0;
  return v === null ? [null, null, null] : [v - half, v, v + half];
});
const three = quantity => [["plant", banded(quantity.plant), "plant", { strokeWidth: 3 }],
  ["twin", banded(quantity.twin, quantity.twin_sd), "twin"],
  ["uncorrected", banded(quantity.uncorrected), "raw", { strokePattern: dashed }]];
const withBand = { customBars: true, fillAlpha: 0.18 };

chart("nose", "elongation, µm", three(run.nose), withBand);

const seen = run.key_points.flatMap(p => [...p.measured, ...p.twin]).filter(v => v !== null);
const low = Math.min(...seen), high = Math.max(...seen), margin = 0.08 * (high - low);
run.key_points.forEach((point, i) => {
  const id = "key-point-" + i;
  const box = document.createElement("div");
  const title = document.createElement("b");
  title.textContent = point.name;
  const legend = Object.assign(document.createElement("div"), { className: "legend", id: id + "-legend" });
  const area = Object.assign(document.createElement("div"), { className: "chart", id: id });
  box.append(title, legend, area);
  byId("key-points").append(box);
  chart(id, "temperature, °C", [["measured", point.measured, "reading", { strokeWidth: 1 }],
    ["twin", point.twin, "k" + (i % 3 + 1)]], { valueRange: [low - margin, high + margin] });
});

chart("raw", "rise, K", run.key_points.flatMap((p, i) => [
  [p.name, rise(p.uncorrected, p.zero), "k" + (i % 3 + 1)],
  [p.name + " plant", rise(p.plant, p.zero), "k" + (i % 3 + 1), { strokePattern: dashed, strokeWidth: 1.5 }]]));
chart("error", "twin − plant, K", run.key_points.map((p, i) =>
  [p.name, p.twin.map((v, r) => v === null ? null : v - p.plant[r]), "k" + (i % 3 + 1)]));
chart("factor", "factor on the described heat", run.factor_names.map((name, i) =>
  [name, run.heat_factors[i], ["twin", "k2", "k3", "raw"][i % 4], { stepPlot: true }]), { includeZero: true });
chart("hottest", "temperature, °C", three(run.hottest), withBand);

Dygraph.synchronize(charts, { range: false });
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => charts.forEach(c => c.paint()));
</script>
</body>
</html>
)HTML";

}  // namespace spindle_twin::host_tools
