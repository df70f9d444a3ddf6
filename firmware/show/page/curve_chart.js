// Curves over the time of day.
import { makePlot } from "./pages/chart.js";

const clock = time_s => new Date(1000 * time_s).toLocaleTimeString("en-GB");
const minute = time_s => clock(time_s).slice(0, 5);
const day = time_s => new Date(1000 * time_s).toLocaleDateString("en-GB", { weekday: "short", day: "numeric" });
// Of days a tick at midnight is the day's.
const tickOf = time_s => minute(time_s) === "00:00" ? day(time_s) : minute(time_s);
const shortest_s = 60;

// Of the values' scale: one flat curve does not fill the height with its noise.
function heightOf(low, high) {
  const middle = (low + high) / 2;
  const half = Math.max(0.5, 0.55 * (high - low));
  return [middle - half, middle + half];
}

// A chart in two elements; gives renew(time_s, series, range): other values of the same series, or another chart. With a
// range, [from, to], the chart goes over that, of hours or days; without, over the times that there are.
export function makeChart(legendPlace, place, label) {
  let asked = null;
  const plot = makePlot(legendPlace, place, {
    label, heightOf, ofClock: true, restsAtEnd: true, tickSpace_px: 90,
    moment: time_s => asked ? `${day(time_s)} ${minute(time_s)}` : clock(time_s),
    ticks: times => times.map(asked ? tickOf : clock),
    spanOf: (first, last) => asked ?? [Math.min(first, last - shortest_s), last],
  });
  return (time_s, series, range = null) => {
    asked = range;
    plot.renew(time_s, series.map(one => ({ width: range ? 1.25 : 2, ...one })));
  };
}
