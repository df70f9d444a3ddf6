// The page of tests/bench/run: a bar for each row, then all rows as tables.
import { addRow, byId, element, left, pageData } from "./pages/elements.js";

const bench = pageData();
const kinds = { peer: "beside another way to the same result", bound: "beside the bare operation that it stands on" };
const drawn = bench.groups.map(group => ({ ...group, rows: group.rows.filter(row => !row.detail) }));

// The axis: whole powers of ten around all ratios and goals, and 1.
const exponents = drawn.flatMap(group => group.rows).flatMap(row => [row.ratio, row.goal])
  .filter(value => value !== null).map(Math.log10);
const low = Math.floor(Math.min(-1, ...exponents));
const high = Math.ceil(Math.max(1, ...exponents));
const place = ratio => 100 * (Math.log10(ratio) - low) / (high - low);  // percent of the track
const decades = Array.from({ length: high - low + 1 }, (_, i) => low + i);

const powerText = exponent => {
  const size = (10 ** Math.abs(exponent)).toLocaleString("en");
  return exponent < 0 ? `1/${size}` : size;
};

function addTrack(parent, kind) {
  const track = element("div", { class: `track ${kind}`, "aria-hidden": "true" }, parent);
  for (const exponent of decades) {
    element("span", { class: exponent === 0 ? "one" : "decade", style: `left:${place(10 ** exponent)}%` }, track);
  }
  return track;
}

function addScale(parent) {
  const line = element("div", { class: "line scale", "aria-hidden": "true" }, parent);
  element("div", { class: "what" }, line);
  const track = element("div", { class: "track" }, line);
  // Every second one where they would run into each other.
  for (const exponent of decades.filter(one => decades.length < 7 || one % 2 === 0)) {
    element("span", { class: "tick", style: `left:${place(10 ** exponent)}%` }, track, powerText(exponent));
  }
  for (const text of ["ours", "other", "multiple"]) element("div", { class: "value" }, line, text);
}

function addSides(parent) {
  const line = element("div", { class: "line sides" }, parent);
  element("div", { class: "what" }, line);
  const track = element("div", { class: "track" }, line);
  element("span", { class: "quicker", style: `right:${100 - place(1)}%` }, track, "\u2190 we are quicker");
  element("span", { class: "longer", style: `left:${place(1)}%` }, track, "we take longer \u2192");
}

function addLine(row, parent) {
  const line = element("div", { class: "line" }, parent);
  const what = element("div", { class: "what" }, line, row.name);
  element("small", {}, what, `beside ${row.other_name}`);
  if (row.ratio === null) {
    element("div", { class: "missing" }, line, row.ratio_text);
    return;
  }
  const track = addTrack(line, row.kind);
  const [from, to] = [place(Math.min(1, row.ratio)), place(Math.max(1, row.ratio))];
  element("span", { class: "fill", style: `left:${from}%;width:${to - from}%` }, track);
  if (row.goal !== null) element("span", { class: "goal", style: `left:${place(row.goal)}%` }, track);
  element("div", { class: "value" }, line, row.ours);
  element("div", { class: "value" }, line, row.other);
  element("div", { class: "value ratio" }, line, row.ratio_text);
}

function showBars() {
  for (const [kind, text] of Object.entries(kinds)) {
    const entry = element("span", {}, byId("legend"));
    element("span", { class: `sample ${kind}` }, entry);
    entry.append(text);
  }
  const entry = element("span", {}, byId("legend"));
  element("span", { class: "sample goal" }, entry);
  entry.append("goal, where there is one");
  addSides(byId("bars"));
  addScale(byId("bars"));
  for (const group of drawn.filter(one => one.rows.length)) {
    element("h3", {}, byId("bars"), group.name);
    for (const row of group.rows) addLine(row, byId("bars"));
  }
}

function showTable() {
  const table = byId("all");
  const last = () => table.rows[table.rows.length - 1].cells[0];
  addRow(table, [left("row"), "ours", "other", left("other is"), left("ours / other"), left("goal"), left("measured")], "th");
  for (const group of bench.groups) {
    addRow(table, [left(group.name)], "td", "sum");
    last().colSpan = table.rows[0].cells.length;
    for (const row of group.rows) {
      const whole = text => ({ text, kind: row.ratio === null ? "text" : "text whole" });
      addRow(table, [left(row.name), row.ours, row.other, left(row.other_name), whole(row.ratio_text), whole(row.goal_text),
        left(row.clock)]);
      element("small", {}, last(), row.means);
    }
  }
}

byId("run").textContent = Object.entries(bench.facts).map(([name, value]) => `${name} ${value}`).join(" \u00b7 ");
showBars();
showTable();
