// The parts as fields coloured by temperature, with a legend.
import { colourScale, ramp } from "./pages/colours.js";
import { fixed, svgElement } from "./pages/elements.js";

const row = 26, legend = 34;

// From a round number below the coldest to one above the hottest, at least 5 K apart.
function scaleOf(values) {
  const low = Math.floor(Math.min(...values));
  return colourScale(low, Math.max(low + 5, Math.ceil(Math.max(...values))));
}

function drawLegend(svg, scale, width, y) {
  const id = "ramp";
  const gradient = svgElement("linearGradient", { id }, svgElement("defs", {}, svg));
  ramp.forEach(([r, g, b], i) =>
    svgElement("stop", { offset: i / (ramp.length - 1), "stop-color": `rgb(${r},${g},${b})` }, gradient));
  svgElement("rect", { x: 0, y, width, height: 10, fill: `url(#${id})` }, svg);
  svgElement("text", { x: 0, y: y + 25 }, svg, `${fixed(scale.low, 0)} °C`);
  svgElement("text", { x: width, y: y + 25, "text-anchor": "end" }, svg, `${fixed(scale.high, 0)} °C`);
}

// parts: [name, degC or null]; drawn anew, as all colours change with the scale.
export function listParts(place, parts) {
  place.replaceChildren();
  const known = parts.map(([, value]) => value).filter(value => value !== null);
  if (!known.length) {
    place.textContent = "no prediction yet";
    return;
  }
  const width = place.clientWidth || 600;
  const scale = scaleOf(known);
  const words = parts.map(([name, value]) => `${name} ${fixed(value, 2)} °C`).join(", ");
  const height = parts.length * row + legend + 6;
  const svg = svgElement("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": words }, place);
  parts.forEach(([name, value], i) => {
    if (value === null) return;
    const y = i * row;
    svgElement("rect", { x: 0, y, width, height: row - 3, rx: 3, fill: scale.css(value) }, svg);
    const kind = scale.darkLetters(value) ? "on-light" : "on-dark";
    svgElement("text", { x: 8, y: y + 16, class: `part ${kind}` }, svg, name);
    svgElement("text", { x: width - 8, y: y + 16, class: `part ${kind}`, "text-anchor": "end" }, svg, `${fixed(value, 2)} °C`);
  });
  drawLegend(svg, scale, width, parts.length * row + 4);
}
