// A chart as SVG of its own, for the page and for a report that is read without it.
//
// series: [{name, dashed, values}], values null where there is none; time_s: of each, from 0; marks: [{time_s, value}].
import { duration, element, fixed, svgElement } from "./pages/elements.js";

const usual = 720, narrowest = 300, height = 240, margin = { left: 56, right: 12, top: 8, bottom: 26 }, inks = 5;

// About four round numbers between two.
function ticksOf(low, high) {
  const rough = (high - low) / 4;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map(round => round * power).find(round => round >= rough);
  const first = Math.ceil(low / step);
  return [...Array(Math.floor(high / step) - first + 1).keys()].map(i => (first + i) * step);
}

function rangeOf(values) {
  const low = Math.min(...values), high = Math.max(...values);
  const half = Math.max(0.5, 0.55 * (high - low)), middle = (low + high) / 2;
  return [middle - half, middle + half];
}

// The pieces of a line between its gaps, as the path of an SVG.
function pathOf(values, x, y) {
  let isOpen = false;
  return values.map((value, i) => {
    const letter = isOpen ? "L" : "M";
    isOpen = value !== null;
    return isOpen ? `${letter}${x(i).toFixed(1)} ${y(value).toFixed(1)}` : "";
  }).join("");
}

function addAxes(svg, width, end_s, [low, high], { x, y }) {
  for (const value of ticksOf(low, high)) {
    svgElement("line", { class: "rule", x1: margin.left, x2: width - margin.right, y1: y(value), y2: y(value) }, svg);
    const digits = high - low < 4 ? 1 : 0;
    svgElement("text", { class: "soft", x: margin.left - 6, y: y(value) + 4, "text-anchor": "end" }, svg, fixed(value, digits));
  }
  for (const share of [0, 0.25, 0.5, 0.75, 1]) {
    const anchor = share === 0 ? "start" : share === 1 ? "end" : "middle";
    const place = { class: "soft", x: x(share * end_s), y: height - 8, "text-anchor": anchor };
    svgElement("text", place, svg, duration(share * end_s));
  }
}

// Anew in a figure; nothing without two moments.
export function drawLines(figure, label, time_s, series, marks = []) {
  figure.replaceChildren();
  const values = [...series.flatMap(one => one.values), ...marks.map(mark => mark.value)].filter(value => value !== null);
  if (time_s.length < 2 || values.length === 0) return;
  const end_s = Math.max(time_s.at(-1), 1), range = rangeOf(values);
  // As wide as its place, so that its letters have the page's size; a report has no place yet.
  const width = Math.max(narrowest, figure.clientWidth || usual);
  const x = at_s => margin.left + (width - margin.left - margin.right) * Math.min(1, Math.max(0, at_s / end_s));
  const y = value => margin.top + (height - margin.top - margin.bottom) * (range[1] - value) / (range[1] - range[0]);
  const names = series.map(({ name }) => name).join(", ");
  const svg = svgElement("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `${label}: ${names}` }, figure);
  addAxes(svg, width, end_s, range, { x, y });
  const caption = element("figcaption", {}, figure, label);
  series.forEach(({ name, dashed, values: line }, i) => {
    const kind = `ink-${i % inks}${dashed || i >= inks ? " dashed" : ""}`;
    svgElement("path", { class: `line ${kind}`, d: pathOf(line, k => x(time_s[k]), y) }, svg);
    element("i", { class: kind }, caption);
    caption.append(name);
  });
  for (const mark of marks) svgElement("circle", { class: "mark ink-1", cx: x(mark.time_s), cy: y(mark.value), r: 5 }, svg);
  if (marks.length) caption.append(" ○ touch-off");
}
