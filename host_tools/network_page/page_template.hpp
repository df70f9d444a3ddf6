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
#section { min-width: 860px; }
svg text { fill: var(--text); font-size: 12px; }
svg .name { fill: #14171b; font-size: 11.5px; text-anchor: middle; pointer-events: none; }
svg .watts { font-size: 11.5px; font-weight: 600; text-anchor: middle; paint-order: stroke; stroke: var(--card); stroke-width: 3.5px;
  pointer-events: none; }
svg .soft { fill: var(--soft); }
.bar { display: inline-block; height: 10px; background: var(--bar); border-radius: 2px; vertical-align: middle; }
.bar.less { background: var(--less); }
.facts { display: flex; flex-wrap: wrap; gap: 8px 28px; margin: 10px 0 0; }
.facts div { color: var(--soft); font-size: 13px; }
.facts b { display: block; color: var(--text); font-size: 20px; font-weight: 600; }
@media (max-width: 600px) { body { padding: 14px; } section { padding: 12px; } th, td { padding: 3px 5px; }
  .wide { display: none; } }
@media print { #section { min-width: 0; } body { padding: 0; max-width: none; font-size: 12px; } section { background: none; } .pair { display: block; }
  .pair > section { margin: 16px 0; } * { print-color-adjust: exact; -webkit-print-color-adjust: exact; } }
</style>
</head>
<body>
<h1 id="title"></h1>
<p id="state"></p>
<div class="facts" id="facts"></div>
<section>
  <h2>Where the heat is and where it goes</h2>
  <p>Meridian section; rise over the resting spindle. Dots: nodes of the network, each the temperature of that
  point. Arrows: heat through contacts, gaps and films, width by watts, the largest with their watts, the smallest left out; blue
  ones leave the spindle. Point at anything to see its numbers.</p>
  <div class="scroll"><svg id="section"></svg></div>
</section>
<section>
  <h2 id="balance-title"></h2>
  <p>Steady state, W. Exact for the network: what each is given and what it passes on by contact, through gas (gaps, air volumes),
  to coolant and to ambient (minus: what it gets); “residue” is what does not close.</p>
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
    <p>By the steady adjoint solution: change for a doubling of one contact or film, linear (µm per doubling); <span class="bar"
    style="width:14px"></span> the nose grows, <span class="bar less" style="width:14px"></span> it shrinks. What stands on top
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
const minus = text => text.replaceAll("-", "\u2212");
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
        bar.style.width = `${content.bar === 0 ? 0 : Math.max(1, 110 * Math.abs(content.bar))}px`;
        cell.className = "text wide";
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
  [`hottest node, ${data.hand_written ? hottest.name : hottest.part || hottest.name}`, `+${fixed(hottest.rise_K, 1)} K`],
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
  const lumps = data.hand_written;  // every node is a body of its own, and all there is to draw
  const width = 1160, side = lumps ? 90 : 34, above = lumps ? 92 : 20, below = 78;
  const scale = Math.min((width - 2 * side) / Math.max(z1 - z0, 1e-9), 560 / Math.max(r1 - r0, 1e-9));
  const height = above + scale * (r1 - r0) + below;
  const left = (width - scale * (z1 - z0)) / 2;
  const x = at => left + scale * (at[1] - z0), y = at => above + scale * (r1 - at[0]);
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  const bodies = Object.fromEntries(data.balance.map(b => [b.name, b]));
  const taken = [];  // what is drawn, as [x0, y0, x1, y1], so that texts keep clear of it
  const free = box => !taken.some(o => box[0] < o[2] && box[2] > o[0] && box[1] < o[3] && box[3] > o[1]);
  const parts = {}, paths = {};
  for (const ring of data.outlines) (parts[ring.part] ||= []).push(ring.points_m);
  const centres = {};
  for (const body of data.balance) {
    const own = data.nodes.filter(n => (lumps ? n.name : n.part || n.name) === body.name);
    centres[body.name] = [0, 1].map(k => own.reduce((s, n) => s + n.at_m[k], 0) / own.length);
  }
  for (const [part, rings] of Object.entries(parts)) {
    const path = make("path", { d: rings.map(ring => "M" + ring.map(p => `${x(p).toFixed(1)},${y(p).toFixed(1)}`).join("L") + "Z").join(""),
      "fill-rule": "evenodd", fill: bodies[part] ? colour(bodies[part].mean_degC - data.rest_degC) : "none",
      "fill-opacity": 0.78, stroke: "var(--edge)", "stroke-width": 1 }, svg);
    paths[part] = path;
    if (bodies[part]) tip(path, `${part}: mean ${fixed(bodies[part].mean_degC, 2)} °C, +${fixed(bodies[part].mean_degC - data.rest_degC, 2)} K` +
      (bodies[part].source_W > 0.005 ? `, heated by ${fixed(bodies[part].source_W, 1)} W` : ""));
  }
  make("line", { x1: left - 20, x2: left + scale * (z1 - z0) + 20, y1: y([0, z0]), y2: y([0, z0]), stroke: "var(--soft)",
    "stroke-dasharray": "14 4 3 4" }, svg);
  const placed = data.nodes.filter(n => n.part || n.at_m[0] !== 0 || n.at_m[1] !== 0);  // an air volume may be nowhere in particular
  for (const node of placed) {
    const at = [x(node.at_m), y(node.at_m)];
    tip(make("circle", { cx: at[0], cy: at[1], r: lumps ? 13 : 2.6, fill: colour(node.rise_K), stroke: "#14171b",
      "stroke-width": 0.7 }, svg), `${node.name}: +${fixed(node.rise_K, 3)} K`);
  }
  if (lumps) {
    for (const node of placed) taken.push([x(node.at_m) - 14, y(node.at_m) - 14, x(node.at_m) + 14, y(node.at_m) + 14]);
    for (const node of placed) {
      const at = [x(node.at_m), y(node.at_m)], wide = 3.4 * node.name.length;
      const [middle, down] = [[0, 27], [0, -18], [wide + 18, 4], [-wide - 18, 4]].find(([cx, cy]) =>
        free([at[0] + cx - wide, at[1] + cy - 10, at[0] + cx + wide, at[1] + cy + 3])) || [0, 27];
      make("text", { x: at[0] + middle, y: at[1] + down, "text-anchor": "middle" }, svg, node.name.replaceAll("_", " "));
      taken.push([at[0] + middle - wide, at[1] + down - 10, at[0] + middle + wide, at[1] + down + 3]);
    }
  }
  const extent = name => {
    const own = (parts[name] || []).flat();
    if (!own.length) return null;
    const [x0, x1, y0, y1] = [Math.min(...own.map(x)), Math.max(...own.map(x)), Math.min(...own.map(y)), Math.max(...own.map(y))];
    return { x: (x0 + x1) / 2, y: (y0 + y1) / 2, halfX: (x1 - x0) / 2, halfY: (y1 - y0) / 2, size: (x1 - x0) * (y1 - y0) };
  };
  // Arrows across the place where a contact or film acts.
  const most = Math.max(...data.flows.map(f => Math.abs(f.heat_W)), 1e-9);
  const drawn = data.flows.filter(f => f.at_m && Math.abs(f.heat_W) > 0.008 * most)
    .sort((a, b) => Math.abs(b.heat_W) - Math.abs(a.heat_W));
  const numbered = [];
  for (const flow of drawn) {
    const at = [x(flow.at_m), y(flow.at_m)];
    const from = centres[flow.from], to = flow.outside || !(lumps || parts[flow.to]) ? null : centres[flow.to];
    if (lumps && to) [at[0], at[1]] = [(x(from) + x(to)) / 2, (y(from) + y(to)) / 2];
    if (lumps && !to) at[1] -= 36;  // clear of its node
    let dx = to ? x(to) - x(from) : at[0] - x(from), dy = to ? y(to) - y(from) : at[1] - y(from);
    if (lumps && !to) { dx = 0; dy = -1; }
    if (!to && Math.hypot(dx, dy) < 6) { dx = 0; dy = -1; }
    // Square to the face: along the axis on which the place lies further out in the smaller of the two parts.
    const own = extent(flow.from), other = to ? extent(flow.to) : null, whole = !other || (own && own.size < other.size);
    const frame = whole ? own : other;
    if (frame) {
      const off = [(at[0] - frame.x) / frame.halfX, (at[1] - frame.y) / frame.halfY], along = Math.abs(off[0]) > Math.abs(off[1]) ? 0 : 1;
      const sign = (off[along] < 0 ? -1 : 1) * (whole ? 1 : -1);
      [dx, dy] = along === 0 ? [sign, 0] : [0, sign];
    }
    const norm = Math.hypot(dx, dy) || 1;
    dx /= norm; dy /= norm;
    if (flow.heat_W < 0) { dx = -dx; dy = -dy; }
    const share = Math.sqrt(Math.abs(flow.heat_W) / most), wide = 1.2 + 7 * share, long = 13 + 26 * share, head = 5 + 8 * share;
    const tailX = at[0] - dx * long / 2, tailY = at[1] - dy * long / 2, tipX = at[0] + dx * long / 2, tipY = at[1] + dy * long / 2;
    const px = -dy, py = dx, neckX = tipX - dx * head, neckY = tipY - dy * head;
    const corner = (cx, cy, k) => `${(cx + px * k).toFixed(1)},${(cy + py * k).toFixed(1)}`;
    const arrow = make("polygon", { points: [corner(tailX, tailY, wide / 2), corner(neckX, neckY, wide / 2), corner(neckX, neckY, head * 0.62),
      corner(tipX, tipY, 0), corner(neckX, neckY, -head * 0.62), corner(neckX, neckY, -wide / 2), corner(tailX, tailY, -wide / 2)].join(" "),
      fill: flow.outside ? "var(--out)" : "var(--flow)", stroke: "var(--page)", "stroke-width": 1 }, svg);
    const half = long / 2;
    taken.push([at[0] - Math.abs(dx) * half - 4, at[1] - Math.abs(dy) * half - 4, at[0] + Math.abs(dx) * half + 4, at[1] + Math.abs(dy) * half + 4]);
    if (numbered.length < 9) numbered.push({ at, half, watts: Math.abs(flow.heat_W), outside: flow.outside });
    const [source, target] = flow.heat_W >= 0 ? [flow.from, flow.to] : [flow.to, flow.from];
    tip(arrow, `${source} → ${target}: ${fixed(Math.abs(flow.heat_W), 2)} W (${flow.name}, ${flow.kind})`);
  }
  for (const point of data.key_points) {
    const mark = make("path", { d: `M${x(point.at_m) - 6},${y(point.at_m)}h12M${x(point.at_m)},${y(point.at_m) - 6}v12`, stroke: "var(--page)",
      "stroke-width": 4 }, svg);
    make("path", { d: mark.getAttribute("d"), stroke: "var(--text)", "stroke-width": 1.8 }, svg);
    tip(mark, `key point ${point.name}: +${fixed(point.rise_K, 3)} K`);
    taken.push([x(point.at_m) - 7, y(point.at_m) - 7, x(point.at_m) + 7, y(point.at_m) + 7]);
  }
  for (const { at, half, watts, outside } of numbered) {
    const text = `${fixed(watts, watts < 9.95 ? 1 : 0)} W`, wide = 3.6 * text.length;
    for (const [cx, cy] of [[0, -half - 6], [0, half + 13], [half + wide, 4], [-half - wide, 4], [wide + 8, -10], [-wide - 8, -10]]) {
      const box = [at[0] + cx - wide, at[1] + cy - 10, at[0] + cx + wide, at[1] + cy + 2];
      if (!free(box)) continue;
      make("text", { x: at[0] + cx, y: at[1] + cy, class: "watts", style: outside ? "fill: var(--out)" : "" }, svg, text);
      taken.push(box);
      break;
    }
  }
  // A part's name where it fits inside the part.
  for (const [part, path] of Object.entries(paths)) {
    const name = make("text", { class: "name" }, svg, part.replaceAll("_", " "));
    const frame = path.getBBox(), wide = name.getComputedTextLength() / 2 + 3, middle = [frame.x + frame.width / 2, frame.y + frame.height / 2];
    let best = null;
    for (let cy = frame.y + 8; cy <= frame.y + frame.height - 7; cy += 2) {
      for (let cx = frame.x + wide; cx <= frame.x + frame.width - wide; cx += 4) {
        const far = Math.hypot(cx - middle[0], 3 * (cy - middle[1]));
        if (best && far >= best.far || !free([cx - wide, cy - 7, cx + wide, cy + 7])) continue;
        const inside = [-1, -0.5, 0, 0.5, 1].every(k => [-6, 6].every(d => path.isPointInFill(new DOMPoint(cx + k * wide, cy + d))));
        if (inside) best = { far, cx, cy };
      }
    }
    if (!best) { name.remove(); continue; }
    name.setAttribute("x", best.cx);
    name.setAttribute("y", best.cy + 4);
    taken.push([best.cx - wide, best.cy - 7, best.cx + wide, best.cy + 7]);
  }
  // Scale of colours and of lengths.
  const bottom = height - 34, gradient = make("linearGradient", { id: "ramp" }, make("defs", {}, svg));
  ramp.forEach((c, i) => make("stop", { offset: i / (ramp.length - 1), "stop-color": `rgb(${c.join(",")})` }, gradient));
  make("rect", { x: side, y: bottom, width: 240, height: 10, fill: "url(#ramp)", rx: 2 }, svg);
  for (let i = 0; i <= 4; ++i) {
    make("text", { x: side + 60 * i, y: bottom + 25, "text-anchor": "middle", class: "soft" }, svg, fixed(low + (high - low) * i / 4, 1));
  }
  make("text", { x: side + 254, y: bottom + 10, class: "soft" }, svg, "K");
  const length = scale > 4000 ? 0.02 : 0.05;  // m
  make("path", { d: `M${width - side - length * scale},${bottom + 5}h${length * scale}`, stroke: "var(--text)", "stroke-width": 2 }, svg);
  make("text", { x: width - side - length * scale / 2, y: bottom + 22, "text-anchor": "middle", class: "soft" }, svg, `${1000 * length} mm`);
  make("path", { d: `M390,${bottom + 5}h22`, stroke: "var(--flow)", "stroke-width": 5 }, svg);
  make("text", { x: 420, y: bottom + 9, class: "soft" }, svg, "heat between parts");
  make("path", { d: `M550,${bottom + 5}h22`, stroke: "var(--out)", "stroke-width": 5 }, svg);
  make("text", { x: 580, y: bottom + 9, class: "soft" }, svg, "heat to coolant or ambient");
  make("path", { d: `M750,${bottom + 5}h12M756,${bottom - 1}v12`, stroke: "var(--text)", "stroke-width": 1.8 }, svg);
  make("text", { x: 768, y: bottom + 9, class: "soft" }, svg, "key point");
}
drawSection();

