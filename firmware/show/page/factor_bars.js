// A correction factor as a bar from 1, on a scale by octaves from a quarter to four times.
import { svgElement } from "./pages/elements.js";

const width = 160, height = 16, octaves = 2;
const at = factor => width / 2 * (1 + Math.max(-1, Math.min(1, Math.log2(factor) / octaves)));

function drawScale(svg) {
  svgElement("rect", { y: 4, height: height - 8, rx: 2 }, svg);
  for (const factor of [0.25, 0.5, 2, 4]) {
    svgElement("line", { x1: at(factor), x2: at(factor), y1: 4, y2: height - 4, stroke: "var(--edge)" }, svg);
  }
  svgElement("line", { x1: at(1), x2: at(1), y1: 0, y2: height, stroke: "var(--text)", "stroke-width": 2 }, svg);
}

// The bar in a cell, or moved if it is there already.
export function setBar(cell, factor) {
  let svg = cell.querySelector("svg");
  if (!svg) {
    svg = svgElement("svg", { class: "factor", viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" }, cell);
    drawScale(svg);
  }
  const to = factor === null || factor <= 0 ? at(1) : at(factor);
  const bar = svg.firstChild;
  bar.setAttribute("x", Math.min(to, at(1)));
  bar.setAttribute("width", Math.abs(to - at(1)));
  bar.setAttribute("fill", to < at(1) ? "var(--less)" : "var(--bar)");
}
