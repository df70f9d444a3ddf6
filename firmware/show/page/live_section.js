// The section of the spindle in the colours of its parts' temperatures.
import { byId, fixed } from "./pages/elements.js";
import { drawSection } from "./pages/section.js";
import { plain } from "./words.js";

// Whole steps of 5 degrees around all values, so that the scale stays while little changes.
function wholeScale(values) {
  const step = 5;
  const low = step * Math.floor(Math.min(...values) / step);
  return [low, Math.max(low + step, step * Math.ceil(Math.max(...values) / step))];
}

function bodiesOf(registers) {
  return Object.entries(registers.part_maximum_float32.values).filter(([, value]) => value !== null)
    .map(([name, value]) => ({ name, rise_K: value, tip: `${plain(name)}: highest ${fixed(value, 1)} °C` }));
}

const pointsOf = (registers, scene) => scene.key_points.map(({ name, at_m }) => {
  const value = registers.key_point_predicted_float32.values[name] ?? null;
  const text = value === null ? "–" : `${fixed(value, 1)} °C`;
  return { name, at_m, label: `${name} ${text}`, tip: `key point ${name}: ${text}` };
});

// Gives show(registers); of a network without outlines nothing is drawn, and its parts stand open in their list.
export function makeSection(scene) {
  const isDrawn = scene.outlines.length > 0;
  byId("section-place").hidden = !isDrawn;
  byId("all-parts").open = !isDrawn;
  let section = null;
  let scale = [];
  return {
    leave: () => section?.leave(),
    show(registers) {
      const bodies = bodiesOf(registers);
      if (!isDrawn || bodies.length === 0) return;
      const points = pointsOf(registers, scene);
      const [low_K, high_K] = wholeScale(bodies.map(body => body.rise_K));
      section ??= drawSection(byId("section"), byId("pointed"), { outlines: scene.outlines, nodes: [], flows: [], lumps: false,
        low_K, high_K, unit: "°C", bodies, key_points: points });
      section.show(bodies, points);
      if (scale[0] !== low_K || scale[1] !== high_K) section.rescale(low_K, high_K);
      scale = [low_K, high_K];
    },
  };
}
