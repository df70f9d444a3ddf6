// One state of a spindle, on the page.
import { amiss, hasBit, meaning, nameOf, plain, sensorWords } from "./words.js";
import { byId, fixed, signed } from "./pages/elements.js";
import { listParts } from "./parts.js";
import { showFactors } from "./factors.js";
import { setFacts, setList, setTable, setText } from "./cells.js";

const sign = { starting: "○", running: "●", degraded: "▲", fault: "✕" };
const known = (value, text) => value === null ? "–" : text(value);
const band = sd => known(sd, value => `± ${fixed(2 * value, 2)}`);
const um = value => known(value, number => `${signed(number, 2)} µm`);

function compensationWords(words, registers) {
  const rung = nameOf(words, "compensation_rung", registers.compensation_rung.value);
  const bits = registers.compensation_bits.value;
  const more = ["warning", "limited", "moving", "trial"].filter(name => hasBit(words, "compensation_bits", bits, name));
  if (!hasBit(words, "compensation_bits", bits, "enabled")) return ["switched off", ...more].join(", ");
  return [rung === null ? "–" : plain(rung), ...more].join(", ");
}

function showHeader(words, state) {
  const { registers } = state;
  const name = registers.state.name;
  setText(byId("title"), state.spindle);
  setText(byId("state"), `${sign[name] ?? ""} ${name}: ${meaning(words, "state", name)}`);
  setText(byId("moment"), `cycle ${registers.sequence.value}`);
  setText(byId("about"), `spindle-twind ${state.version}, register map ${state.map_version}.`);
}

function showGrowth(words, registers) {
  setFacts(byId("growth"), [
    ["nose growth minus tare", um(registers.nose_float32.value)],
    ["±2σ of the growth, µm", band(registers.nose_sd.value)],
    ["compensation output", um(registers.compensation.value)],
    ["±2σ of the compensation, µm", band(registers.compensation_sd.value)],
  ]);
  const rung = nameOf(words, "compensation_rung", registers.compensation_rung.value);
  const settled = registers.compensation_settled_after.value;
  setFacts(byId("machine"), [
    ["compensation", compensationWords(words, registers)],
    ["the compensation stands on", rung === null ? "–" : meaning(words, "compensation_rung", rung)],
    ["warm-up left", settled === null ? "not known" : `${settled} min`],
    ["speed", known(registers.speed.value, value => `${value} rpm`)],
    ["load", known(registers.load.value, value => `${fixed(value, 1)} %`)],
    ["coolant inlet", known(registers.coolant_temperature.value, value => `${fixed(value, 2)} °C`)],
    ["ambient", known(registers.ambient_temperature.value, value => `${fixed(value, 2)} °C`)],
  ]);
}

function showTemperatures(words, registers) {
  const rows = Object.entries(registers.key_point_predicted_float32.values).map(([point, predicted]) => {
    const measured = registers.key_point_measured_float32.values[point];
    const difference = measured === null || predicted === null ? null : measured - predicted;
    return [point, known(measured, value => fixed(value, 2)), known(predicted, value => fixed(value, 2)),
      band(registers.key_point_sd.values[point]), known(difference, value => signed(value, 2)),
      sensorWords(words, registers, point)];
  });
  setTable(byId("temperatures"), ["key point", "measured", "predicted", "±2σ", "difference", "sensor"], rows, true);
}

export function showState(words, state) {
  const { registers } = state;
  showHeader(words, state);
  showGrowth(words, registers);
  setList(byId("messages"), amiss(words, registers));
  listParts(byId("parts"), Object.entries(registers.part_maximum_float32.values));
  showTemperatures(words, registers);
  showFactors(state);
}
