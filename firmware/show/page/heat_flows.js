// Where the heat goes now: through contacts and films from part to part, into coolant and ambient. The scene names the flows,
// the state has their watts.
import { byId, fixed, signed, svgElement } from "./pages/elements.js";
import { setFacts, setTable, setText } from "./cells.js";
import { plain } from "./words.js";

const mostFlows = 15, flowWide = 110, flowTall = 12;
const wattsOf = watts => `${fixed(watts, 1)} W`;

// The flows with their watts, as pages/section.js draws them; none before the first prediction, and where another network runs
// than the scene's.
export function flowsNow(scene, { heat }) {
  if (heat.flow_W.length !== scene.flows.length || heat.flow_W.some(value => value === null)) return [];
  return scene.flows.map((flow, i) => ({ ...flow, heat_W: heat.flow_W[i] }));
}

// Of each body what it makes, what it gives away to others, and what stays in it.
function balanceOf(scene, heat, flows) {
  const given = Object.fromEntries(scene.bodies.map(({ name }) => [name, 0]));
  for (const { from, to, outside, heat_W } of flows) {
    given[from] += heat_W;
    if (!outside) given[to] -= heat_W;
  }
  return scene.bodies.map(({ name }, i) => {
    const made = heat.made_W[i];
    return { name, made, given: given[name], stored: made - given[name] };
  });
}

function setFlowBar(cell, share, isOutside) {
  const svg = cell.querySelector("svg") ??
    svgElement("svg", { class: "flow", viewBox: `0 0 ${flowWide} ${flowTall}`, "aria-hidden": "true" }, cell);
  const bar = svg.firstChild ?? svgElement("rect", { y: 1, height: flowTall - 2, rx: 2 }, svg);
  bar.setAttribute("width", Math.max(1, flowWide * share));
  bar.setAttribute("fill", isOutside ? "var(--out)" : "var(--flow)");
}

function flowRow({ name, kind, from, to, outside, heat_W }, most_W) {
  const [source, target] = heat_W >= 0 ? [from, to] : [to, from];
  const through = name.includes("/") ? kind : plain(name);
  return [`${plain(source)} → ${plain(target)}`, through, fixed(Math.abs(heat_W), 2),
    cell => setFlowBar(cell, Math.abs(heat_W) / most_W, outside)];
}

function flowFacts(flows, balance) {
  const sum = key => balance.reduce((all, body) => all + body[key], 0);
  const surroundings = [...new Set(flows.filter(flow => flow.outside).map(flow => flow.to))];
  const into = name => flows.filter(flow => flow.outside && flow.to === name).reduce((all, flow) => all + flow.heat_W, 0);
  return [["made in the spindle", wattsOf(sum("made"))], ...surroundings.map(name => [`to ${plain(name)}`, wattsOf(into(name))]),
    ["stored in it", `${signed(sum("stored"), 1)} W`]];
}

export function showFlows(scene, state) {
  const flows = flowsNow(scene, state);
  byId("heat").hidden = flows.length === 0;
  if (flows.length === 0) return;
  const ranked = [...flows].sort((a, b) => Math.abs(b.heat_W) - Math.abs(a.heat_W));
  const most_W = Math.max(Math.abs(ranked[0].heat_W), 1e-9);
  const balance = balanceOf(scene, state.heat, flows);
  setFacts(byId("heat-facts"), flowFacts(flows, balance));
  const heads = ["from → to", "through", "W", "share of the largest"];
  setTable(byId("heat-flows"), heads, ranked.slice(0, mostFlows).map(flow => flowRow(flow, most_W)));
  const rest = ranked.length - mostFlows;
  setText(byId("heat-rest"), rest > 0 ? `${rest} more, each of ${fixed(Math.abs(ranked[mostFlows].heat_W), 2)} W or less.` : "");
  setTable(byId("heat-balance"), ["part", "made, W", "given to others, W", "stored, W"],
    balance.map(({ name, made, given, stored }) => [plain(name), fixed(made, 2), fixed(given, 2), signed(stored, 2)]));
}