const body = data.hand_written ? "node" : "part";
byId("balance-title").textContent = `Heat balance of every ${body}`;
const balance = byId("balance");
const leaks = data.balance.some(b => Math.abs(b.conduction_W) > 0.005);
row(balance, [body, "mean °C", "heated by", "by contact", "through gas", "to coolant", "to ambient",
  ...(leaks ? ["by conduction"] : []), "residue"], "th");
const outgoing = b => [b.contact_W, b.gas_W, b.coolant_W, b.ambient_W, ...(leaks ? [b.conduction_W] : [])];
for (const b of data.balance) {
  row(balance, [b.name, fixed(b.mean_degC, 2), watt(b.source_W), ...outgoing(b).map(watt), minus(b.residue_W.toExponential(0))]);
}
row(balance, ["sum", "", fixed(total("source_W"), 2), ...["contact_W", "gas_W", "coolant_W", "ambient_W",
  ...(leaks ? ["conduction_W"] : [])].map(k => fixed(total(k), 2).replace(/^\u22120.00$/, "0.00")), minus(total("residue_W").toExponential(0))], "td", true);

const flows = [...data.flows].sort((a, b) => Math.abs(b.heat_W) - Math.abs(a.heat_W)).slice(0, 22);
row(byId("flows"), ["from → to", { text: "through", left: true }, "W", { bar: 0 }], "th");
for (const f of flows) {
  const [source, target] = f.heat_W >= 0 ? [f.from, f.to] : [f.to, f.from];
  const through = f.name.includes("/") ? f.kind : f.name;
  row(byId("flows"), [`${source} → ${target}`, { text: through, left: true }, fixed(Math.abs(f.heat_W), 2),
    { bar: Math.abs(f.heat_W) / Math.abs(flows[0].heat_W) }]);
}

const nose = data.deformations[0];
byId("sensitivity-title").textContent = nose ? `What moves the ${nose.name} (${fixed(nose.um, 2)} µm)` : "Sensitivities";
const ranked = [...data.sensitivities].sort((a, b) => Math.abs(b.um_per_doubling) - Math.abs(a.um_per_doubling)).slice(0, 22);
row(byId("sensitivities"), ["contact or film", { text: "kind", left: true }, "µm", { bar: 0 }], "th");
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
  row(byId("certificate"), ["output", "worst", "median", ...(meshed ? ["mesh"] : []), { bar: 0 }], "th");
  for (const o of outputs) {
    row(byId("certificate"), [o.name, `${fixed(o.worst, 4)} ${o.unit}`, fixed(o.median, 4), ...(meshed ? [fixed(o.mesh, 4)] : []), { bar: 0 }]);
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
