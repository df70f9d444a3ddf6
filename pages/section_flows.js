// Heat flows of the section: an arrow across each contact, gap and film, its width by the watts.
import { fixed, svgElement } from "./elements.js";
import { drawBeside } from "./section_labels.js";
import { extentOf } from "./section_view.js";

// Of every heat that is drawn: the smallest, as a share of the largest, and how many get their watts in letters.
const smallestShare = 0.008;
const mostNumbers = 9;

// Square to the face: along the axis on which the place lies further out in the smaller of the two bodies.
function squareToFace(at, own, other) {
  const whole = !other || (own && own.size < other.size);
  const frame = whole ? own : other;
  if (!frame) return null;
  const off = [(at[0] - frame.x) / frame.halfX, (at[1] - frame.y) / frame.halfY];
  const k = Math.abs(off[0]) > Math.abs(off[1]) ? 0 : 1;
  const sign = (off[k] < 0 ? -1 : 1) * (whole ? 1 : -1);
  return k === 0 ? [sign, 0] : [0, sign];
}

// Between two lumps half way; out of a lump upwards, clear of it and of the other arrows that leave it.
function placeAmongLumps(from, to, beside) {
  if (to) return { at: [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2], way: [to[0] - from[0], to[1] - from[1]] };
  return { at: [from[0] + 26 * beside, from[1] - 36], way: [0, -1] };
}

function placeAtFace(flow, from, to, { scene, view }) {
  const at = view.at(flow.at_m);
  const square = squareToFace(at, extentOf(scene, view, flow.from), to && extentOf(scene, view, flow.to));
  if (square) return { at, way: square };
  const way = [0, 1].map(k => (to ?? at)[k] - from[k]);
  return { at, way: !to && Math.hypot(...way) < 6 ? [0, -1] : way };
}

// Where the arrow of a flow stands and where it points (a unit vector), in the sense of the heat.
function placeOf(flow, drawing) {
  const { scene, view, outward } = drawing;
  const centre = name => view.at(scene.bodies.find(body => body.name === name).centre_m);
  const inner = !flow.outside && (scene.lumps || scene.outlines.some(o => o.part === flow.to));
  const from = centre(flow.from);
  const to = inner ? centre(flow.to) : null;
  if (!inner) outward[flow.from] = (outward[flow.from] ?? -1) + 1;
  const { at, way } = scene.lumps ? placeAmongLumps(from, to, outward[flow.from]) : placeAtFace(flow, from, to, drawing);
  const length = (Math.hypot(...way) || 1) * (flow.heat_W < 0 ? -1 : 1);
  return { at, way: way.map(w => w / length) };
}

function drawArrow(flow, share, drawing) {
  const { at, way } = placeOf(flow, drawing);
  const wide = 1.2 + 7 * share;
  const long = 13 + 26 * share;
  const head = 5 + 8 * share;
  const corner = (along, aside) =>
    [0, 1].map(k => (at[k] + along * way[k] + aside * (k === 0 ? -way[1] : way[0])).toFixed(1)).join(",");
  const neck = long / 2 - head;
  const arrow = svgElement("polygon", {
    points: [corner(-long / 2, wide / 2), corner(neck, wide / 2), corner(neck, head * 0.62), corner(long / 2, 0),
      corner(neck, -head * 0.62), corner(neck, -wide / 2), corner(-long / 2, -wide / 2)].join(" "),
    fill: flow.outside ? "var(--out)" : "var(--flow)", stroke: "var(--page)", "stroke-width": 1,
  }, drawing.svg);
  const [source, target] = flow.heat_W >= 0 ? [flow.from, flow.to] : [flow.to, flow.from];
  drawing.tip(arrow, `${source} → ${target}: ${fixed(Math.abs(flow.heat_W), 2)} W (${flow.name}, ${flow.kind})`);
  const half = [0, 1].map(k => Math.abs(way[k]) * long / 2 + 4);
  drawing.room.take([at[0] - half[0], at[1] - half[1], at[0] + half[0], at[1] + half[1]]);
  return { at, half, watts: Math.abs(flow.heat_W), outside: flow.outside };
}

// Arrows of all flows that matter; gives those whose watts are to be written.
export function drawFlows(drawing) {
  drawing.outward = {};  // how many arrows before the last one leave each body
  const size = flow => Math.abs(flow.heat_W);
  const most = Math.max(...drawing.scene.flows.map(size), 1e-9);
  const shown = drawing.scene.flows.filter(f => f.at_m && size(f) > smallestShare * most).sort((a, b) => size(b) - size(a));
  return shown.map(flow => drawArrow(flow, Math.sqrt(size(flow) / most), drawing)).slice(0, mostNumbers);
}

// Watts beside their arrows, where there is room.
export function drawWatts(numbered, drawing) {
  for (const { at, half, watts, outside } of numbered) {
    const text = `${fixed(watts, watts < 9.95 ? 1 : 0)} W`;
    const box = [at[0] - half[0], at[1] - half[1], at[0] + half[0], at[1] + half[1]];
    drawBeside(drawing, box, [text], { kind: outside ? "watts out" : "watts", farthest: 24 });
  }
}
