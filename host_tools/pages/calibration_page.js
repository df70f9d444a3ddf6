// The page of `spindle-twin calibrate --html`: readings, model before and after, and what is left.
import { drawChart } from "./time_chart.js";
import { addFacts, addRow, byId, duration, element, fixed, pageData } from "./pages/elements.js";

const data = pageData();
const wide = text => ({ text, kind: "wide" });  // left out where there is little room

function writeHead() {
  byId("title").textContent = `Calibration of spindle “${data.spindle}”`;
  byId("state").textContent = `${duration(data.tested_s)} of test. Means of a minute of readings, the model with the ` +
    "priors (before) and with what was found (after); a probe's zero is unknown, so “before” begins at its first reading.";
  addFacts(byId("facts"), [["promised for the nose after 4 h without a sensor, 1σ", `${fixed(data.promised_um, 2)} µm`],
    ["chi-square per reading", fixed(data.chi_square_per_reading, 2)],
    ["verdict", data.misfits.length ? "does not fit" : "fits"]]);
  for (const misfit of data.misfits) element("p", { class: "label" }, byId("misfits"), misfit);
}

// Charts of one log share their axis of time.
function addChart(place, id, title, chart) {
  const box = element("div", {}, place);
  element("h3", {}, box, title);
  element("div", { class: "legend", id: `${id}-legend` }, box);
  element("div", { class: "chart", id }, box);
  drawChart(byId(`${id}-legend`), byId(id), chart);
}

function showChannel(channel, id, group) {
  const card = element("section", {}, byId("tests"));
  element("h2", {}, card, channel.name);
  element("p", {}, card, `What is left: ${fixed(channel.rms, 3)} ${channel.unit} rms, expected ` +
    `${fixed(channel.expected_rms, 3)} ${channel.unit}. Band: ±2σ of what may be left.`);
  const pair = element("div", { class: "pair" }, card);
  const { time_s } = channel;
  const label = channel.unit === "K" ? "temperature, °C" : "displacement, µm";
  addChart(pair, id, "Readings and model", { label, time_s, group, series: [
    { name: "measured", values: channel.measured, ink: "plant", width: 3 },
    { name: "after", values: channel.after, sd: channel.sd, ink: "twin" },
    { name: "before", values: channel.before, ink: "raw", dashed: true }] });
  addChart(pair, `${id}-left`, "What is left", { label: `measured − after, ${channel.unit}`, time_s, group, series: [
    { name: "expected", values: time_s.map(() => 0), sd: channel.sd, ink: "reading", width: 1 },
    { name: "left", values: channel.left, ink: "twin" }] });
}

function showTests() {
  data.tests.forEach((test, i) => {
    element("h2", {}, byId("tests"), test.log);
    test.channels.forEach((channel, k) => showChannel(channel, `test-${i}-${k}`, i));
  });
}

// `means`: how far off on average, in the place of what is less asked for where there is little room.
function showFits(id, channels, means) {
  const less = means ? wide : text => text;
  const mean = one => means ? [one.mean, one.mean_deviation].map(value => `${fixed(value, 3)} ${one.unit}`) : [];
  addRow(byId(id), ["channel", less("readings"), "rms", less("expected"), ...means ? ["mean", "±"] : [],
    wide("lag 1"), wide("outliers")], "th");
  for (const one of channels) {
    addRow(byId(id), [`${one.name}, log ${one.log}`, less(one.readings), `${fixed(one.rms, 3)} ${one.unit}`,
      less(`${fixed(one.expected_rms, 3)} ${one.unit}`), ...mean(one), wide(fixed(one.autocorrelation, 2)),
      wide(one.outliers)]);
  }
}

function showParameters() {
  addRow(byId("parameters"), ["parameter", "before", "±", "after", "±", { bar: 0 }], "th");
  for (const one of data.parameters) {
    addRow(byId("parameters"), [one.name, fixed(one.prior, 3), fixed(one.prior_deviation, 3), fixed(one.value, 3),
      fixed(one.deviation, 3), { bar: one.deviation / one.prior_deviation }]);
  }
}

writeHead();
showTests();
showFits("fit", data.fit, false);
showFits("held-out", data.held_out, true);
showParameters();
