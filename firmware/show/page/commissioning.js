// The page of commissioning: sensors, the control's input, the first warm-up, a report.
import { beginCommands, heedSession, renewSession, showOrders } from "./commands.js";
import { beginTrial, showTrial } from "./trial_card.js";
import { beginWarmUp, showWarmUp } from "./warm_up_card.js";
import { byId } from "./pages/elements.js";
import { follow } from "./follow_daemon.js";
import { meaning } from "./words.js";
import { openNotes } from "./notes.js";
import { saveReport } from "./report.js";
import { setText } from "./cells.js";
import { showSensors } from "./sensors_card.js";

const said = { words: null, scene: null, state: null, user: null };

function showHead(words, state) {
  const { name } = state.registers.state;
  setText(byId("title"), state.spindle);
  setText(byId("state"), `${name}: ${meaning(words, "state", name)}`);
  setText(byId("moment"), `cycle ${state.registers.sequence.value}`);
  setText(byId("about"), `spindle-twind ${state.version}, register map ${state.map_version}.`);
}

follow({
  meet(scene, folder, name) {
    said.scene = scene;
    openNotes(name);
    beginCommands(folder, scene.deformations);
    beginTrial(scene);
    beginWarmUp();
  },
  leave() {
    said.state = null;
  },
  show(words, state) {
    Object.assign(said, { words, state });
    showHead(words, state);
    showSensors(words, state.registers);
    showTrial(words, state.registers);
    showWarmUp(state.registers);
    renewSession();
    showOrders(words, state.registers);
  },
});

heedSession(({ commands, user }) => {
  said.user = user;
  byId("off").hidden = commands;
  byId("commands").classList.toggle("in", user !== null);
});
byId("save").addEventListener("click", () => {
  if (said.state === null) return;
  setText(byId("saved"), `Saved as ${saveReport(said)}.`);
});
