// Letters on the section: names of parts where they fit inside, names of lumped nodes and of key points beside them.
import { svgElement } from "./elements.js";

// The place inside the path nearest to its middle where a text of that half size fits and nothing else stands.
function placeInside(path, half, room) {
  const frame = path.getBBox();
  const middle = [frame.x + frame.width / 2, frame.y + frame.height / 2];
  const shares = [-1, -0.5, 0, 0.5, 1];
  let best = null;
  for (let y = frame.y + half[1] + 1; y <= frame.y + frame.height - half[1]; y += 2) {
    for (let x = frame.x + half[0]; x <= frame.x + frame.width - half[0]; x += 2) {
      const far = Math.hypot((half[0] > half[1] ? 1 : 3) * (x - middle[0]), (half[0] > half[1] ? 3 : 1) * (y - middle[1]));
      if (best && far >= best.far) continue;
      if (!room.isFree([x - half[0], y - half[1], x + half[0], y + half[1]])) continue;
      const inside = shares.every(a => shares.every(b => path.isPointInFill(new DOMPoint(x + a * half[0], y + b * half[1]))));
      if (inside) best = { far, x, y };
    }
  }
  return best;
}

// A part's name lies along the axis, or else across; gives the texts of the parts that have room for one.
export function drawPartNames({ svg, room }, paths) {
  const names = {};
  for (const [part, path] of Object.entries(paths)) {
    const name = svgElement("text", { class: "name" }, svg, part.replaceAll("_", " "));
    const wide = name.getComputedTextLength() / 2 + 3;
    const flat = { half: [wide, 7], turn: 0 };
    const steep = { half: [7, wide], turn: -90 };
    const found = [flat, steep]
      .map(way => ({ ...way, at: placeInside(path, way.half, room) })).find(way => way.at);
    if (!found) {
      name.remove();
      continue;
    }
    const { at, half, turn } = found;
    name.setAttribute("transform", `translate(${at.x},${at.y}) rotate(${turn})`);
    name.setAttribute("y", 4);
    room.take([at.x - half[0], at.y - half[1], at.x + half[0], at.y + half[1]]);
    names[part] = name;
  }
  return names;
}

// A text beside a mark, at the nearest of the places around it that is free, with a line to the mark where that is far.
export function drawBeside({ svg, view, room }, at, away, text) {
  const wide = 3.8 * text.length;
  const box = ([x, y]) => [at[0] + x - wide, at[1] + y - 10, at[0] + x + wide, at[1] + y + 3];
  const around = [0, 16, 32, 48, 64].flatMap(more => {
    const far = away + more;
    const sides = [[0, far + 14], [0, -far - 5], [wide + far + 4, 4], [-wide - far - 4, 4], [wide + far, -far],
      [-wide - far, -far], [wide + far, far + 8], [-wide - far, far + 8]];
    return sides.map(place => ({ place, more }));
  });
  const onDrawing = ([x0, y0, x1]) => x0 >= 0 && x1 <= view.width && y0 >= 0;
  const { place, more } = around.find(a => onDrawing(box(a.place)) && room.isFree(box(a.place))) ?? around[0];
  room.take(box(place));
  if (more) {
    const end = [at[0] + place[0] - Math.sign(place[0]) * wide, at[1] + place[1] - 4];
    svgElement("line", { x1: at[0], y1: at[1], x2: end[0], y2: end[1], stroke: "var(--text)", "stroke-width": 0.8 }, svg);
  }
  return svgElement("text", { x: at[0] + place[0], y: at[1] + place[1], class: "watts" }, svg, text);
}
