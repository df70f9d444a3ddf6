// Asks the daemon once a second for the state of the spindle that is chosen, and says on the page when nobody answers.
import { byId, element } from "./pages/elements.js";
import { setText } from "./cells.js";

const period_ms = 1000, patience_ms = 3000;
let words = null, isMet = false, since = null, version = null;

async function ask(path) {
  const answer = await fetch(path, { cache: "no-store", signal: AbortSignal.timeout(patience_ms) });
  if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
  return answer.json();
}

const chosen = () => byId("spindle").value;
const folder = () => chosen() ? `api/v1/spindles/${encodeURIComponent(chosen())}` : "api/v1";

// Names and meanings; again after a silence, as another daemon may have started.
async function begin() {
  const { spindles } = await ask("api/v1/spindles");
  words = await ask("api/v1/words");
  const select = byId("spindle");
  const before = select.value || decodeURIComponent(location.hash.slice(1));
  select.replaceChildren();
  for (const { name, spindle } of spindles) element("option", { value: name }, select, name ? `${name}: ${spindle}` : spindle);
  if (spindles.some(({ name }) => name === before)) select.value = before;
  byId("choice").hidden = spindles.length < 2;
}

// What does not change of the chosen spindle; again where another was chosen meanwhile.
async function meetSpindle(meet) {
  const spindle = chosen();
  const scene = await ask(`${folder()}/scene`);
  if (spindle !== chosen()) return;
  isMet = true;
  meet(scene, folder(), spindle);
  setText(byId("notice"), scene.notice);
  byId("notice").hidden = scene.notice === "";
}

function showSilence(error) {
  since ??= new Date();
  words = null;
  document.body.classList.add("old");
  byId("silence").hidden = false;
  setText(byId("silence"), `No answer from the daemon since ${since.toLocaleTimeString("en-GB")}: what stands below is old. ` +
    (error.name === "TimeoutError" ? "It did not answer in time." : ""));
}

function endSilence() {
  since = null;
  document.body.classList.remove("old");
  byId("silence").hidden = true;
}

// The state of the chosen spindle; null, and said so, where nobody answers.
async function answered(meet) {
  try {
    if (words === null) await begin();
    if (!isMet) await meetSpindle(meet);
    const state = await ask(`${folder()}/state`);
    endSilence();
    return state;
  } catch (error) {
    showSilence(error);
    return null;
  }
}

// meet(scene, folder, name): a spindle was chosen; leave(): another one will be; show(words, state): each second.
export function follow({ meet, leave, show }) {
  async function renew() {
    const spindle = chosen();
    const state = await answered(meet);
    setTimeout(renew, period_ms);
    if (state === null || (chosen() !== spindle && spindle !== "")) return;
    // Another daemon: its page may be another too.
    version ??= state.version;
    if (version !== state.version) location.reload();
    if (isMet) show(words, state);
  }
  byId("spindle").addEventListener("change", () => {
    location.hash = encodeURIComponent(chosen());
    isMet = false;
    leave();
  });
  renew();
}
