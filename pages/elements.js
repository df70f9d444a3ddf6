// Texts, tables and SVG elements that every page is made of.

export const byId = id => document.getElementById(id);

// The data that the program wrote into the page.
export const pageData = () => JSON.parse(byId("data").textContent);

const minus = text => text.replaceAll("-", "\u2212");
// "–" for what is not known.
export const fixed = (value, digits) => value === null ? "–" : minus(value.toFixed(digits)).replace(/^\u2212(0\.?0*)$/, "$1");
// What is 0 in these digits has no minus.
export const signed = (value, digits) => Number(value.toFixed(digits)) < 0 ? minus(value.toFixed(digits))
  : `+${Math.abs(value).toFixed(digits)}`;
export const power = value => minus(value.toExponential(0));
export const duration = seconds =>
  seconds >= 7200 ? `${fixed(seconds / 3600, 1)} h` : seconds >= 120 ? `${fixed(seconds / 60, 1)} min` : `${fixed(seconds, 1)} s`;

export function element(tag, attributes, parent, text) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
  return node;
}

export function svgElement(tag, attributes, parent, text) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
  return node;
}

// Facts: [name, value] in large letters below the title.
export function addFacts(place, facts) {
  for (const [name, value] of facts) {
    const fact = element("div", {}, place);
    element("b", {}, fact, value);
    fact.append(name);
  }
}

// A bar of a table: share -1..1; `within` a second one, darker, in the first.
function addBar(cell, { bar, within }) {
  const most = 110;  // px
  const width = share => share === 0 ? 0 : Math.max(1, most * Math.abs(share));
  cell.classList.add("text", "wide");
  if (within === undefined) {
    element("span", { class: bar < 0 ? "bar less" : "bar", style: `width:${width(bar)}px` }, cell);
    return;
  }
  const svg = svgElement("svg", { viewBox: `0 0 ${most} 12`, style: `width:${most}px` }, cell);
  svgElement("rect", { y: 1, width: width(bar), height: 10, fill: "var(--pale)", rx: 2 }, svg);
  svgElement("rect", { y: 3.5, width: width(within), height: 5, fill: "var(--bar)", rx: 2 }, svg);
}

// Names may break after _ and /.
function addText(cell, text) {
  String(text).split(/(?<=[_/])/).forEach((piece, i) => {
    if (i) element("wbr", {}, cell);
    cell.append(piece);
  });
}

// A cell is a text, {text, kind: class of the cell} or {bar, within}. Above bars stands no heading.
export function addRow(table, cells, tag = "td", kind = "") {
  const line = element("tr", kind ? { class: kind } : {}, table);
  for (const content of cells) {
    const isHeading = tag === "th" && content.bar === undefined;
    const cell = element(isHeading ? "th" : "td", isHeading ? { scope: "col" } : {}, line);
    if (typeof content !== "object") addText(cell, content);
    else if (content.bar !== undefined) addBar(cell, content);
    else {
      cell.textContent = content.text;
      cell.className = content.kind;
    }
  }
}

export const left = text => ({ text, kind: "text" });

// The same, left out where there is little room.
export const aside = text => ({ text, kind: "text wide" });
