// Commands behind a login: the card is there only where the configuration has them. The session is a cookie that no script
// sees; what became of an order is read from the registers, as a PLC reads it.
import { byId, element } from "./pages/elements.js";
import { meaning, plain } from "./words.js";
import { setList, setText } from "./cells.js";

const sessionPeriod_ms = 10000, mostShown = 8;
let commandFolder = "api/v1", isLoggedIn = false, sessionAsked = 0;
const ordered = [];  // newest first: {id, said, result}
const heedSessions = [], heedOrders = [];

const say = text => setText(byId("command-said"), text);

// told({commands, user}) whenever the daemon has said so; given({body, said, id}) for each order that it has taken.
export const heedSession = told => heedSessions.push(told);
export const heedOrder = given => heedOrders.push(given);

async function post(path, body) {
  const answer = await fetch(path, { method: "POST", cache: "no-store", body: JSON.stringify(body),
    headers: { "Content-Type": "application/json", "X-Spindle-Twin": "command" } });
  const told = await answer.json();
  if (!answer.ok) throw Object.assign(new Error(told.error), { status: answer.status });
  return told;
}

function showSession({ commands, user }) {
  const wasLoggedIn = isLoggedIn;
  isLoggedIn = user !== null;
  byId("commands").hidden = !commands;
  byId("login").hidden = isLoggedIn;
  byId("orders").hidden = !isLoggedIn;
  setText(byId("user-name"), user ?? "");
  setText(byId("may-change"), commands ? "Changed is something only by who logs in." : "Nothing can be changed here.");
  if (wasLoggedIn && !isLoggedIn) say("Logged out: the session has ended.");
  for (const told of heedSessions) told({ commands, user });
}

async function askSession() {
  if (Date.now() - sessionAsked < sessionPeriod_ms) return;
  sessionAsked = Date.now();
  try {
    const answer = await fetch("api/v1/session", { cache: "no-store" });
    showSession(await answer.json());
  } catch {
    sessionAsked = 0;  // the daemon is silent: the page says so elsewhere
  }
}

export const renewSession = () => askSession();

async function attempt(doing) {
  try {
    await doing();
  } catch (error) {
    if (error.status === 401 && isLoggedIn) showSession({ commands: true, user: null });
    say(`Refused: ${error.message}`);
  }
}

// A refused or waiting order says why in the register map's own words.
function resultText(words, { said, result }) {
  if (result === null) return `${said}: handed over`;
  return `${said}: ${plain(result)} (${meaning(words, "order_result", result)})`;
}

// The same without a word of it: that a trial goes on.
export const goOn = body => post(`${commandFolder}/command`, body);

export const order = (body, said) => attempt(async () => {
  const { order_id: id } = await goOn(body);
  for (const given of heedOrders) given({ body, said, id });
  ordered.unshift({ id, said, result: null });
  ordered.length = Math.min(ordered.length, mostShown);
  say(`Ordered: ${said}.`);
});

export function showOrders(words, registers) {
  for (const each of ordered) {
    const at = registers.order_id.values.indexOf(each.id);
    if (at >= 0) each.result = registers.order_result.names[at];
  }
  setList(byId("ordered"), ordered.map(each => resultText(words, each)));
}

// Of the spindle that is chosen; `outputs`: names of its deformations, whose lengths can be measured.
export function beginCommands(folder, outputs) {
  commandFolder = folder;
  const select = byId("length-output");
  if ([...select.options].map(each => each.value).join() === outputs.join()) return;
  select.replaceChildren();
  for (const name of outputs) element("option", { value: name }, select, name);
  byId("length").hidden = outputs.length === 0;
}

byId("login").addEventListener("submit", event => {
  event.preventDefault();
  attempt(async () => {
    const told = await post("api/v1/login", { user: byId("user").value, password: byId("password").value });
    byId("password").value = "";
    say("");
    showSession(told);
  });
});
byId("logout").addEventListener("click", () => attempt(async () => {
  showSession(await post("api/v1/logout", {}));
}));
byId("orders").addEventListener("click", ({ target }) => {
  const { command, value } = target.dataset;
  if (command) order({ command, ...value && { value } }, target.textContent);
});
byId("length").addEventListener("submit", event => {
  event.preventDefault();
  const um = Number(byId("length-um").value), sd_um = Number(byId("length-sd").value);
  const output = byId("length-output").value;
  order({ command: "length", um, sd_um, output }, `touch-off of ${output}, ${um} µm`);
});
