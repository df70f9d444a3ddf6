// What a dial gauge says of the control's input: right, or which mistake is the likely one. From plain numbers, for tests
// too; knows no page.
//
// steps: {value_um, gauge_um} of the first zero, plus, minus and zero again, the values as the register had them; gauge_um + =
// the nose is further from the table; sign: compensation.sign of the daemon; read_to_um: the gauge's smallest step.
//   expected = sign · value; gain g = (gauge₊ − gauge₋) / (expected₊ − expected₋), known within read_to / way
//   lash = gauge₊ + gauge₋ − 2 gauge₀, of the last zero, which was reached upwards as plus was; 0 without play
//   return = first zero − last zero, which nothing but play, a slip or a knock makes other than 0
import { fixed } from "./pages/elements.js";

// How many times too far, and what is then taken for what.
const units = [
  [1e4, "an integer register, which counts 0.1 µm, is taken for millimetres"],
  [1000, "micrometres are taken for millimetres"],
  [100, "the input has another decimal place by two"],
  [25.4, "thousandths of a millimetre are taken for thousandths of an inch"],
  [10, "0.1 µm is taken for 1 µm: an integer register counts 0.1 µm"],
  [2.54, "micrometres are taken for ten-thousandths of an inch"],
  [2, "the value is added twice, as by the PLC and by the control"],
  [1 / 2, "the value is taken for a diameter"],
  [1 / 2.54, "ten-thousandths of an inch are taken for micrometres"],
  [1 / 10, "1 µm is taken for 0.1 µm: the input counts 0.1 µm"],
  [1 / 25.4, "thousandths of an inch are taken for thousandths of a millimetre"],
  [1 / 100, "the input has another decimal place by two"],
  [1 / 1000, "millimetres are taken for micrometres"],
];
const nearShare = 0.12, rightShare = 0.05, noiseShare = 0.05, noWay = 1.5, noLash = 2.5;

// The units within reach of a factor that is known by so much, the nearest first.
function likelyUnits(factor, uncertainty) {
  const away = unit => Math.abs(Math.log(factor / unit));
  return units.filter(([unit]) => Math.abs(factor - unit) <= Math.max(nearShare * unit, uncertainty))
    .sort(([a], [b]) => away(a) - away(b));
}

const percent = share => `${fixed(100 * Math.abs(share), Math.abs(share) < 0.1 ? 1 : 0)} %`;
const times = factor => factor >= 1.5 ? `${fixed(factor, factor < 20 ? 1 : 0)} times as far as it should`
  : `only ${percent(factor)} of what it should`;

function notRead(smallest) {
  return { verdict: "not_read", gain: 0,
    text: "The nose does not move: the control does not read the value, or does not add it. " +
    `Anything below ${percent(smallest)} of the way, as of a wrong unit, would look the same on this gauge.`,
  change: "Look at the value in the control's own diagnosis, then at what switches the compensation on there." };
}

function sticks(gain, away_um) {
  return { verdict: "sticks", gain, text: "Up and down do not agree: what is reached depends on where one comes from, " +
    `by about ${fixed(away_um, 1)} µm.${gain < 0 ? " And the sign seems to be wrong." : ""}`,
  change: "Look for backlash, a friction that holds the axis, a control that makes only steps of some size, a loose gauge, " +
    "or one that was knocked; then try again." };
}

function ofScale(factor, uncertainty, wrongSign) {
  const tolerance = rightShare + 2 * uncertainty;
  if (Math.abs(factor - 1) <= tolerance) return null;
  const likely = likelyUnits(factor, uncertainty);
  if (likely.length === 0) {
    const off = factor - 1;
    return { verdict: wrongSign ? "wrong_sign" : "wrong_scale",
      text: `It goes ${percent(off)} too ${off > 0 ? "far" : "short"}.`, change: "Look at the scale of the input." };
  }
  return { verdict: "wrong_unit", unit: likely[0][0],
    text: `It goes ${times(factor)}: ${likely.map(([, words]) => words).join(", or ")}.`,
    change: "Look at the unit and the scale of the input." };
}

function ofSign(sign) {
  return { verdict: "wrong_sign", text: `The nose goes ${sign > 0 ? "towards the table for +" : "away from the table for +"}: ` +
    "the wrong way. With this sign the compensation doubles the growth.",
  change: "Turn the sign in one place: the scale in the control, or compensation.sign, which is " +
    `${sign > 0 ? "+1" : "−1"} now.` };
}

function ofMovement(gain, uncertainty, sign) {
  const wrongSign = gain < 0;
  const scale = ofScale(Math.abs(gain), uncertainty, wrongSign);
  if (!wrongSign && scale === null) {
    const within = percent(rightShare + 2 * uncertainty);
    return { verdict: "right", gain, text: `Sign, unit and scale are right, within ${within}: ` +
      `the nose goes ${percent(gain)} of the way that it should.`, change: "" };
  }
  if (!wrongSign) return { ...scale, gain };
  const turned = ofSign(sign);
  if (scale === null) return { ...turned, gain };
  return { ...turned, gain, unit: scale.unit, text: `${turned.text} ${scale.text}`, change: `${turned.change} ${scale.change}` };
}

export function judgeInput(steps, sign, read_to_um) {
  const isThere = value => typeof value === "number" && Number.isFinite(value);
  if (!steps.every(({ value_um, gauge_um }) => isThere(value_um) && isThere(gauge_um))) {
    return { verdict: "incomplete", gain: null, text: "Not all four readings are there yet.", change: "" };
  }
  const gauge = steps.map(({ gauge_um }) => gauge_um);
  const way_um = sign * (steps[1].value_um - steps[2].value_um);
  if (Math.abs(way_um) < 1e-9) {
    return { verdict: "incomplete", gain: null, text: "The register had the same value at + and −: try again.", change: "" };
  }
  const uncertainty = read_to_um / Math.abs(way_um);
  const noise_um = noiseShare * (Math.max(...gauge) - Math.min(...gauge));
  if (Math.max(...gauge) - Math.min(...gauge) <= noWay * read_to_um) return notRead(noWay * uncertainty);
  const gain = (gauge[1] - gauge[2]) / way_um;
  const lash_um = Math.abs(gauge[1] + gauge[2] - 2 * gauge[3]);
  const return_um = Math.abs(gauge[0] - gauge[3]);
  if (lash_um > noLash * read_to_um + noise_um || return_um > noWay * read_to_um + noise_um) {
    return sticks(gain, Math.max(lash_um, return_um));
  }
  return ofMovement(gain, uncertainty, sign);
}
