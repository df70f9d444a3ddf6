// Where things of the section come to stand on the drawing, and which places are still free for texts.

// Landscape: the axis to the right, the nose on the left, r upwards. Portrait, for narrow windows: the axis downwards, the
// nose on top, r to the right.
export function makeView(scene, width) {
  const points = scene.outlines.length ? scene.outlines.flatMap(o => o.points_m) : scene.nodes.map(n => n.at_m);
  const r = points.map(p => p[0]);
  const z = points.map(p => p[1]);
  const [z0, z1, r0, r1] = [Math.min(...z), Math.max(...z), Math.min(0, ...r), Math.max(...r)];
  const upright = width < 700;
  const lumps = scene.lumps;
  const side = lumps ? Math.min(90, width / 5) : 34;
  const above = lumps ? 92 : 20;
  const below = upright ? (scene.flows.length ? 190 : 150) : 78;
  const along = Math.max(z1 - z0, 1e-9);
  const across = Math.max(r1 - r0, 1e-9);
  const scale = upright ? Math.min((width - 2 * side) / across, 900 / along) : Math.min((width - 2 * side) / along, 560 / across);
  const height = above + scale * (upright ? along : r1 - r0) + below;
  const left = (width - scale * (upright ? r1 - r0 : z1 - z0)) / 2;
  const view = { width, height, side, scale, upright, bottom: height - below + (lumps ? 52 : 44) };
  view.x = upright ? at => left + scale * (at[0] - r0) : at => left + scale * (at[1] - z0);
  view.y = upright ? at => above + scale * (at[1] - z0) : at => above + scale * (r1 - at[0]);
  view.at = place => [view.x(place), view.y(place)];
  view.axis = [[0, z0], [0, z1]].map(view.at);
  return view;
}

const overlap = (a, b) => a[0] < b[2] && a[2] > b[0] && a[1] < b[3] && a[3] > b[1];

// Whether the line [from, to] goes through the box; touching is not that.
function crosses([from, to], box) {
  let [first, last] = [0, 1];
  for (const k of [0, 1]) {
    const length = to[k] - from[k];
    if (length === 0) {
      if (from[k] <= box[k] || from[k] >= box[k + 2]) return false;
      continue;
    }
    const [enter, leave] = [(box[k] - from[k]) / length, (box[k + 2] - from[k]) / length].sort((a, b) => a - b);
    [first, last] = [Math.max(first, enter), Math.min(last, leave)];
  }
  return first < last;
}

// What is drawn keeps texts away: boxes [x0, y0, x1, y1], of texts in a list of their own, and lines to texts. No text leaves
// the drawing, or reaches down to its key.
export function makeRoom(view) {
  const [taken, texts, leaders] = [[], [], []];
  const isInside = box => box[0] >= 0 && box[1] >= 0 && box[2] <= view.width && box[3] <= view.bottom - 4;
  return {
    take: box => taken.push(box),
    takeText: box => texts.push(box),
    takeLeader: leader => leaders.push(leader),
    isFree: box => isInside(box) && ![...taken, ...texts].some(other => overlap(box, other)) &&
      !leaders.some(leader => crosses(leader, box)),
    isClear: leader => !texts.some(box => crosses(leader, box)),
  };
}

// Middle and half sizes of a body's outline on the drawing; null where nobody drew it.
export function extentOf(scene, view, name) {
  const own = scene.outlines.filter(o => o.part === name).flatMap(o => o.points_m).map(view.at);
  if (!own.length) return null;
  const [x, y] = [0, 1].map(k => own.map(p => p[k]));
  const [x0, x1, y0, y1] = [Math.min(...x), Math.max(...x), Math.min(...y), Math.max(...y)];
  return { x: (x0 + x1) / 2, y: (y0 + y1) / 2, halfX: (x1 - x0) / 2, halfY: (y1 - y0) / 2, size: (x1 - x0) * (y1 - y0) };
}
