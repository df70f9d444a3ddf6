// What the page has seen of a spindle since it was opened: a sample a second, the oldest go. A silence is a gap.
const most = 3600, gap_s = 4;

function sampleOf(registers) {
  const one = name => registers[name].value;
  const each = name => registers[name].values;
  return {
    nose: one("nose_float32"), nose_sd: one("nose_sd"), uncorrected: one("nose_uncorrected"),
    compensation: one("compensation"), measured: each("key_point_measured_float32"),
    predicted: each("key_point_predicted_float32"), predicted_sd: each("key_point_sd"),
  };
}

const nothing = { nose: null, nose_sd: null, uncorrected: null, compensation: null,
  measured: {}, predicted: {}, predicted_sd: {} };

export function makeRecent() {
  const samples = [];
  let cycle = null;
  return {
    // time_s: of the clock of this browser, since 1970. A cycle that was seen already is none.
    add(time_s, registers) {
      if (registers.sequence.value === cycle) return;
      cycle = registers.sequence.value;
      const last = samples.at(-1);
      if (last && time_s - last.time_s > gap_s) samples.push({ time_s: (last.time_s + time_s) / 2, ...nothing });
      samples.push({ time_s, ...sampleOf(registers) });
      if (samples.length > most) samples.splice(0, samples.length - most);
    },
    clear() {
      samples.length = 0;
      cycle = null;
    },
    // A list of numbers, null where there is none: of each sample what `take` gives.
    list: take => samples.map(sample => take(sample) ?? null),
  };
}
