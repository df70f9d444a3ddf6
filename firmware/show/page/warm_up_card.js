// The first warm-up, as this page sees it: a sample each two seconds, each four once there are many, and so on, so that a day
// of it stays small. A silence of the daemon, or of a phone that sleeps, is a gap.
import { byId, duration } from "./pages/elements.js";
import { drawLines } from "./line_chart.js";
import { heedOrder } from "./commands.js";
import { keepNotes, notes } from "./notes.js";
import { setText } from "./cells.js";

const first_s = 2, mostSamples = 900, gapPeriods = 4;
const now_s = () => Date.now() / 1000;
const rounded = (value, digits) => value === null || value === undefined ? null : Number(value.toFixed(digits));

function sampleNow(registers) {
  const measured = Object.entries(registers.key_point_measured_float32.values);
  return { time_s: rounded(now_s() - notes.warmUp.begun_s, 1), nose: rounded(registers.nose_float32.value, 2),
    compensation: rounded(registers.compensation.value, 2),
    points: Object.fromEntries(measured.map(([name, value]) => [name, rounded(value, 3)])) };
}

function gapBetween(last, sample) {
  return { time_s: rounded((last.time_s + sample.time_s) / 2, 1), nose: null, compensation: null, points: {} };
}

function addSample(registers) {
  const warm = notes.warmUp, last = warm.samples.at(-1), sample = sampleNow(registers);
  if (last && sample.time_s - last.time_s < warm.every_s - 0.2) return;
  if (last && sample.time_s - last.time_s > gapPeriods * warm.every_s) warm.samples.push(gapBetween(last, sample));
  warm.samples.push(sample);
  if (warm.samples.length > mostSamples) {
    warm.samples = warm.samples.filter((each, i) => i % 2 === 0 || each.nose === null);
    warm.every_s *= 2;
  }
  keepNotes();
  drawWarmUp(byId("warm-growth"), byId("warm-points"));
}

// Both charts, on the page or in a report.
export function drawWarmUp(growth, points) {
  const { samples, lengths } = notes.warmUp;
  const time_s = samples.map(sample => sample.time_s);
  const marks = lengths.map(({ time_s: at_s, um }) => ({ time_s: at_s, value: um }));
  drawLines(growth, "Growth and compensation, µm over time", time_s, [
    { name: "growth", values: samples.map(sample => sample.nose) },
    { name: "compensation", dashed: true, values: samples.map(sample => sample.compensation) }], marks);
  const names = [...new Set(samples.flatMap(sample => Object.keys(sample.points)))]
    .filter(name => samples.some(sample => typeof sample.points[name] === "number"));
  drawLines(points, "Measured at the key points, °C over time", time_s,
    names.map(name => ({ name, values: samples.map(sample => sample.points[name] ?? null) })));
}

export function warmUpText() {
  const { begun_s, ended_s, samples, lengths } = notes.warmUp;
  if (begun_s === null) return "Nothing is recorded yet.";
  const since = new Date(1000 * begun_s).toLocaleString("en-GB");
  const lasts = duration((ended_s ?? now_s()) - begun_s);
  return `${ended_s === null ? "Recording since" : "Recorded from"} ${since}, ${lasts}: ${samples.length} samples, ` +
    `${lengths.length} touch-offs.`;
}

const isRecording = () => notes.warmUp.begun_s !== null && notes.warmUp.ended_s === null;

export function showWarmUp(registers) {
  if (isRecording()) addSample(registers);
  byId("warm-begin").disabled = isRecording();
  byId("warm-end").disabled = !isRecording();
  setText(byId("warm-said"), warmUpText());
}

export const beginWarmUp = () => drawWarmUp(byId("warm-growth"), byId("warm-points"));

byId("warm-begin").addEventListener("click", () => {
  notes.warmUp = { begun_s: now_s(), ended_s: null, every_s: first_s, samples: [], lengths: [] };
  keepNotes();
  beginWarmUp();
});
byId("warm-end").addEventListener("click", () => {
  notes.warmUp.ended_s = now_s();
  keepNotes();
});
heedOrder(({ body, id }) => {
  if (body.command !== "length" || !isRecording()) return;
  const { um, sd_um, output } = body;
  notes.warmUp.lengths.push({ time_s: rounded(now_s() - notes.warmUp.begun_s, 1), um, sd_um, output, id });
  keepNotes();
});
