// Does it help? What the compensation leaves of the growth at the touch-offs in the history, in a sentence and by weeks.
import { byId, element, fixed, svgElement } from "./pages/elements.js";
import { setTable, setText } from "./cells.js";

const growthAgain_ms = 60000, growthGoOn_ms = 1000, growthPatience_ms = 90000;
const leastTouchOffs = 3;  // of touch-offs that can be compared
const benefitWide = 160, benefitTall = 16;
let growthPath = null, growthDue_ms = 0, growthIsAsked = false;

const dayOf = (unix_s, more = {}) =>
  new Date(1000 * unix_s).toLocaleDateString("en-GB", { day: "numeric", month: "short", ...more });
const weekOf = unix_s => dayOf(unix_s, { year: "numeric", timeZone: "UTC" });
const leaves = judged => `${fixed(judged.left_rms_um, 1)} µm of ${fixed(judged.growth_rms_um, 1)} µm`;
const isWorse = judged => judged.verdict === "makes it worse";

// Why it may be so, from how many times the published growth was measured.
function likely(times) {
  if (times !== null && times < -0.25) {
    return `${fixed(times, 1)} times the published growth was measured: likely a wrong sign, in the control ` +
      "(what it hands over, or adds to its axis) or in compensation.sign.";
  }
  if (times !== null && times < 0.5) {
    return `Only ${fixed(times, 1)} times the published growth was measured: check the unit of what the control hands over, ` +
      "and the network.";
  }
  return "Check sign and unit in the control, and the network.";
}

// The whole decides; a last week that is worse is said beside it.
function verdictOf(output) {
  const { whole, weeks } = output;
  const since = `Since ${dayOf(output.from_unix_s ?? 0)}`;
  const last = weeks.at(-1);
  const lastly = last && isWorse(last)
    ? ` In the week from ${weekOf(last.from_unix_s)} it has made the growth worse: it has left ${leaves(last)}.` : "";
  switch (whole.verdict) {
    case "helps": return `${since} the compensation has left ${leaves(whole)}.${lastly}`;
    case "makes it worse":
      return `The compensation makes the growth worse: ${since.replace("S", "s")} it has left ${leaves(whole)}. ` +
        likely(output.measured_times);
    case "cannot be told":
      return `${since} the compensation has left ${leaves(whole)}: too near to each other to say whether it helps.${lastly}`;
    default:
      return `Too few touch-offs to say: of ${output.touch_offs}, ${whole.readings} can be compared with an earlier ` +
        `one since the last start or tare; ${leastTouchOffs} are needed.`;
  }
}

// What was there in pale, what is left of it within; both against the largest of all weeks.
function setBars(cell, judged, most_um) {
  const svg = cell.querySelector("svg") ??
    svgElement("svg", { class: "benefit", viewBox: `0 0 ${benefitWide} ${benefitTall}`, "aria-hidden": "true" }, cell);
  const wide = um => benefitWide * um / Math.max(most_um, 1e-9);
  const bars = [[judged.growth_rms_um, 0, benefitTall, "pale"],
    [judged.left_rms_um, 4, benefitTall - 8, isWorse(judged) ? "less" : "bar"]];
  bars.forEach(([um, y, tall, ink], i) => {
    const bar = svg.children[i] ?? svgElement("rect", { rx: 2 }, svg);
    const shape = { y, height: tall, width: wide(um), fill: `var(--${ink})` };
    for (const [name, value] of Object.entries(shape)) bar.setAttribute(name, value);
  });
}

const benefitHeads = ["week from", "touch-offs", "growth", "worst", "left", "worst left", "left of growth", "the compensation"];

function weekRow(name, judged, most_um) {
  const um = value => fixed(value, 1);
  return [name, String(judged.readings), um(judged.growth_rms_um), um(judged.growth_worst_um), um(judged.left_rms_um),
    um(judged.left_worst_um), cell => setBars(cell, judged, most_um), judged.verdict];
}

function outputPlace(output, isOnly) {
  const known = [...byId("benefit-outputs").children].find(each => each.dataset.output === output.output);
  if (known) return known;
  const place = element("div", { "data-output": output.output }, byId("benefit-outputs"));
  element("h3", {}, place, output.output).hidden = isOnly;
  element("p", { class: "verdict" }, place);
  element("p", { class: "how" }, place);
  element("table", { class: "stacks" }, place);
  return place;
}

const howText = "µm; growth: rms of the touch-offs against the first one after each start, gap or tare; left: the same of " +
  "measured minus published. Weeks begin on Monday, UTC.";

function showOutput(output, isOnly) {
  const place = outputPlace(output, isOnly);
  const { whole, weeks } = output;
  const verdict = place.querySelector(".verdict");
  setText(verdict, verdictOf(output));
  verdict.classList.toggle("worse", isWorse(whole) || (weeks.length > 0 && isWorse(weeks.at(-1))));
  const isTold = whole.readings > 0;
  const table = place.querySelector("table");
  table.hidden = !isTold;
  setText(place.querySelector(".how"), isTold ? howText : "");
  if (!isTold) return;
  const most_um = Math.max(...[whole, ...weeks].flatMap(each => [each.growth_rms_um, each.left_rms_um]));
  const rows = [...weeks].reverse().map(week => weekRow(weekOf(week.from_unix_s), week, most_um));
  setTable(table, benefitHeads, [...rows, weekRow("all", whole, most_um)], true);
}

async function askGrowth(wanted) {
  const answer = await fetch(wanted, { cache: "no-store", signal: AbortSignal.timeout(growthPatience_ms) });
  const content = await answer.json();
  if (!answer.ok) throw new Error(content.error);
  return content;
}

async function askAndShowGrowth() {
  const wanted = growthPath;
  growthIsAsked = true;
  growthDue_ms = Date.now() + growthAgain_ms;
  try {
    const { is_whole, outputs } = await askGrowth(wanted);
    if (wanted === growthPath) {
      if (!is_whole) growthDue_ms = Date.now() + growthGoOn_ms;
      setText(byId("benefit-said"), is_whole ? "" : "What is older is still being searched for touch-offs.");
      // Of outputs that nobody has measured the first one says so for all.
      const shown = outputs.filter((output, i) => i === 0 || output.touch_offs > 0);
      for (const output of shown) showOutput(output, shown.length === 1);
    }
  } catch (error) {
    const reason = error.name === "TimeoutError" ? "it did not come in time" : error.message;
    if (wanted === growthPath) setText(byId("benefit-said"), `The history cannot be read: ${reason}`);
  }
  growthIsAsked = false;
}

// To be called each second: asks where it is time.
export function renewBenefit() {
  if (growthPath !== null && !growthIsAsked && !document.hidden && Date.now() >= growthDue_ms) askAndShowGrowth();
}

// Of another spindle, at this path; null: it keeps no history that can be asked, or does not grow.
export function beginBenefit(wanted) {
  growthPath = wanted;
  growthDue_ms = 0;
  byId("benefit").hidden = growthPath === null;
  byId("benefit-outputs").replaceChildren();
  setText(byId("benefit-said"), "The history is being searched for touch-offs.");
  renewBenefit();
}
