// Letters beside what they belong to. No text covers another, an arrow or a mark, and none leaves the drawing; each takes the
// free place nearest to its mark, with a line to it where that is not near. The same texts always get the same places.
import { svgElement } from "./elements.js";

const directions = 16;
const [firstGap, gapStep, nearest] = [3, 10, 14];  // px

const middleOf = box => [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2];
const shifted = (box, [x, y]) => [box[0] + x, box[1] + y, box[2] + x, box[3] + y];
const nearestIn = (box, at) => [0, 1].map(k => Math.min(Math.max(at[k], box[k]), box[k + 2]));

// What the text covers, with its rim.
export function textBox(text) {
  const { x, y, width, height } = text.getBBox();
  const rim = 2;
  return [x - rim, y - rim, x + width + rim, y + height + rim];
}

// Ways from the middle of the mark to that of the text, nearest first, straight up before its sides.
function* waysAround(half, farthest) {
  for (let gap = firstGap; gap <= farthest; gap += gapStep) {
    for (let k = 0; k < directions; ++k) {
      const turn = (k % 2 === 0 ? 1 : -1) * Math.ceil(k / 2) * 2 * Math.PI / directions;
      yield [Math.sin(turn) * (gap + half[0]), -Math.cos(turn) * (gap + half[1])];
    }
  }
}

// From the edge of the text to that of its mark; null where that is near.
function leaderOf(box, mark) {
  const end = nearestIn(mark, middleOf(box));
  const start = nearestIn(box, end);
  return Math.hypot(end[0] - start[0], end[1] - start[1]) <= nearest ? null : [start, end];
}

function findPlace(box, mark, room, farthest, withClearLeader) {
  const [from, at] = [middleOf(box), middleOf(mark)];
  const half = [0, 1].map(k => (box[k + 2] - box[k] + mark[k + 2] - mark[k]) / 2);
  for (const way of waysAround(half, farthest)) {
    const shift = [0, 1].map(k => at[k] + way[k] - from[k]);
    const placed = shifted(box, shift);
    if (!room.isFree(placed)) continue;
    const leader = leaderOf(placed, mark);
    if (!withClearLeader || leader === null || room.isClear(leader)) return { placed, shift, leader };
  }
  return null;
}

// Lines of text, centred, beside a mark [x0, y0, x1, y1] of the drawing, no further than `farthest` from it. Gives an element
// for each line, or null where there is no room for the text.
export function drawBeside({ svg, view, room }, mark, lines, { kind = "watts", farthest = view.width + view.height } = {}) {
  const text = svgElement("text", { class: kind }, svg);
  const rows = lines.map((line, k) => svgElement("tspan", { x: 0, dy: k === 0 ? 0 : "1.4em" }, text, line));
  const box = textBox(text);
  const found = findPlace(box, mark, room, farthest, true) ?? findPlace(box, mark, room, farthest, false);
  if (!found) {
    text.remove();
    return null;
  }
  text.setAttribute("transform", `translate(${found.shift.map(c => c.toFixed(1)).join(",")})`);
  room.takeText(found.placed);
  if (found.leader) {
    const [[x1, y1], [x2, y2]] = found.leader;
    const line = svgElement("line", { class: "leader", x1, y1, x2, y2, stroke: "var(--text)", "stroke-width": 0.8 }, svg);
    svg.insertBefore(line, text);
    room.takeLeader(found.leader);
  }
  return rows;
}
