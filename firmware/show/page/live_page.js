// The daemon's live page: shows once a second the state of the spindle that is chosen.
import { addToCurves, clearCurves } from "./curves.js";
import { beginCommands, renewSession, showOrders } from "./commands.js";
import { follow } from "./follow_daemon.js";
import { makeSection } from "./live_section.js";
import { beginBenefit, renewBenefit } from "./benefit.js";
import { beginDays, renewDays } from "./days.js";
import { showFlows } from "./heat_flows.js";
import { showState } from "./show_state.js";

let scene = null, section = null;

follow({
  meet(found, folder) {
    scene = found;
    section = makeSection(scene);
    beginDays(scene.has_history ? `${folder}/history` : null);
    beginBenefit(scene.has_history && scene.deformations.length ? `${folder}/growth` : null);
    beginCommands(folder, scene.deformations);
  },
  leave() {
    clearCurves();
    section?.leave();
    section = null;
  },
  show(words, state) {
    showState(words, state);
    section.show(state);
    showFlows(scene, state);
    addToCurves(state.registers);
    renewDays();
    renewBenefit();
    renewSession();
    showOrders(words, state.registers);
  },
});
