// Names of the section's parts, where they fit inside.
import { svgElement } from "./elements.js";
import { textBox } from "./section_labels.js";

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
    const box = textBox(name);
    const [wide, high] = [(box[2] - box[0]) / 2, (box[3] - box[1]) / 2];
    const flat = { half: [wide, high], turn: 0 };
    const steep = { half: [high, wide], turn: -90 };
    const found = [flat, steep]
      .map(way => ({ ...way, at: placeInside(path, way.half, room) })).find(way => way.at);
    if (!found) {
      name.remove();
      continue;
    }
    const { at, half, turn } = found;
    name.setAttribute("transform", `translate(${at.x},${at.y}) rotate(${turn})`);
    name.setAttribute("y", -(box[1] + box[3]) / 2);
    room.takeText([at.x - half[0], at.y - half[1], at.x + half[0], at.y + half[1]]);
    names[part] = name;
  }
  return names;
}
