// Charts over the seconds of a run or a test: those of one group zoom together and point at the same moment.
import { makePlot, plainTicks } from "./pages/chart.js";
import { fixed } from "./pages/elements.js";

const charts = [];
const listeners = [];

// Of the values' scale: all of them, with a margin where the chart does not begin at zero.
function heightOf(low, high, from_zero) {
  const [least, most] = from_zero ? [Math.min(0, low), Math.max(0, high)] : [low, high];
  const margin = 0.06 * (most - least) || Math.max(0.01 * Math.abs(most), 1e-3);
  return [from_zero && least === 0 ? 0 : least - margin, from_zero && most === 0 ? 0 : most + margin];
}

// Draws into two elements, a legend and an area: `label` (what the values are, with unit), `time_s`, `series` as
// pages/chart.js has them, `range` (of the values; else all of them), `from_zero`, `joined` (across what was not read),
// `group` (of charts; else all of the page are one).
export function drawChart(legend, area, { label, time_s, series, range, from_zero, joined, group }) {
  const own = { group };
  const others = () => charts.filter(other => other !== own && other.group === group);
  own.plot = makePlot(legend, area, {
    label, yLabel: label, xLabel: "time, s", ticks: plainTicks, zooms: true,
    moment: moment_s => `${fixed(moment_s, 0)} s`,
    heightOf: (low, high) => range ?? heightOf(low, high, from_zero),
    onZoom: times => others().forEach(({ plot }) => plot.zoomTo(times)),
    onPoint: row => {
      others().forEach(({ plot }) => plot.pointAt(row < 0 ? null : time_s[row]));
      if (row >= 0) listeners.forEach(tell => tell(row));
    },
  });
  charts.push(own);
  own.plot.renew(time_s, series.map(one => ({ joined, ...one })));
}

// `tell(row)`: a moment of the charts is pointed at.
export const onMoment = tell => listeners.push(tell);
