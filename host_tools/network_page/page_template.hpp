#pragma once

namespace spindle_twin::host_tools {

/// The page around the data; @DATA@ is replaced by it.
inline constexpr const char* network_page_template = R"HTML(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Thermal network of a spindle</title>
<style>
:root { color-scheme: light dark; --page: #fff; --card: #f6f7f9; --text: #1b1f24; --soft: #59636e; --line: #d5dae0; --edge: #5b6570;
  --out: #0b62c4; --flow: #1b1f24; --bar: #0b62c4; --less: #b54708; --pale: #c9d9ee; }
@media (prefers-color-scheme: dark) {
  :root { --page: #14171b; --card: #1c2026; --text: #e6e9ed; --soft: #9aa4af; --line: #343b44; --edge: #8b96a3;
    --out: #6cb2ff; --flow: #e6e9ed; --bar: #6cb2ff; --less: #ffa25c; --pale: #2c4260; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1240px; padding: 24px; background: var(--page); color: var(--text);
  font: 15px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
h1 { font-size: 24px; margin: 0 0 4px; }
h2 { font-size: 16px; margin: 0 0 2px; }
p { margin: 0 0 10px; color: var(--soft); }
section { background: var(--card); border: 1px solid var(--line); border-radius: 8px; padding: 14px 16px; margin: 16px 0;
  break-inside: avoid; }
section > p { font-size: 13px; }
.pair { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: 16px; align-items: start; }
.pair > section { margin: 0; }
@media (max-width: 900px) { .pair { grid-template-columns: minmax(0, 1fr); } }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; font-size: 13.5px; }
th, td { padding: 3px 8px; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
th { color: var(--soft); font-weight: 600; font-size: 12.5px; }
th:first-child, td:first-child, td.text, th.text { text-align: left; }
tr.sum td { font-weight: 600; border-top: 2px solid var(--edge); }
td.zero { color: var(--soft); }
svg { width: 100%; height: auto; display: block; }
svg text { fill: var(--text); font-size: 12px; }
svg .soft { fill: var(--soft); }
.bar { display: inline-block; height: 10px; background: var(--bar); border-radius: 2px; vertical-align: middle; }
.bar.less { background: var(--less); }
.facts { display: flex; flex-wrap: wrap; gap: 8px 28px; margin: 10px 0 0; }
.facts div { color: var(--soft); font-size: 13px; }
.facts b { display: block; color: var(--text); font-size: 20px; font-weight: 600; }
@media print { body { padding: 0; max-width: none; font-size: 12px; } section { background: none; } .pair { display: block; }
  .pair > section { margin: 16px 0; } * { print-color-adjust: exact; -webkit-print-color-adjust: exact; } }
</style>
</head>
<body>
<h1 id="title"></h1>
<p id="state"></p>
<div class="facts" id="facts"></div>
<section>
  <h2>Where the heat is and where it goes</h2>
  <p>Meridian section, nose on the left; rise over the resting spindle. Dots: nodes of the network, each the temperature of that
  point. Arrows: heat through contacts, gaps and films, width by watts, the smallest left out; blue ones leave the spindle.
  Point at anything to see its numbers.</p>
  <svg id="section"></svg>
</section>
<section>
  <h2>Heat balance of every part</h2>
  <p>Steady state, W. Exact for the network: what a part is given and what it passes on by contact, through gas (gaps, air volumes),
  to coolant and to ambient; “left” is what does not close.</p>
  <div class="scroll"><table id="balance"></table></div>
</section>
<div class="pair">
  <section>
    <h2>Largest heat flows</h2>
    <p>From → to, in the direction of the heat.</p>
    <div class="scroll"><table id="flows"></table></div>
  </section>
  <section>
    <h2 id="sensitivity-title"></h2>
    <p>By the steady adjoint solution: change for a doubling of one contact or film, linear (µm per doubling). What stands on top
    should be known best.</p>
    <div class="scroll"><table id="sensitivities"></table></div>
  </section>
  <section>
    <h2>Time constants</h2>
    <p>The slowest modes at this state: a disturbance of that shape falls to 37 % in this time. Shares: where its heat lies.</p>
    <div class="scroll"><table id="modes"></table></div>
  </section>
  <section>
    <h2>How far from the finite-element model</h2>
    <p id="certificate-text"></p>
    <div class="scroll"><table id="certificate"></table></div>
  </section>
</div>
<p id="hash"></p>
<script>
"use strict";
const data = @DATA@;
const byId = id => document.getElementById(id);
const minus = text => text.replace("-", "\u2212");
const fixed = (value, digits) => minus(value.toFixed(digits));
const make = (tag, attributes, parent, text) => {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
  return node;
};
const tip = (node, text) => make("title", {}, node, text);
// A cell is a text, {text, left}, {text, zero} or {bar: -1..1}.
function row(table, cells, tag = "td", sum = false) {
  const line = table.insertRow();
  if (sum) line.className = "sum";
  for (const content of cells) {
    const cell = document.createElement(tag);
    if (content && typeof content === "object") {
      if (content.left) cell.className = "text";
      if (content.zero) cell.className = "zero";
      if (content.bar !== undefined) {
        const bar = document.createElement("span");
        bar.className = content.bar < 0 ? "bar less" : "bar";
        bar.style.width = `${Math.max(1, 110 * Math.abs(content.bar))}px`;
        cell.className = "text";
        cell.append(bar);
      } else cell.textContent = content.text;
    } else cell.textContent = content;
    line.append(cell);
  }
}
const watt = value => Math.abs(value) < 0.005 ? { text: "\u00b7", zero: true } : fixed(value, 2);
const total = key => data.balance.reduce((sum, body) => sum + body[key], 0);

byId("title").textContent = `Thermal network of spindle “${data.spindle}”`;
byId("state").textContent = `Steady state at ${fixed(data.speed_rpm, 0)} rpm, load ${fixed(data.load, 2)}` +
  data.environments.map(e => `, ${e.name} ${fixed(e.degC, 1)} °C`).join("");
byId("hash").textContent = `Built from a description with SHA-256 ${data.description_sha256}`;
const hottest = data.nodes.reduce((best, node) => node.rise_K > best.rise_K ? node : best, data.nodes[0]);
const facts = [["nodes", data.nodes.length], ["heat in", `${fixed(total("source_W"), 1)} W`],
  ["to coolant", `${fixed(total("coolant_W"), 1)} W`], ["to ambient", `${fixed(total("ambient_W"), 1)} W`],
  [`hottest node, ${hottest.part || hottest.name}`, `+${fixed(hottest.rise_K, 1)} K`],
  ...data.deformations.map(d => [d.name, `${fixed(d.um, 2)} µm`])];
for (const [name, value] of facts) {
  const fact = document.createElement("div");
  const big = document.createElement("b");
  big.textContent = value;
  fact.append(big, name);
  byId("facts").append(fact);
}

// Perceptually even ramp from cool to hot; the same in light and dark.
const ramp = [[59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37], [245, 140, 40], [202, 45, 45]];
const rises = data.nodes.map(n => n.rise_K);
const low = Math.min(0, ...rises), high = Math.max(low + 1e-9, ...rises);
function colour(rise) {
  const at = (ramp.length - 1) * Math.min(1, Math.max(0, (rise - low) / (high - low)));
  const i = Math.min(ramp.length - 2, Math.floor(at));
  return `rgb(${ramp[i].map((c, k) => Math.round(c + (at - i) * (ramp[i + 1][k] - c))).join(",")})`;
}

function drawSection() {
  const svg = byId("section");
  const points = data.outlines.length ? data.outlines.flatMap(o => o.points_m) : data.nodes.map(n => n.at_m);
  const r = points.map(p => p[0]), z = points.map(p => p[1]);
  const z0 = Math.min(...z), z1 = Math.max(...z), r0 = Math.min(0, ...r), r1 = Math.max(...r);
  const width = 1160, side = 34, above = 20, below = 78;
  const scale = Math.min((width - 2 * side) / Math.max(z1 - z0, 1e-9), 560 / Math.max(r1 - r0, 1e-9));
  const height = above + scale * (r1 - r0) + below;
  const left = (width - scale * (z1 - z0)) / 2;
  const x = at => left + scale * (at[1] - z0), y = at => above + scale * (r1 - at[0]);
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  const bodies = Object.fromEntries(data.balance.map(b => [b.name, b]));
  const parts = {};
  for (const ring of data.outlines) (parts[ring.part] ||= []).push(ring.points_m);
  const centres = {};
  for (const body of data.balance) {
    const own = data.nodes.filter(n => (n.part || n.name) === body.name);
    centres[body.name] = [0, 1].map(k => own.reduce((s, n) => s + n.at_m[k], 0) / own.length);
  }
  for (const [part, rings] of Object.entries(parts)) {
    const path = make("path", { d: rings.map(ring => "M" + ring.map(p => `${x(p).toFixed(1)},${y(p).toFixed(1)}`).join("L") + "Z").join(""),
      "fill-rule": "evenodd", fill: bodies[part] ? colour(bodies[part].mean_degC - data.rest_degC) : "none",
      "fill-opacity": 0.78, stroke: "var(--edge)", "stroke-width": 1 }, svg);
    if (bodies[part]) tip(path, `${part}: mean ${fixed(bodies[part].mean_degC, 2)} °C, +${fixed(bodies[part].mean_degC - data.rest_degC, 2)} K` +
      (bodies[part].source_W > 0.005 ? `, heated by ${fixed(bodies[part].source_W, 1)} W` : ""));
  }
  make("line", { x1: left - 20, x2: left + scale * (z1 - z0) + 20, y1: y([0, z0]), y2: y([0, z0]), stroke: "var(--soft)",
    "stroke-dasharray": "14 4 3 4" }, svg);
  for (const node of data.nodes.filter(n => n.part)) {  // an air volume is nowhere in particular
    tip(make("circle", { cx: x(node.at_m), cy: y(node.at_m), r: 2.6, fill: colour(node.rise_K), stroke: "#14171b",
      "stroke-width": 0.7 }, svg), `${node.name}: +${fixed(node.rise_K, 3)} K`);
  }
  // Arrows across the place where a contact or film acts.
  const most = Math.max(...data.flows.map(f => Math.abs(f.heat_W)), 1e-9);
  const drawn = data.flows.filter(f => f.at_m && Math.abs(f.heat_W) > 0.008 * most)
    .sort((a, b) => Math.abs(b.heat_W) - Math.abs(a.heat_W));
  for (const flow of drawn) {
    const at = [x(flow.at_m), y(flow.at_m)];
    const from = centres[flow.from], to = parts[flow.to] ? centres[flow.to] : null;
    let dx = to ? x(to) - x(from) : at[0] - x(from), dy = to ? y(to) - y(from) : at[1] - y(from);
    if (!to && Math.hypot(dx, dy) < 6) { dx = 0; dy = -1; }
    let norm = Math.hypot(dx, dy) || 1;
    dx /= norm; dy /= norm;
    if (flow.heat_W < 0) { dx = -dx; dy = -dy; }
    const share = Math.sqrt(Math.abs(flow.heat_W) / most), wide = 1.2 + 7 * share, long = 13 + 26 * share, head = 5 + 8 * share;
    const tailX = at[0] - dx * long / 2, tailY = at[1] - dy * long / 2, tipX = at[0] + dx * long / 2, tipY = at[1] + dy * long / 2;
    const px = -dy, py = dx, neckX = tipX - dx * head, neckY = tipY - dy * head;
    const corner = (cx, cy, k) => `${(cx + px * k).toFixed(1)},${(cy + py * k).toFixed(1)}`;
    const arrow = make("polygon", { points: [corner(tailX, tailY, wide / 2), corner(neckX, neckY, wide / 2), corner(neckX, neckY, head * 0.62),
      corner(tipX, tipY, 0), corner(neckX, neckY, -head * 0.62), corner(neckX, neckY, -wide / 2), corner(tailX, tailY, -wide / 2)].join(" "),
      fill: flow.outside ? "var(--out)" : "var(--flow)", stroke: "var(--page)", "stroke-width": 1 }, svg);
    const [source, target] = flow.heat_W >= 0 ? [flow.from, flow.to] : [flow.to, flow.from];
    tip(arrow, `${source} → ${target}: ${fixed(Math.abs(flow.heat_W), 2)} W (${flow.name}, ${flow.kind})`);
  }
  for (const point of data.key_points) {
    const mark = make("path", { d: `M${x(point.at_m) - 6},${y(point.at_m)}h12M${x(point.at_m)},${y(point.at_m) - 6}v12`, stroke: "var(--page)",
      "stroke-width": 4 }, svg);
    make("path", { d: mark.getAttribute("d"), stroke: "var(--text)", "stroke-width": 1.8 }, svg);
    tip(mark, `key point ${point.name}: +${fixed(point.rise_K, 3)} K`);
  }
  // Scale of colours and of lengths.
  const bottom = height - 34, gradient = make("linearGradient", { id: "ramp" }, make("defs", {}, svg));
  ramp.forEach((c, i) => make("stop", { offset: i / (ramp.length - 1), "stop-color": `rgb(${c.join(",")})` }, gradient));
  make("rect", { x: side, y: bottom, width: 240, height: 10, fill: "url(#ramp)", rx: 2 }, svg);
  for (let i = 0; i <= 4; ++i) {
    make("text", { x: side + 60 * i, y: bottom + 25, "text-anchor": "middle", class: "soft" }, svg, fixed(low + (high - low) * i / 4, 1));
  }
  make("text", { x: side + 258, y: bottom + 10, class: "soft" }, svg, "rise, K");
  make("path", { d: `M${width - side - 0.05 * scale},${bottom + 5}h${0.05 * scale}`, stroke: "var(--text)", "stroke-width": 2 }, svg);
  make("text", { x: width - side - 0.025 * scale, y: bottom + 22, "text-anchor": "middle", class: "soft" }, svg, "50 mm");
  make("path", { d: `M390,${bottom + 5}h22`, stroke: "var(--flow)", "stroke-width": 5 }, svg);
  make("text", { x: 420, y: bottom + 9, class: "soft" }, svg, "heat between parts");
  make("path", { d: `M550,${bottom + 5}h22`, stroke: "var(--out)", "stroke-width": 5 }, svg);
  make("text", { x: 580, y: bottom + 9, class: "soft" }, svg, "heat to coolant or ambient");
  make("path", { d: `M750,${bottom + 5}h12M756,${bottom - 1}v12`, stroke: "var(--text)", "stroke-width": 1.8 }, svg);
  make("text", { x: 768, y: bottom + 9, class: "soft" }, svg, "key point");
}
drawSection();

const balance = byId("balance");
const leaks = data.balance.some(b => Math.abs(b.conduction_W) > 0.005);
row(balance, ["part", "mean °C", "heated by", "by contact", "through gas", "to coolant", "to ambient",
  ...(leaks ? ["by conduction"] : []), "left"], "th");
const outgoing = b => [b.contact_W, b.gas_W, b.coolant_W, b.ambient_W, ...(leaks ? [b.conduction_W] : [])];
for (const b of data.balance) {
  row(balance, [b.name, fixed(b.mean_degC, 2), watt(b.source_W), ...outgoing(b).map(watt), b.left_W.toExponential(0)]);
}
row(balance, ["sum", "", fixed(total("source_W"), 2), ...["contact_W", "gas_W", "coolant_W", "ambient_W",
  ...(leaks ? ["conduction_W"] : [])].map(k => fixed(total(k), 2).replace(/^\u22120.00$/, "0.00")), total("left_W").toExponential(0)], "td", true);

const flows = [...data.flows].sort((a, b) => Math.abs(b.heat_W) - Math.abs(a.heat_W)).slice(0, 22);
row(byId("flows"), ["from → to", { text: "through", left: true }, "W", { text: "", left: true }], "th");
for (const f of flows) {
  const [source, target] = f.heat_W >= 0 ? [f.from, f.to] : [f.to, f.from];
  const through = f.name.includes("/") ? f.kind : f.name;
  row(byId("flows"), [`${source} → ${target}`, { text: through, left: true }, fixed(Math.abs(f.heat_W), 2),
    { bar: Math.abs(f.heat_W) / Math.abs(flows[0].heat_W) }]);
}

const nose = data.deformations[0];
byId("sensitivity-title").textContent = nose ? `What moves the ${nose.name} (${fixed(nose.um, 2)} µm)` : "Sensitivities";
const ranked = [...data.sensitivities].sort((a, b) => Math.abs(b.um_per_doubling) - Math.abs(a.um_per_doubling)).slice(0, 22);
row(byId("sensitivities"), ["contact or film", { text: "kind", left: true }, "µm", { text: "", left: true }], "th");
for (const s of ranked) {
  row(byId("sensitivities"), [s.name, { text: s.kind, left: true }, fixed(s.um_per_doubling, 3),
    { bar: s.um_per_doubling / Math.abs(ranked[0].um_per_doubling) }]);
}

const time = s => s >= 120 ? `${fixed(s / 60, 1)} min` : `${fixed(s, 1)} s`;
row(byId("modes"), ["time constant", { text: "where its heat lies", left: true }], "th");
for (const mode of data.modes) {
  row(byId("modes"), [time(mode.time_constant_s),
    { text: mode.where.map(w => `${w.name} ${fixed(100 * w.share, 0)} %`).join(", "), left: true }]);
}

const certificate = data.certificate;
byId("certificate-text").textContent = certificate.cases === 0 ? "No certificate: this network was not compared with an FE model." :
  `Certificate: largest difference over ${certificate.cases} random cases that the network was not built from, seed ${certificate.seed}. ` +
  "Bars: worst case, and darker the median.";
if (certificate.cases > 0) {
  const outputs = certificate.outputs.slice(0, 40), meshed = outputs.some(o => o.mesh > 0);
  const largest = {};
  for (const o of outputs) largest[o.unit] = Math.max(largest[o.unit] || 0, o.worst);
  row(byId("certificate"), ["output", "worst", "median", ...(meshed ? ["mesh"] : []), { text: "", left: true }], "th");
  for (const o of outputs) {
    row(byId("certificate"), [o.name, `${fixed(o.worst, 4)} ${o.unit}`, fixed(o.median, 4), ...(meshed ? [fixed(o.mesh, 4)] : []), ""]);
    const svg = make("svg", { viewBox: "0 0 110 12", style: "width:110px" }, byId("certificate").lastElementChild.lastElementChild.lastElementChild);
    make("rect", { y: 1, width: 110 * o.worst / (largest[o.unit] || 1), height: 10, fill: "var(--pale)", rx: 2 }, svg);
    make("rect", { y: 3.5, width: 110 * o.median / (largest[o.unit] || 1), height: 5, fill: "var(--bar)", rx: 2 }, svg);
  }
}
</script>
</body>
</html>
)HTML";

}  // namespace spindle_twin::host_tools
