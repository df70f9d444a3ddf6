// The report: one file that needs nothing else, made on the page. Its texts come in as text only, never as HTML.
import { addRow, byId, duration, element, fixed, signed } from "./pages/elements.js";
import { drawWarmUp, warmUpText } from "./warm_up_card.js";
import { notes } from "./notes.js";
import { sensorHeads, sensorRows, tareText } from "./sensors_card.js";
import { setText } from "./cells.js";
import { signText, trialVerdict } from "./trial_card.js";

// The rules of this page's style sheets, but for those of a dark screen: a report is for paper.
function styleText() {
  const isLight = rule => !rule.conditionText?.includes("dark");
  const rules = [...document.styleSheets].flatMap(sheet => [...sheet.cssRules]).filter(isLight);
  return `${rules.map(rule => rule.cssText).join("\n")}\n:root { color-scheme: light; }\n`;
}

const field = id => byId(id).value.trim() || "–";
const placeIn = (report, name) => report.querySelector(`[data-place="${name}"]`);

function fillTable(table, heads, rows) {
  if (heads) addRow(element("thead", {}, table), heads, "th");
  const body = element("tbody", {}, table);
  for (const row of rows) addRow(body, row);
}

function networkText(scene, registers) {
  const running = registers.network_id.value.toString(16).padStart(8, "0");
  const { sha256, cases, worst_K, worst_nose_um } = scene.network;
  if (!sha256.startsWith(running)) return `SHA-256 ${running}…, exchanged since the daemon began`;
  const certificate = cases === 0 ? "no certificate: its error was not measured"
    : `certificate of ${cases} cases, worst ${fixed(worst_K, 3)} K at a key point and ${fixed(worst_nose_um, 2)} µm at the nose`;
  return `SHA-256 ${sha256}; ${certificate}`;
}

function aboutRows({ scene, state, user }) {
  const { registers } = state;
  const { limit_um, slew_um_per_s } = scene.compensation;
  return [["machine", field("machine")], ["control and input", field("control")], ["gauge", field("gauge")],
    ["commissioned by", user ?? "–"], ["spindle", state.spindle], ["network", networkText(scene, registers)],
    ["daemon", `spindle-twind ${state.version}, register map ${state.map_version}, cycle ${registers.sequence.value}`],
    ["state", registers.state.name],
    ["compensation", `limit ${limit_um === null ? "none" : `${fixed(limit_um, 1)} µm`}, slew limit ${slew_um_per_s} µm/s`]];
}

function trialRows() {
  const { ordered_um, value_um, gauge_um } = notes.trial;
  const um = value => value === null ? "–" : signed(value, 2);
  return ["first zero", "plus", "minus", "zero again"].map((name, i) =>
    [name, um(ordered_um[i]), um(value_um[i]), um(gauge_um[i])]);
}

function fillReport(report, { words, ...said }) {
  const put = (name, text) => setText(placeIn(report, name), text);
  const { registers } = said.state;
  put("when", new Date().toString());
  put("notice", said.scene.notice);
  placeIn(report, "notice").hidden = said.scene.notice === "";
  fillTable(placeIn(report, "about"), null, aboutRows(said));
  put("remarks", byId("remarks").value.trim());
  fillTable(placeIn(report, "sensors"), sensorHeads, sensorRows(words, registers));
  put("tare", tareText(words, registers));
  put("sign", `${signText()} Gauge: + = nose further from the table; read to ${byId("gauge-um").value} µm.`);
  fillTable(placeIn(report, "trial"), ["step", "ordered, µm", "register, µm", "gauge, µm"], trialRows());
  const { title, text, change } = trialVerdict();
  put("verdict", title);
  put("verdict-text", text);
  put("verdict-change", change);
  put("warm", warmUpText());
  drawWarmUp(placeIn(report, "growth"), placeIn(report, "points"));
  const lengths = notes.warmUp.lengths.map(({ time_s, output, um, sd_um }) => [duration(time_s), output, signed(um, 2), sd_um]);
  if (lengths.length) fillTable(placeIn(report, "lengths"), ["touch-off after", "output", "length, µm", "sd, µm"], lengths);
}

// The report as the text of a file; said: {words, scene, state, user}.
export function reportText(said) {
  const title = `Commissioning of ${said.state.spindle}`;
  // Never part of this page, whose policy would refuse a style of its own.
  const root = document.createElement("html");
  root.lang = "en";
  const head = element("head", {}, root), body = element("body", {}, root);
  element("meta", { charset: "utf-8" }, head);
  element("meta", { name: "viewport", content: "width=device-width, initial-scale=1" }, head);
  element("title", {}, head, title);
  element("style", {}, head, styleText());
  element("h1", {}, body, title);
  const content = byId("report").content.cloneNode(true);
  fillReport(content, said);
  body.append(content);
  return `<!DOCTYPE html>\n${root.outerHTML}\n`;
}

export function saveReport(said) {
  const address = URL.createObjectURL(new Blob([reportText(said)], { type: "text/html" }));
  const day = new Date().toISOString().slice(0, 10);
  const name = `commissioning_${said.state.spindle.replace(/[^\w.-]+/g, "_")}_${day}.html`;
  const link = element("a", { href: address, download: name }, document.body);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 60000);
  return name;
}
