// The curves of what the page has seen: growth and compensation, and one key point's temperatures.
import { byId, element } from "./pages/elements.js";
import { makeChart } from "./curve_chart.js";
import { makeRecent } from "./recent.js";

const recent = makeRecent();
const some = list => list.some(value => value !== null);
const drawGrowth = makeChart(byId("growth-legend"), byId("growth-curves"), "nose growth and compensation, µm");
const drawPoint = makeChart(byId("point-legend"), byId("point-curves"), "temperature at a key point, °C");

// The key points as choices, anew where they are others.
function offerPoints(names) {
  const select = byId("point");
  if ([...select.options].map(option => option.value).join("\n") === names.join("\n")) return;
  select.replaceChildren();
  for (const name of names) element("option", { value: name }, select, name);
}

function growthSeries() {
  const list = name => recent.list(sample => sample[name]);
  const sd = list("nose_sd");
  const uncorrected = list("uncorrected");
  return [
    { name: "growth", ink: "twin", values: list("nose"), ...(some(sd) ? { sd } : {}) },
    { name: "compensation", ink: "raw", dashed: true, values: list("compensation") },
    ...(some(uncorrected) ? [{ name: "without correction", ink: "reading", dashed: true, values: uncorrected }] : []),
  ];
}

function pointSeries(point) {
  const list = name => recent.list(sample => sample[name][point]);
  const sd = list("predicted_sd");
  return [
    { name: "predicted", ink: "twin", values: list("predicted"), ...(some(sd) ? { sd } : {}) },
    { name: "measured", ink: "raw", dashed: true, values: list("measured") },
  ];
}

function drawCurves() {
  const time_s = recent.list(sample => sample.time_s);
  if (!time_s.length) return;
  drawGrowth(time_s, growthSeries());
  drawPoint(time_s, pointSeries(byId("point").value));
}

export function addToCurves(registers) {
  offerPoints(Object.keys(registers.key_point_predicted_float32.values));
  recent.add(Date.now() / 1000, registers);
  drawCurves();
}

// Another spindle.
export const clearCurves = () => recent.clear();

byId("point").addEventListener("change", drawCurves);
