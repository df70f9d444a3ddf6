// What states, faults and sensors mean, in the register map's own words (/api/v1/words).

// "bit 13: a sensor has failed, see sensor_fault" is "a sensor has failed": bits and registers are for programs.
const without = doc => doc.replace(/^bit \d+: /, "")
  .replace(/ \(see [^)]*\)|[:;,]? see `?[a-z]+(_[a-z]+)*`?/g, "");

// The meaning of a code by its name; the name itself where there is none.
export function meaning(words, register, name) {
  const entry = words[register]?.find(each => each.name === name);
  return entry ? without(entry.doc) : String(name);
}

export const nameOf = (words, register, value) => words[register]?.find(each => each.value === value)?.name ?? null;

export const hasBit = (words, register, value, name) =>
  value !== null && (value & (words[register]?.find(each => each.name === name)?.value ?? 0)) !== 0;

export const plain = name => name.replaceAll("_", " ");

// The key point that a swapped sensor shows.
function partnerOf(registers, point) {
  if (registers.sensor_fault.names[point] !== "swapped") return "";
  const partner = Object.keys(registers.sensor_quality.names)[registers.sensor_partner.values[point] ?? -1];
  return partner === undefined ? "" : `; the other one: ${partner}`;
}

// Whether a sensor is believed and, where not, why.
export function sensorWords(words, registers, point) {
  const quality = registers.sensor_quality.names[point];
  const state = registers.sensor_state.names[point];
  const fault = registers.sensor_fault.names[point];
  if (quality === "not_configured") return "no sensor";
  const said = [];
  if (quality !== "good" && quality !== "withheld") said.push(meaning(words, "sensor_quality", quality));
  if (state !== null && state !== "good") {
    const hasFault = fault !== null && fault !== "none";
    const why = hasFault ? meaning(words, "sensor_fault", fault) : meaning(words, "sensor_state", state);
    said.push(`${plain(state)}: ${why}${partnerOf(registers, point)}`);
  }
  const update = registers.sensor_update.set[point] ?? [];
  if (update.includes("by_partner")) said.push(meaning(words, "sensor_update", "by_partner"));
  if (update.includes("rejected")) {
    said.push(`${meaning(words, "sensor_update", "rejected")} (test ratio ${registers.sensor_test_ratio.values[point]})`);
  }
  return said.length ? said.join("; ") : "good";
}

// One sentence for each fault, each quality bit and each sensor that is not believed.
export function amiss(words, registers) {
  const said = [];
  for (const name of registers.fault.set ?? []) said.push(`Fault, ${plain(name)}: ${meaning(words, "fault", name)}`);
  for (const name of registers.quality.set ?? []) {
    said.push(`${plain(name)}: ${meaning(words, "quality", name)}`);
  }
  if (hasBit(words, "compensation_bits", registers.compensation_bits.value, "trial")) {
    said.push(`Compensation, trial: ${meaning(words, "compensation_bits", "trial")}`);
  }
  for (const point of Object.keys(registers.sensor_quality.names)) {
    const text = sensorWords(words, registers, point);
    if (text !== "good" && text !== "no sensor") said.push(`Sensor ${point}: ${text}`);
  }
  return said;
}
