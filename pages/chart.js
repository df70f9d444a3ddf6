// Curves with bands over an axis of time, for every page. The only file that knows the chart library (uPlot, a name of its
// own script).
//
// series: [{name, ink, values, dashed, width, steps, joined, sd, low, high}]; `ink` names a colour of style.css; `steps` holds a
// value until the next, `joined` draws across what is null; with `sd` a band of ±2σ is drawn, with `low` and `high` another one.
// look: label (what the values are, with their unit), moment(time_s): words for the legend, ticks(times, step): words along
// the axis, heightOf(low, high): the range of the values' scale; and where wanted
//   xLabel, yLabel, tickSpace_px   of the axes
//   ofClock                        times are seconds since 1970, and ticks stand at whole minutes, hours, days
//   spanOf(first, last)            the range of the axis of time, else all times
//   restsAtEnd                     the legend says the last values where no moment is pointed at
//   zooms, onZoom(range)           drag to zoom, double-click to reset; told from which to which time, null: all
//   onPoint(row)                   a moment is pointed at, -1: none
import { element, fixed } from "./elements.js";

const ink = name => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const letters = "12px system-ui, sans-serif";
const numberOf = value => value ?? null;

const edge = (values, sd, sign) => values.map((value, i) =>
  numberOf(value) === null || numberOf(sd[i]) === null ? null : value + sign * 2 * sd[i]);

// Of a series the upper and lower edges of its bands, and how much of its colour they take.
function bandsOf({ values, sd, low, high }) {
  const between = low ? [{ name: "extreme", edges: [high, low], share: "55" }] : [];
  return sd?.length ? [...between, { name: "2σ", edges: [edge(values, sd, 1), edge(values, sd, -1)], share: "33" }] : between;
}

// Columns as uPlot takes them: time, the edges of all bands, all values. It draws in this order, so no band covers a line.
const columnsOf = (time_s, series) =>
  [time_s, ...series.flatMap(bandsOf).flatMap(({ edges }) => edges), ...series.map(({ values }) => values)];

// The places of values between two gaps, of which no line is drawn.
function lonely(chart, place) {
  const values = chart.data[place];
  const isThere = i => numberOf(values[i]) !== null;
  return [...values.keys()].filter(i => isThere(i) && !isThere(i - 1) && !isThere(i + 1));
}

const wayOf = ({ steps, joined = false }) =>
  ({ pxAlign: 0, spanGaps: joined, ...(steps ? { paths: uPlot.paths.stepped({ align: 1 }) } : {}) });

function linesOf(series) {
  const lines = [{}], bands = [];
  for (const one of series) {
    const side = { ...wayOf(one), stroke: "transparent", width: 0, points: { show: false } };
    for (const band of bandsOf(one)) {
      bands.push({ series: [lines.length, lines.length + 1], fill: () => `${ink(one.ink)}${band.share}` });
      lines.push({ ...side, label: `${one.name} +${band.name}` }, { ...side, label: `${one.name} −${band.name}` });
    }
  }
  const first = lines.length;
  for (const one of series) {
    const { name, ink: colour, dashed, width = 2, joined } = one;
    lines.push({ ...wayOf(one), label: name, stroke: () => ink(colour), width, dash: dashed ? [7, 4] : [],
      points: { show: false, filter: joined ? () => null : lonely, size: 4, fill: () => ink(colour) } });
  }
  return { lines, bands, first };
}

// A legend with room for the value of each curve.
function addLegend(place, series) {
  place.replaceChildren();
  const moment = element("b", {}, place);
  const values = series.map(one => {
    const entry = element("span", { "data-series": one.name }, place);
    element("i", one.dashed ? { class: "dashed" } : {}, entry).style.borderTopColor = `var(--${one.ink})`;
    entry.append(`${one.name}${one.sd?.length ? " ±2σ" : ""} `);
    return element("b", {}, entry);
  });
  return { moment, values };
}

// As many digits as the step between two ticks needs.
export const plainTicks = (values, step) => values.map(value => fixed(value, String(step).split(".")[1]?.length ?? 0));

const axis = (label, more) => ({ stroke: () => ink("soft"), font: letters, ...more,
  ...(label ? { label, labelFont: letters, labelSize: 18, labelGap: 0 } : {}),
  grid: { stroke: () => ink("grid"), width: 0.5 }, ticks: { stroke: () => ink("grid"), width: 0.5 } });
