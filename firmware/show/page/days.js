// Hours and days of the chosen spindle, from the history on the daemon's disk; where it keeps one that can be asked.
import { byId } from "./pages/elements.js";
import { makeChart } from "./curve_chart.js";
import { setText } from "./cells.js";

const again_ms = 60000, goOn_ms = 1000, daysPatience_ms = 90000;
const drawDays = makeChart(byId("days-growth-legend"), byId("days-growth-curves"), "nose growth in the past, µm");
const drawDaysPoint = makeChart(byId("days-point-legend"), byId("days-point-curves"), "temperature in the past, °C");
const choices = [...document.querySelectorAll("#days-choices button")];
let daysPath = null, hours = 8, due_ms = 0, isAsked = false, days = null;

const lasting = seconds => seconds < 120 ? `${seconds} s` : `${Math.round(seconds / 6) / 10} min`;

// The mean of each span, with the band of what was lowest and highest in it.
const curve = (name, ink, column, more = {}) =>
  ({ name, ink, values: column.mean, low: column.min, high: column.max, ...more });

function growthOfDays(columns) {
  const sd = Object.keys(columns).find(name => name.startsWith("deformation_sd."));
  const growth = columns.nose_um;
  return [
    curve("growth", "twin", growth, { sd: columns[sd].mean }),
    { name: "without correction", ink: "reading", dashed: true, values: columns.nose_uncorrected_um.mean },
  ];
}

const pointOfDays = (columns, point) => [
  curve("predicted", "twin", columns[`predicted.${point}_degC`], { sd: columns[`predicted_sd.${point}_K`].mean }),
  curve("measured", "raw", columns[`measured.${point}_degC`], { dashed: true }),
];

function drawBoth() {
  if (days === null || !days.unix_s.length) return;
  const { columns, unix_s, asked_s } = days;
  const range = [asked_s - 3600 * days.hours, asked_s];
  byId("days-growth").hidden = columns.nose_um === undefined;
  if (columns.nose_um) drawDays(unix_s, growthOfDays(columns), range);
  const point = byId("point").value;
  if (columns[`predicted.${point}_degC`] === undefined) return;
  setText(byId("days-point-title"), `Temperature at ${point}, °C`);
  drawDaysPoint(unix_s, pointOfDays(columns, point), range);
}

function sayDays() {
  const some = days.unix_s.length ? "" : "Nothing was written in this time. ";
  setText(byId("days-said"), some + (days.is_whole ? "" : "What is older is still being read."));
  setText(byId("days-span"), `A point is the mean of ${lasting(days.span_s)}; the darker band goes from the lowest to the ` +
    "highest value, the lighter one is ±2σ.");
  byId("days-charts").hidden = !days.unix_s.length;
}

async function askDays(path) {
  const answer = await fetch(path, { cache: "no-store", signal: AbortSignal.timeout(daysPatience_ms) });
  const content = await answer.json();
  if (!answer.ok) throw new Error(content.error);
  return content;
}

// Shows what comes, if that is still what is wanted then.
async function askAndShow() {
  const wanted = `${daysPath}/${hours}`;
  isAsked = true;
  due_ms = Date.now() + again_ms;
  let found = null, reason = "";
  try {
    found = { ...await askDays(wanted), asked_s: Date.now() / 1000 };
  } catch (error) {
    reason = error.name === "TimeoutError" ? "it did not come in time" : error.message;
  }
  isAsked = false;
  if (wanted !== `${daysPath}/${hours}`) return;
  if (found === null) {
    setText(byId("days-said"), `The history cannot be read: ${reason}`);
    return;
  }
  days = found;
  if (!days.is_whole) due_ms = Date.now() + goOn_ms;
  sayDays();
  drawBoth();
}

// To be called each second: asks where it is time.
export function renewDays() {
  if (daysPath !== null && !isAsked && !document.hidden && Date.now() >= due_ms) askAndShow();
}

function choose(wanted) {
  hours = wanted;
  due_ms = 0;
  days = null;
  for (const button of choices) button.setAttribute("aria-pressed", String(Number(button.dataset.hours) === hours));
  setText(byId("days-said"), "The history is being read.");
  renewDays();
}

// Of another spindle, at this path; null: it keeps no history that can be asked.
export function beginDays(path) {
  daysPath = path;
  byId("days").hidden = path === null;
  byId("days-charts").hidden = true;
  choose(hours);
}

for (const button of choices) button.addEventListener("click", () => choose(Number(button.dataset.hours)));
byId("point").addEventListener("change", drawBoth);
