// The meridian section of a spindle with its temperatures.
//
// A scene: `outlines` ({part, points_m}), `bodies` ({name, centre_m, rise_K, tip}), `nodes` ({name, part, at_m, rise_K} and
// a `tip` where it is no rise; `dot` is their size), `flows` (as in `spindle-twin inspect --json`), `key_points` ({name,
// at_m, tip, label}; `sign` is what they are called), `lumps` (every node is a body of its own, and all there is to draw),
// `low_K` and `high_K` (the scale of colours; `unit` where it is not K, `digits` of its numbers). Places are [r, z] in m.
import { colourScale, ramp } from "./colours.js";
import { fixed, svgElement } from "./elements.js";
import { drawFlows, drawWatts } from "./section_flows.js";
import { drawBeside } from "./section_labels.js";
import { drawPartNames } from "./section_names.js";
import { makeRoom, makeView } from "./section_view.js";

// What is pointed at or tapped says its numbers in `pointed`, as a touch screen shows no titles.
function tipsInto(svg, pointed) {
  const show = event => {
    const words = event.target.closest("[data-tip]")?.dataset.tip;
    if (words !== undefined) pointed.textContent = words;
  };
  svg.onpointerover = show;
  svg.onclick = show;
  return (node, words) => {
    node.dataset.tip = words;
    node.setAttribute("role", "img");
    node.setAttribute("aria-label", words);
  };
}

function drawParts({ svg, view, scene, tip }) {
  const paths = {};
  const rings = {};
  for (const ring of scene.outlines) (rings[ring.part] ??= []).push(ring.points_m);
  for (const [part, own] of Object.entries(rings)) {
    const line = points => `M${points.map(p => view.at(p).map(c => c.toFixed(1)).join(",")).join("L")}Z`;
    paths[part] = svgElement("path", { d: own.map(line).join(""), "fill-rule": "evenodd", fill: "none", stroke: "var(--edge)",
      "stroke-width": 1 }, svg);
    tip(paths[part], part);
  }
  const [from, to] = view.axis;
  svgElement("line", { x1: from[0], y1: from[1], x2: to[0], y2: to[1], stroke: "var(--soft)",
    "stroke-dasharray": "14 4 3 4" }, svg);
  return paths;
}

// Lumps have no outlines; lines show which of them exchange heat.
function drawLinks({ svg, view, scene }) {
  const place = name => view.at(scene.nodes.find(node => node.name === name).at_m);
  for (const flow of scene.flows.filter(f => !f.outside)) {
    const [from, to] = [place(flow.from), place(flow.to)];
    svgElement("line", { x1: from[0], y1: from[1], x2: to[0], y2: to[1], stroke: "var(--line)", "stroke-width": 2 }, svg);
  }
}

// Gives the nodes that stand somewhere.
function drawNodes(drawing) {
  const { svg, view, scene, room, colour, tip } = drawing;
  // An air volume may be nowhere in particular.
  const placed = scene.nodes.filter(n => n.part || n.at_m[0] !== 0 || n.at_m[1] !== 0);
  for (const node of placed) {
    const [x, y] = view.at(node.at_m);
    const dot = svgElement("circle", { cx: x, cy: y, r: scene.lumps ? 13 : scene.dot ?? 2.6, fill: colour.css(node.rise_K),
      stroke: "#14171b", "stroke-width": 0.7 }, svg);
    tip(dot, node.tip ?? `${node.name}: +${fixed(node.rise_K, 3)} K`);
    if (scene.lumps) room.take([x - 14, y - 14, x + 14, y + 14]);
  }
  return placed;
}

const aroundOf = ([x, y], half) => [x - half, y - half, x + half, y + half];

// [place, its points]: points whose marks lie on each other have one label, a line for each.
function byPlace(points, view) {
  const places = [];
  for (const point of points) {
    const at = view.at(point.at_m);
    const same = places.find(([other]) => Math.hypot(at[0] - other[0], at[1] - other[1]) < 6);
    if (same) same[1].push(point);
    else places.push([at, [point]]);
  }
  return places;
}

function drawKeyPoints(drawing) {
  const { svg, view, scene, room, tip } = drawing;
  const marks = {};
  for (const point of scene.key_points) {
    const [x, y] = view.at(point.at_m);
    const cross = { d: `M${x - 6},${y}h12M${x},${y - 6}v12` };
    const mark = svgElement("g", { class: "key-point" }, svg);
    svgElement("circle", { cx: x, cy: y, r: 9, fill: "transparent" }, mark);  // easier to hit
    svgElement("path", { ...cross, stroke: "var(--page)", "stroke-width": 4 }, mark);
    svgElement("path", { ...cross, stroke: "var(--text)", "stroke-width": 1.8 }, mark);
    tip(mark, point.tip);
    room.take([x - 7, y - 7, x + 7, y + 7]);
    marks[point.name] = { mark };
  }
  for (const [at, points] of byPlace(scene.key_points.filter(point => point.label), view)) {
    const rows = drawBeside(drawing, aroundOf(at, 7), points.map(point => point.label));
    points.forEach((point, k) => { marks[point.name].label = rows?.[k]; });
  }
  return marks;
}

