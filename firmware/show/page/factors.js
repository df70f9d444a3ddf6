// The correction factors against the description and against what their priors say.
import { byId, fixed, signed } from "./pages/elements.js";
import { edgesOf, setBar } from "./factor_bars.js";
import { setTable } from "./cells.js";

const unusual = 2;  // of the prior's deviations
const factorHeads = ["name", "kind", "factor", "±2σ", "prior ±2σ", "from its prior", "against the description"];
const unknownBand = { prior_ln_mean: null, prior_ln_sd: null, ln_sd: null };

const rangeText = edges => edges === null ? "–" : edges.map(edge => fixed(edge, 2)).join(" to ");

// How far the factor is from where the prior expects it, in the prior's deviations.
function distanceText(factor, { prior_ln_mean: mean, prior_ln_sd: sd }) {
  if (factor === null || factor <= 0 || mean === null || !(sd > 0)) return "–";
  const distance = (Math.log(factor) - mean) / sd;
  return `${signed(distance, 1)} σ${Math.abs(distance) > unusual ? ", unusual" : ""}`;
}

function factorRow(name, kind, factor, known) {
  const own = factor === null || factor <= 0 ? null : edgesOf(Math.log(factor), known.ln_sd);
  const prior = edgesOf(known.prior_ln_mean, known.prior_ln_sd);
  return [name, kind, fixed(factor, 3), rangeText(own), rangeText(prior), distanceText(factor, known),
    cell => setBar(cell, factor, known)];
}

export function showFactors({ registers, factors }) {
  const kinds = [["heat", registers.heat_factor, factors.heat],
    ["contact or film", registers.conductance_factor, factors.conductance]];
  const rows = kinds.flatMap(([kind, { values }, known]) =>
    Object.entries(values).map(([name, factor]) => factorRow(name, kind, factor, known[name] ?? unknownBand)));
  setTable(byId("factors"), factorHeads, rows, true);
}
