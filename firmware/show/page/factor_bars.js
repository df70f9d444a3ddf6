// A correction factor on a scale by octaves from a quarter to four times: the line at 1 is the description, the bar goes from
// there to the factor. Beside it, ±2σ each: the prior's band in pale, the estimate's as a line over the bar's end.
import { svgElement } from "./pages/elements.js";

const width = 160, height = 20, octaves = 2;
const at = factor => width / 2 * (1 + Math.max(-1, Math.min(1, Math.log2(factor) / octaves)));

// The edges of a band of two standard deviations of the ln; null where it is not known.
export const edgesOf = (ln_mean, ln_sd) => ln_mean === null || ln_sd === null ? null
  : [Math.exp(ln_mean - 2 * ln_sd), Math.exp(ln_mean + 2 * ln_sd)];

function drawScale(svg) {
  svgElement("rect", { class: "prior", y: 1, height: height - 2, rx: 2, fill: "var(--pale)" }, svg);
  svgElement("rect", { class: "bar", y: 6, height: height - 12, rx: 2 }, svg);
  for (const factor of [0.25, 0.5, 2, 4]) {
    svgElement("line", { x1: at(factor), x2: at(factor), y1: 6, y2: height - 6, stroke: "var(--edge)" }, svg);
  }
  svgElement("line", { x1: at(1), x2: at(1), y1: 0, y2: height, stroke: "var(--text)", "stroke-width": 2 }, svg);
  svgElement("path", { class: "estimate", fill: "none", stroke: "var(--text)", "stroke-width": 1.5 }, svg);
}

function span(rect, edges) {
  const [from, to] = edges === null ? [0, 0] : edges.map(at);
  rect.setAttribute("x", from);
  rect.setAttribute("width", to - from);
}

// The bar in a cell, or moved if it is there already; `known`: {prior_ln_mean, prior_ln_sd, ln_sd}, each null where it is not
// known.
export function setBar(cell, factor, known) {
  let svg = cell.querySelector("svg");
  if (!svg) {
    svg = svgElement("svg", { class: "factor", viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" }, cell);
    drawScale(svg);
  }
  const isThere = factor !== null && factor > 0;
  const to = isThere ? factor : 1;
  const bar = svg.querySelector(".bar");
  span(bar, [Math.min(to, 1), Math.max(to, 1)]);
  bar.setAttribute("fill", to < 1 ? "var(--less)" : "var(--bar)");
  span(svg.querySelector(".prior"), edgesOf(known.prior_ln_mean, known.prior_ln_sd));
  const edges = isThere ? edgesOf(Math.log(factor), known.ln_sd) : null;
  const middle = height / 2;
  svg.querySelector(".estimate").setAttribute("d", edges === null ? ""
    : edges.map(edge => `M${at(edge)},${middle - 4}v8`).join("") + `M${at(edges[0])},${middle}H${at(edges[1])}`);
}
