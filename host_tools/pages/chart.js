// Curves over time. The only file that knows the chart library (dygraphs, a global of its own script).
//
// A chart: `label` (what the values are, with unit), `time_s`, `series` ({name, values, ink, width, dashed, steps, sd}),
// `range` (of the values; else all of them), `from_zero`, `joined` (across what was not read). `ink` names a colour of
// style.css; with `sd` a band of ±2σ is drawn.
// All charts of a page share one axis of time: they zoom together and point at the same moment.
import { element, fixed } from "./pages/elements.js";

const charts = [];
const listeners = [];
let shared = false;  // a change that goes on to the other charts

const ink = name => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const coloursOf = series => series.map(s => ink(s.ink));

function shareWithOthers(chart, act) {
  if (shared) return;
  shared = true;
  for (const other of charts) if (other !== chart) act(other);
  shared = false;
}

// A legend with room for the value of each curve, as `drawn(row, curve)` has it; gives write(row), row -1: none.
function addLegend(place, chart, drawn) {
  const moment = element("b", {}, place);
  const values = chart.series.map(series => {
    const entry = element("span", { "data-series": series.name }, place);
    const line = element("i", series.dashed ? { class: "dashed" } : {}, entry);
    line.style.borderTopColor = `var(--${series.ink})`;
    entry.append(`${series.name} `);
    return element("b", {}, entry);
  });
  return row => {
    moment.textContent = row < 0 ? "" : `${fixed(chart.time_s[row], 0)} s`;
    chart.series.forEach((_, i) => {
      const value = row < 0 ? null : drawn(row, i);
      values[i].textContent = value === null ? "" : fixed(value, 2);
    });
  };
}

// Rows as dygraphs takes them: with bands every value is [low, value, high].
function rowsOf(chart, banded) {
  const cell = (series, row) => {
    const value = series.values[row] ?? null;
    if (!banded) return value;
    const half = value !== null && series.sd?.[row] ? 2 * series.sd[row] : 0;
    return value === null ? [null, null, null] : [value - half, value, value + half];
  };
  return chart.time_s.map((time, row) => [time, ...chart.series.map(series => cell(series, row))]);
}

// Mouse only: with the library's own touch handling a page of charts could not be scrolled by a finger.
const mouseOnly = () =>
  Object.fromEntries(Object.entries(Dygraph.defaultInteractionModel).filter(([event]) => !event.startsWith("touch")));

function optionsOf(chart, banded) {
  return {
    labels: ["time", ...chart.series.map(s => s.name)],
    colors: coloursOf(chart.series),
    series: Object.fromEntries(chart.series.map(s => [s.name,
      { strokeWidth: s.width ?? 2, strokePattern: s.dashed ? [7, 4] : null, stepPlot: s.steps ?? false }])),
    legend: "never",
    xlabel: "model time, s",
    ylabel: chart.label,
    gridLineColor: ink("grid"),
    axisLineColor: ink("soft"),
    highlightCircleSize: 3,
    labelsKMB: false,
    connectSeparatedPoints: chart.joined ?? false,
    axes: { x: { axisLabelFormatter: t => t.toFixed(0), pixelsPerLabel: 60 }, y: { axisLabelWidth: 44 } },
    interactionModel: mouseOnly(),
    ...(chart.range ? { valueRange: chart.range } : {}),
    includeZero: chart.from_zero ?? false,
    ...(banded ? { customBars: true, fillAlpha: 0.18 } : {}),
  };
}

// Draws into two elements: a legend and an area that has its height from style.css.
export function drawChart(legend, area, chart) {
  const banded = chart.series.some(series => series.sd?.length);
  const rows = rowsOf(chart, banded);
  const write = addLegend(legend, chart, (row, curve) => [rows[row][curve + 1]].flat().at(banded ? 1 : 0));
  write(-1);
  area.setAttribute("role", "img");
  area.setAttribute("aria-label", `${chart.label} over time: ${chart.series.map(s => s.name).join(", ")}`);
  const own = { chart, write };
  own.graph = new Dygraph(area, rows, {
    ...optionsOf(chart, banded),
    highlightCallback: (event, time, points, row) => {
      write(row);
      shareWithOthers(own, other => {
        other.graph.setSelection(row);
        other.write(row);
      });
      for (const tell of listeners) tell(row);
    },
    unhighlightCallback: () => {
      write(-1);
      shareWithOthers(own, other => {
        other.graph.clearSelection();
        other.write(-1);
      });
    },
    drawCallback: (graph, first) => {
      if (first) return;
      shareWithOthers(own, other => other.graph.updateOptions({ dateWindow: graph.xAxisRange() }));
    },
  });
  charts.push(own);
}

// `tell(row)`: a moment of the charts is pointed at.
export const onMoment = tell => listeners.push(tell);

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  shareWithOthers(null, ({ chart, graph }) =>
    graph.updateOptions({ colors: coloursOf(chart.series), gridLineColor: ink("grid"), axisLineColor: ink("soft") }));
});
