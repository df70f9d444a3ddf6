// Trying the control's input with known values. The daemon ends a trial by itself when this page does not say within a minute
// that somebody is still there; it says so only while the page is the one that began it.
import { byId, fixed, signed } from "./pages/elements.js";
import { goOn, heedSession, order } from "./commands.js";
import { hasBit } from "./words.js";
import { judgeInput } from "./judge_input.js";
import { keepNotes, notes } from "./notes.js";
import { setList, setText } from "./cells.js";

const renewEvery_ms = 15000, reached_um = 0.05, steps = [0, 1, -1, 0];
const verdictWords = { right: "Right.", wrong_sign: "Wrong sign.", wrong_unit: "Wrong unit.", wrong_scale: "Wrong scale.",
  not_read: "Not read.", sticks: "Sticks, or has play.", incomplete: "Not all readings yet." };
const rows = [...document.querySelectorAll("#trial tbody tr")];
const gauges = [...document.querySelectorAll("#trial input")];
let settings = { sign: 1, limit_um: null, slew_um_per_s: null, step_um: 0 }, renewed_ms = 0, isThere = false, register_um = null;

const trialSize_um = () => Number(byId("trial-um").value) || 10;
const readTo_um = () => Number(byId("gauge-um").value) || 1;
const numberOrNull = text => text.trim() === "" || !Number.isFinite(Number(text)) ? null : Number(text);

// {verdict, text, change, gain} of what was entered so far.
export function trialVerdict() {
  const { value_um, gauge_um, ordered_um } = notes.trial;
  const tried = gauge_um.map((gauge, i) => ({ value_um: value_um[i] ?? ordered_um[i], gauge_um: gauge }));
  const { verdict, ...rest } = judgeInput(tried, settings.sign, readTo_um());
  return { verdict, title: verdictWords[verdict], ...rest };
}

export const signText = () => settings.sign > 0
  ? "Right is, with compensation.sign = +1 as it is: a value of + takes the nose away from the table by as much."
  : "Right is, with compensation.sign = −1 as it is: a value of + brings the nose nearer to the table by as much.";

// What may keep a control from following, in words.
function obstacles(words, registers) {
  const said = [];
  const state = registers.state.name, bits = registers.compensation_bits.value;
  if (!["running", "degraded"].includes(state) || registers.compensation_rung.value === 0) {
    said.push(`A control that keeps to the rules does not use the value now: the daemon's state is ${state}.`);
  }
  if (!hasBit(words, "compensation_bits", bits, "enabled")) {
    said.push("The compensation is switched off: behind the trial the value goes to 0 and stays there.");
  }
  if (settings.limit_um !== null && trialSize_um() > settings.limit_um) {
    said.push(`The daemon refuses more than compensation.limit_um, ${fixed(settings.limit_um, 1)} µm.`);
  }
  return said;
}

function progressText(isTried, left_s) {
  const { ordered_um, step, isMine } = notes.trial;
  if (!isTried) return "No trial: the register shows the prediction.";
  if (left_s === 0) return "The trial has ended, the value goes back to the prediction.";
  if (!isMine || step === null) return "Somebody else is trying a value, or another tab is.";
  const wanted = `${signed(ordered_um[step], 1)} µm`, keeps = "This page keeps the value, ten minutes at the most.";
  return isThere ? `There: read the gauge for ${wanted} and enter it. ${keeps}` : `On its way to ${wanted}. ${keeps}`;
}

// The bit alone would be that of the value before, until the daemon has the order.
function isReached(registers) {
  const { ordered_um, step } = notes.trial;
  return step !== null && Math.abs(registers.compensation.value - ordered_um[step]) <= reached_um + settings.step_um;
}

async function renewTrial(isTried) {
  if (!notes.trial.isMine || !isTried || Date.now() - renewed_ms < renewEvery_ms) return;
  renewed_ms = Date.now();
  try {
    await goOn({ command: "trial", value: "go_on" });
  } catch (error) {
    if (error.status) notes.trial.isMine = false;  // another session has it, or this one has ended
  }
}

function showVerdict() {
  const { title, text, change } = trialVerdict();
  setText(byId("verdict"), title);
  setText(byId("verdict-text"), text);
  setText(byId("verdict-change"), change);
}

function showRows() {
  const { value_um, step } = notes.trial;
  rows.forEach((row, i) => {
    const isNow = step === i && register_um !== null;
    setText(row.cells[2], isNow ? signed(register_um, 2) : value_um[i] === null ? "" : signed(value_um[i], 2));
    row.classList.toggle("now", isNow);
  });
  setText(rows[1].querySelector("button"), `Go to +${fixed(trialSize_um(), 1)} µm`);
  setText(rows[2].querySelector("button"), `Go to −${fixed(trialSize_um(), 1)} µm`);
}

export function showTrial(words, registers) {
  const bits = registers.compensation_bits.value, left_s = registers.compensation_trial_left.value;
  const isTried = hasBit(words, "compensation_bits", bits, "trial");
  const isHeld = isTried && left_s > 0;
  isThere = isHeld && notes.trial.isMine && !hasBit(words, "compensation_bits", bits, "moving") && isReached(registers);
  register_um = isHeld && notes.trial.isMine ? registers.compensation.value : null;
  if (!isHeld && notes.trial.isMine && Date.now() - renewed_ms > renewEvery_ms) notes.trial.step = null;
  renewTrial(isHeld);
  setText(byId("trial-said"), progressText(isTried, left_s));
  setList(byId("trial-notes"), obstacles(words, registers));
  showRows();
  showVerdict();
}

export function beginTrial({ compensation }) {
  settings = compensation;
  setText(byId("trial-slew"), `, ${settings.slew_um_per_s} µm/s of model time`);
  setText(byId("trial-sign"), signText());
  gauges.forEach((input, i) => {
    input.value = notes.trial.gauge_um[i] ?? "";
  });
  showVerdict();
}

function go(step) {
  const um = steps[step] * trialSize_um();
  Object.assign(notes.trial, { step, isMine: true });
  notes.trial.ordered_um[step] = um;
  notes.trial.value_um[step] = notes.trial.gauge_um[step] = null;
  gauges[step].value = "";
  renewed_ms = Date.now();
  isThere = false;
  setText(byId("trial-said"), `On its way to ${signed(um, 1)} µm.`);
  keepNotes();
  order({ command: "trial", um }, `trial of ${signed(um, 1)} µm`);
}

byId("trial").addEventListener("click", ({ target }) => {
  if (target.tagName === "BUTTON") go(Number(target.dataset.step));
});
byId("trial").addEventListener("input", ({ target }) => {
  const i = Number(target.dataset.step);
  notes.trial.gauge_um[i] = numberOrNull(target.value);
  // What the register had when the gauge was read.
  if (notes.trial.step === i && isThere) notes.trial.value_um[i] = register_um;
  keepNotes();
  showVerdict();
});
byId("trial-end").addEventListener("click", () => {
  Object.assign(notes.trial, { step: null, isMine: false });
  keepNotes();
  order({ command: "trial", value: "end" }, "end of the trial");
});
byId("trial-anew").addEventListener("click", () => {
  const none = () => [null, null, null, null];
  Object.assign(notes.trial, { ordered_um: none(), value_um: none(), gauge_um: none() });
  for (const input of gauges) input.value = "";
  keepNotes();
  showVerdict();
});
byId("gauge-um").addEventListener("input", showVerdict);
heedSession(({ user }) => {
  if (user === null) Object.assign(notes.trial, { step: null, isMine: false });
});
