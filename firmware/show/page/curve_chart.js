// Curves over the time of day, with bands. The only file of this page that knows the chart library (uPlot, a name of its own
// script).
//
// series: [{name, ink, dashed, values, sd, low, high}]; `ink` names a colour of style.css; with `sd` a band of ±2σ is drawn, with
// `low` and `high` another one between them.
import { element, fixed } from "./pages/elements.js";

const ink = name => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const clock = time_s => new Date(1000 * time_s).toLocaleTimeString("en-GB");
const minute = time_s => clock(time_s).slice(0, 5);
const day = time_s => new Date(1000 * time_s).toLocaleDateString("en-GB", { weekday: "short", day: "numeric" });
// Of days a tick at midnight is the day's.
const tickOf = time_s => minute(time_s) === "00:00" ? day(time_s) : minute(time_s);
const chartHeight_px = 260, shortest_s = 60;

const edge = (values, sd, sign) => values.map((value, i) =>
  value === null || sd[i] === null || sd[i] === undefined ? null : value + sign * 2 * sd[i]);

// Of a series the upper and lower edges of its bands, and how much of its colour they take.
function bandsOf({ values, sd, low, high }) {
  const between = low ? [{ name: "extreme", edges: [high, low], share: "55" }] : [];
  return sd ? [...between, { name: "2σ", edges: [edge(values, sd, 1), edge(values, sd, -1)], share: "33" }] : between;
}

// Columns as uPlot takes them: time, then of each series its values and its bands' edges.
function columnsOf(time_s, series) {
  return [time_s, ...series.flatMap(one => [one.values, ...bandsOf(one).flatMap(({ edges }) => edges)])];
}

// The places of values between two gaps, of which no line is drawn.
function lonely(chart, place) {
  const values = chart.data[place];
  const isThere = i => (values[i] ?? null) !== null;
  return [...values.keys()].filter(i => isThere(i) && !isThere(i - 1) && !isThere(i + 1));
}

function linesOf(series, width) {
  const lines = [{}], bands = [], places = [];
  for (const one of series) {
    const { name, ink: colour, dashed } = one;
    places.push(lines.length);
    lines.push({ label: name, stroke: () => ink(colour), width, dash: dashed ? [7, 4] : [],
      points: { show: false, filter: lonely, size: 4, fill: () => ink(colour) } });
    for (const band of bandsOf(one)) {
      const side = { stroke: "transparent", width: 0, points: { show: false } };
      bands.push({ series: [lines.length, lines.length + 1], fill: () => `${ink(colour)}${band.share}` });
      lines.push({ ...side, label: `${name} +${band.name}` }, { ...side, label: `${name} −${band.name}` });
    }
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

function optionsOf(place, { lines, bands }, asked, onCursor) {
  return {
    width: place.clientWidth, height: chartHeight_px, series: lines, bands,
    legend: { show: false }, padding: [null, asked() ? 24 : null, null, null],
    cursor: { drag: { x: false, y: false }, points: { size: 6 } },
    scales: { x: { range: (_, first, last) => asked() ?? [Math.min(first, last - shortest_s), last] }, y: { range: heightOf } },
    axes: [axis({ values: (_, times) => times.map(asked() ? tickOf : clock), space: 90 }), axis({ size: 52 })],
    hooks: { setCursor: [onCursor] },
  };
}

// A chart in two elements; gives renew(time_s, series, range): other values of the same series, or another chart. With a
// range, [from, to], the chart goes over that, of hours or days; without, over the times that there are.
export function makeChart(legendPlace, place, label) {
  let chart = null, drawn = "", series = [], legend = null, places = [], asked = null;
  place.setAttribute("role", "img");
  function write() {
    const rows = chart.data[0].length;
    const row = chart.cursor.idx ?? rows - 1;
    if (row < 0) return;
    const time_s = chart.data[0][row];
    legend.moment.textContent = asked ? `${day(time_s)} ${minute(time_s)}` : clock(time_s);
    legend.values.forEach((node, i) => {
      node.textContent = fixed(chart.data[places[i]][row] ?? null, 2);
    });
  }
  function begin(columns) {
    chart?.destroy();
    chart = null;
    const lines = linesOf(series, asked ? 1.25 : 2);
    places = lines.places;
    legend = addLegend(legendPlace, series);
    place.setAttribute("aria-label", `${label} over time: ${series.map(({ name }) => name).join(", ")}`);
    chart = new uPlot(optionsOf(place, lines, () => asked, () => chart && write()), columns, place);
  }
  new ResizeObserver(() => chart?.setSize({ width: place.clientWidth, height: chartHeight_px })).observe(place);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => chart?.redraw());
  return (time_s, given, range = null) => {
    series = given;
    asked = range;
    const columns = columnsOf(time_s, series);
    const key = JSON.stringify(series.map(one => [one.name, bandsOf(one).length]));
    if (key !== drawn) begin(columns);
    else chart.setData(columns);
    drawn = key;
    write();
  };
}