const widthOf = texts => 18 + 7 * Math.max(4, ...(texts ?? []).map(text => text.length));  // px
// Paper's width without margins is not told; this is a little less than that of A4 and Letter, so letters keep their size.
const paper_px = 660;
const sizeOf = (place, most_px = Infinity) => ({ width: Math.min(place.clientWidth, most_px), height: place.clientHeight });

function optionsOf(place, { lines, bands }, look, hooks) {
  return {
    ...sizeOf(place), series: lines, bands, hooks, legend: { show: false }, padding: [null, 24, null, null],
    // The axis along which the mouse went further is zoomed.
    cursor: { y: false, drag: { x: Boolean(look.zooms), y: Boolean(look.zooms), dist: 5, uni: Infinity }, points: { size: 6 } },
    scales: { x: { time: Boolean(look.ofClock), ...(look.spanOf ? { range: (_, first, last) => look.spanOf(first, last) } : {}) },
      y: { range: (_, low, high) => look.heightOf(low, high) } },
    axes: [axis(look.xLabel, { size: 32, space: look.tickSpace_px ?? 60,
      values: (_, times, __, ___, step) => look.ticks(times, step) }),
    axis(look.yLabel, { size: (_, texts) => widthOf(texts), values: (_, values, __, ___, step) => plainTicks(values, step) })],
  };
}

// A chart in two elements: a legend, and an area that has its height from style.css. Gives
//   renew(time_s, series)   other values of the same series, or others
//   pointAt(time_s)         as if the mouse were there, null: nowhere; onPoint is not told
//   zoomTo(range)           null: all; onZoom is not told
export function makePlot(legendPlace, place, look) {
  let chart = null, drawn = "", first = 0, legend = null, shown = [];
  place.setAttribute("role", "img");
  place.setAttribute("aria-label", look.label);  // until there are curves to name
  const whole = () => [chart.data[0][0], chart.data[0].at(-1)];
  function write() {
    const row = chart.cursor.idx ?? (look.restsAtEnd ? chart.data[0].length - 1 : -1);
    legend.moment.textContent = row < 0 ? "" : look.moment(chart.data[0][row]);
    legend.values.forEach((node, i) => {
      node.textContent = row < 0 ? "" : fixed(numberOf(chart.data[first + i][row]), 2);
    });
  }
  function onCursor() {
    if (!chart) return;
    write();
    look.onPoint?.(chart.cursor.idx ?? -1);
  }
  function onScale(_, key) {
    const { min, max } = chart.scales.x;
    if (key !== "x" || (min === shown[0] && max === shown[1])) return;
    shown = [min, max];
    look.onZoom?.(min <= whole()[0] && max >= whole()[1] ? null : shown);
  }
  function begin(series, columns) {
    chart?.destroy();
    chart = null;
    const lines = linesOf(series);
    first = lines.first;
    legend = addLegend(legendPlace, series);
    place.setAttribute("aria-label", `${look.label} over time: ${series.map(({ name }) => name).join(", ")}`);
    chart = new uPlot(optionsOf(place, lines, look, { setCursor: [onCursor], setScale: [onScale] }), columns, place);
    shown = whole();
  }
  new ResizeObserver(() => chart?.setSize(sizeOf(place))).observe(place);
  addEventListener("beforeprint", () => chart?.setSize(sizeOf(place, paper_px)));
  addEventListener("afterprint", () => chart?.setSize(sizeOf(place)));
  matchMedia("screen and (prefers-color-scheme: dark)").addEventListener("change", () => chart?.redraw());
  return {
    renew(time_s, series) {
      const columns = columnsOf(time_s, series);
      const key = JSON.stringify(series.map(one => [one.name, bandsOf(one).length]));
      if (key !== drawn) begin(series, columns);
      else chart.setData(columns);
      drawn = key;
      write();
    },
    pointAt(time_s) {
      const { min, max } = chart.scales.x;  // null without any value
      const isShown = time_s !== null && time_s >= (min ?? Infinity) && time_s <= max;
      chart.setCursor({ left: isShown ? chart.valToPos(time_s, "x") : -10, top: 0 }, false);
      write();
    },
    zoomTo(range) {
      shown = range ?? whole();
      chart.setScale("x", { min: shown[0], max: shown[1] });
    },
  };
}
