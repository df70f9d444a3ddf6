// Curves over the time of day, with bands. The only file of this page that knows the chart library (uPlot, a name of its own
// script).
//
// series: [{name, ink, dashed, values, sd}]; `ink` names a colour of style.css; with `sd` a band of ±2σ is drawn.
import { element, fixed } from "./pages/elements.js";

const ink = name => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const clock = time_s => new Date(1000 * time_s).toLocaleTimeString("en-GB");
const chartHeight_px = 260, shortest_s = 60;

const edge = (values, sd, sign) => values.map((value, i) =>
  value === null || sd[i] === null || sd[i] === undefined ? null : value + sign * 2 * sd[i]);

// Columns as uPlot takes them: time, then of each series its values and, with a band, upper and lower edge.
function columnsOf(time_s, series) {
  return [time_s, ...series.flatMap(({ values, sd }) => sd ? [values, edge(values, sd, 1), edge(values, sd, -1)] : [values])];
}

function linesOf(series) {
  const lines = [{}], bands = [], places = [];
  for (const { name, ink: colour, dashed, sd } of series) {
    places.push(lines.length);
    lines.push({ label: name, stroke: () => ink(colour), width: 2, dash: dashed ? [7, 4] : [], points: { show: false } });
    if (!sd) continue;
    const side = { stroke: "transparent", width: 0, points: { show: false } };
    bands.push({ series: [lines.length, lines.length + 1], fill: () => `${ink(colour)}33` });
    lines.push({ ...side, label: `${name} +2σ` }, { ...side, label: `${name} −2σ` });
  }
  return { lines, bands, places };
}

function addLegend(place, series) {
  place.replaceChildren();
  const moment = element("b", {}, place);
  const values = series.map(({ name, ink: colour, dashed, sd }) => {
    const entry = element("span", { "data-series": name }, place);
    element("i", dashed ? { class: "dashed" } : {}, entry).style.borderTopColor = `var(--${colour})`;
    entry.append(`${name}${sd ? " ±2σ" : ""} `);
    return element("b", {}, entry);
  });
  return { moment, values };
}

const axis = more => ({ stroke: () => ink("soft"), font: "12px system-ui, sans-serif", ...more,
  grid: { stroke: () => ink("grid"), width: 0.5 }, ticks: { stroke: () => ink("grid"), width: 0.5 } });

// Of the values' scale: one flat curve does not fill the height with its noise.
function heightOf(_, low, high) {
  const middle = (low + high) / 2;
  const half = Math.max(0.5, 0.55 * (high - low));
  return [middle - half, middle + half];
}

function optionsOf(place, { lines, bands }, onCursor) {
  return {
    width: place.clientWidth, height: chartHeight_px, series: lines, bands,
    legend: { show: false },
    cursor: { drag: { x: false, y: false }, points: { size: 6 } },
    scales: { x: { range: (_, first, last) => [Math.min(first, last - shortest_s), last] }, y: { range: heightOf } },
    axes: [axis({ values: (_, times) => times.map(clock), space: 90 }), axis({ size: 52 })],
    hooks: { setCursor: [onCursor] },
  };
}

// A chart in two elements; gives renew(time_s, series): other values of the same series, or another chart.
export function makeChart(legendPlace, place, label) {
  let chart = null, drawn = "", series = [], legend = null, places = [];
  place.setAttribute("role", "img");
  function write() {
    const rows = chart.data[0].length;
    const row = chart.cursor.idx ?? rows - 1;
    if (row < 0) return;
    legend.moment.textContent = clock(chart.data[0][row]);
    legend.values.forEach((node, i) => {
      node.textContent = fixed(chart.data[places[i]][row] ?? null, 2);
    });
  }
  function begin(columns) {
    chart?.destroy();
    chart = null;
    const lines = linesOf(series);
    places = lines.places;
    legend = addLegend(legendPlace, series);
    place.setAttribute("aria-label", `${label} over time: ${series.map(({ name }) => name).join(", ")}`);
    chart = new uPlot(optionsOf(place, lines, () => chart && write()), columns, place);
  }
  new ResizeObserver(() => chart?.setSize({ width: place.clientWidth, height: chartHeight_px })).observe(place);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => chart?.redraw());
  return (time_s, given) => {
    series = given;
    const columns = columnsOf(time_s, series);
    const key = JSON.stringify(series.map(({ name, sd }) => [name, Boolean(sd)]));
    if (key !== drawn) begin(columns);
    else chart.setData(columns);
    drawn = key;
    write();
  };
}