function drawRamp({ svg, view, scene, colour }) {
  const wide = view.upright ? Math.min(240, view.width - 2 * view.side - 24) : 240;
  const gradient = svgElement("linearGradient", { id: "ramp" }, svgElement("defs", {}, svg));
  ramp.forEach((c, i) => svgElement("stop", { offset: i / (ramp.length - 1), "stop-color": `rgb(${c.join(",")})` }, gradient));
  svgElement("rect", { x: view.side, y: view.bottom, width: wide, height: 10, fill: "url(#ramp)", rx: 2 }, svg);
  for (let i = 0; i <= 4; ++i) {
    const value = fixed(colour.low + (colour.high - colour.low) * i / 4, scene.digits ?? 1);
    svgElement("text", { x: view.side + wide * i / 4, y: view.bottom + 25, class: "soft middle" }, svg, value);
  }
  svgElement("text", { x: view.side + wide + 14, y: view.bottom + 10, class: "soft" }, svg, scene.unit ?? "K");
}

// Scale of colours, what the signs mean, and the length of 20 or 50 mm. Gives how far down they reach.
function drawKey(drawing) {
  const { svg, view, scene } = drawing;
  drawRamp(drawing);
  const dash = ink => (x, y) => svgElement("path", { d: `M${x},${y}h22`, stroke: `var(--${ink})`, "stroke-width": 5 }, svg);
  const cross = (x, y) => svgElement("path", { d: `M${x + 5},${y}h12M${x + 11},${y - 6}v12`, stroke: "var(--text)",
    "stroke-width": 1.8 }, svg);
  const signs = [];
  if (scene.flows.length) signs.push([dash("flow"), "heat between parts", 160], [dash("out"), "heat to coolant or ambient", 205]);
  if (scene.key_points.length) signs.push([cross, scene.sign ?? "key point", 100]);
  const start = view.upright ? view.side : view.side + 316;
  const length = view.scale * 0.05 > view.width / 6 ? 0.02 : 0.05;  // m
  const ruler = length * view.scale;
  let [x, y] = [start, view.bottom + (view.upright ? 46 : 5)];
  for (const [drawSign, words, wide] of signs) {
    if (x > start && x + wide > view.width - view.side - (view.upright ? 0 : ruler)) [x, y] = [start, y + 20];
    drawSign(x, y);
    svgElement("text", { x: x + 30, y: y + 4, class: "soft" }, svg, words);
    x += wide;
  }
  const end = view.width - view.side;
  const at = view.upright ? y + 24 : view.bottom + 5;
  svgElement("path", { d: `M${end - ruler},${at}h${ruler}`, stroke: "var(--text)", "stroke-width": 2 }, svg);
  svgElement("text", { x: end - ruler / 2, y: at + 17, class: "soft middle" }, svg, `${1000 * length} mm`);
  return Math.max(y + 10, at + 23, view.bottom + 31);
}

function paintBodies({ colour, tip }, paths, names, bodies) {
  for (const body of bodies) {
    if (!paths[body.name]) continue;
    paths[body.name].setAttribute("fill", colour.css(body.rise_K));
    tip(paths[body.name], body.tip);
    names[body.name]?.setAttribute("class", colour.darkLetters(body.rise_K) ? "name on-light" : "name on-dark");
  }
}

function draw(svg, pointed, scene, width) {
  svg.replaceChildren();
  const view = makeView(scene, width);
  const drawing = { svg, view, scene, room: makeRoom(view), colour: colourScale(scene.low_K, scene.high_K),
    tip: tipsInto(svg, pointed) };
  const paths = drawParts(drawing);
  if (scene.lumps) drawLinks(drawing);
  const nodes = drawNodes(drawing);
  const numbered = drawFlows(drawing);
  if (scene.lumps) {
    for (const node of nodes) drawBeside(drawing, aroundOf(view.at(node.at_m), 13), [node.name.replaceAll("_", " ")]);
  }
  const marks = drawKeyPoints(drawing);
  drawWatts(numbered, drawing);
  const names = drawPartNames(drawing, paths);
  const lowest = drawKey(drawing);
  svg.setAttribute("viewBox", `0 0 ${view.width} ${Math.max(view.height, lowest).toFixed(1)}`);
  paintBodies(drawing, paths, names, scene.bodies);
  return { drawing, paths, names, marks };
}

// Draws, and again when the window's width changes. `show(bodies, key_points)` gives bodies and key points other numbers,
// `rescale(low_K, high_K)` the colours another scale, `reflow(flows)` other flows; `leave()` makes room for another section in
// the same place.
export function drawSection(svg, pointed, scene) {
  const widthNow = () => Math.round(Math.min(1160, Math.max(320, svg.parentElement.clientWidth)));
  let width = widthNow();
  let drawn = draw(svg, pointed, scene, width);
  const follow = () => {
    if (widthNow() === width) return;
    width = widthNow();
    drawn = draw(svg, pointed, scene, width);
  };
  addEventListener("resize", follow);
  return {
    leave: () => removeEventListener("resize", follow),
    reflow(flows) {
      Object.assign(scene, { flows });
      drawn = draw(svg, pointed, scene, width);
    },
    rescale(low_K, high_K) {
      Object.assign(scene, { low_K, high_K });
      drawn = draw(svg, pointed, scene, width);
    },
    show(bodies, keyPoints) {
      const isLonger = keyPoints.some((point, i) => (point.label ?? "").length > (scene.key_points[i].label ?? "").length);
      Object.assign(scene, { bodies, key_points: keyPoints });
      if (isLonger) drawn = draw(svg, pointed, scene, width);
      paintBodies(drawn.drawing, drawn.paths, drawn.names, bodies);
      for (const point of keyPoints) {
        drawn.drawing.tip(drawn.marks[point.name].mark, point.tip);
        if (drawn.marks[point.name].label) drawn.marks[point.name].label.textContent = point.label;
      }
    },
  };
}
