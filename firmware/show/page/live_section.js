// The section of the spindle in the colours of its parts' temperatures.
import { byId, fixed } from "./pages/elements.js";
import { drawSection } from "./pages/section.js";
import { flowsNow } from "./heat_flows.js";
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

// Also those without a temperature of their own, volumes of air: heat flows to them.
function placedBodies(parts, scene) {
  return scene.bodies.map(({ name, centre_m }) =>
    ({ name, rise_K: null, tip: name, ...parts.find(part => part.name === name), centre_m }));
}

// Whether arrows would look otherwise: another sense, or more than this share of the largest.
function lookOtherwise(flows, drawn) {
  const visible = 0.03;
  if (flows.length !== drawn.length) return true;
  const most_W = Math.max(...flows.map(flow => Math.abs(flow.heat_W)), 1e-9);
  return flows.some((flow, i) => Math.abs(flow.heat_W - drawn[i].heat_W) > visible * most_W);
}

const pointsOf = (registers, scene) => scene.key_points.map(({ name, at_m }) => {
  const value = registers.key_point_predicted_float32.values[name] ?? null;
  const text = value === null ? "–" : `${fixed(value, 1)} °C`;
  return { name, at_m, label: `${name} ${text}`, tip: `key point ${name}: ${text}` };
});

// Gives show(state); of a network without outlines nothing is drawn, and its parts stand open in their list.
export function makeSection(scene) {
  const isDrawn = scene.outlines.length > 0;
  byId("section-place").hidden = !isDrawn;
  byId("all-parts").open = !isDrawn;
  let section = null;
  let scale = [], drawnFlows = [];
  return {
    leave: () => section?.leave(),
    show(state) {
      const { registers } = state;
      const parts = bodiesOf(registers);
      if (!isDrawn || parts.length === 0) return;
      const bodies = placedBodies(parts, scene);
      const points = pointsOf(registers, scene);
      const flows = flowsNow(scene, state);
      const [low_K, high_K] = wholeScale(parts.map(part => part.rise_K));
      section ??= drawSection(byId("section"), byId("pointed"), { outlines: scene.outlines, nodes: [], flows, lumps: false,
        low_K, high_K, unit: "°C", bodies, key_points: points });
      section.show(bodies, points);
      if (scale[0] !== low_K || scale[1] !== high_K) section.rescale(low_K, high_K);
      scale = [low_K, high_K];
      if (!lookOtherwise(flows, drawnFlows)) return;
      section.reflow(flows);
      drawnFlows = flows;
    },
  };
}
