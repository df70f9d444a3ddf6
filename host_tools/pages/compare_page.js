// The page of `spindle-twin compare`: one log replayed twice.
import { drawChart } from "./time_chart.js";
import { addRow, byId, element, fixed, left, pageData, signed } from "./pages/elements.js";

const data = pageData();
const less = (values, others) => values.map((v, row) => v === null || others[row] === null ? null : v - others[row]);
const number = (misfit, key, digits) => misfit ? fixed(misfit[key], digits) : "–";

function writeTables() {
  byId("state").textContent = `${data.log}, ${data.cycles} cycles.`;
  addRow(byId("first-second"), ["first", left(data.first)]);
  addRow(byId("first-second"), ["second", left(data.second)]);
  addRow(byId("table"), ["output", "first, rms", "second, rms", "difference, rms", "worst difference", "at, s"], "th");
  const add = (outputs, unit, words) => outputs.forEach(output => addRow(byId("table"), [`${output.name}, ${words}`,
    number(output.first_error, `rms_${unit}`, 3), number(output.second_error, `rms_${unit}`, 3),
    fixed(output.difference[`rms_${unit}`], 3), signed(output.difference[`worst_${unit}`], 3),
    fixed(output.difference.worst_at_s, 0)]));
  add(data.deformations, "um", "µm");
  add(data.key_points, "K", "K");
}

// One chart with a title, inside `place`.
function addChart(place, id, title, label, series) {
  const box = element("div", {}, place);
  element("h3", {}, box, title);
  element("div", { class: "legend", id: `${id}-legend` }, box);
  element("div", { class: "chart", id }, box);
  drawChart(byId(`${id}-legend`), byId(id), { label, time_s: data.time_s, series, joined: true });
}

function showOutput(output, id, quantity, unit) {
  const card = element("section", {}, byId("outputs"));
  element("h2", {}, card, output.name);
  element("p", {}, card, "Bands are each replay's own ±2σ.");
  const pair = element("div", { class: "pair" }, card);
  const read = output.measured.some(v => v !== null);
  addChart(pair, id, "Both", `${quantity}, ${unit === "K" ? "°C" : unit}`, [
    ...read ? [{ name: "measured", values: output.measured, ink: "reading", width: 1.5 }] : [],
    { name: "first", values: output.first, sd: output.first_sd, ink: "raw", dashed: true },
    { name: "second", values: output.second, sd: output.second_sd, ink: "twin" }]);
  addChart(pair, `${id}-difference`, "Difference and errors", `difference, ${unit}`, [
    { name: "second − first", values: less(output.second, output.first), ink: "plant" },
    ...read ? [{ name: "first − measured", values: output.first_off, ink: "raw", dashed: true },
      { name: "second − measured", values: output.second_off, ink: "twin" }] : []]);
}

writeTables();
data.deformations.forEach((output, i) => showOutput(output, `deformation-${i}`, "deformation", "µm"));
data.key_points.forEach((output, i) => showOutput(output, `key-point-${i}`, "temperature", "K"));
