// Tables and texts that are renewed each second: an element is changed only where its text is another, so that a selection,
// the keyboard's place and a screen reader are left in peace. Texts come in as text only, never as HTML.
import { element } from "./pages/elements.js";

export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

function nthChild(parent, tag, i) {
  return parent.children[i] ?? element(tag, {}, parent);
}

function cutTo(parent, count) {
  while (parent.children.length > count) parent.lastElementChild.remove();
}

// `heads`: names of the columns, the last one of words if `reasons`; rows: lists of texts, or of functions that fill a cell.
export function setTable(table, heads, rows, reasons = false) {
  const head = table.tHead ?? element("thead", {}, table);
  const body = table.tBodies[0] ?? element("tbody", {}, table);
  const line = nthChild(head, "tr", 0);
  heads.forEach((text, i) => {
    const cell = nthChild(line, "th", i);
    cell.scope = "col";
    setText(cell, text);
    if (reasons && i === heads.length - 1) cell.className = "reason";
  });
  rows.forEach((texts, r) => {
    const row = nthChild(body, "tr", r);
    texts.forEach((content, i) => {
      const cell = nthChild(row, "td", i);
      cell.dataset.head = heads[i];
      if (typeof content === "function") content(cell);
      else setText(cell, content);
      if (reasons && i === heads.length - 1) cell.className = "reason";
    });
  });
  cutTo(body, rows.length);
}

// facts: [name, value]
export function setFacts(place, facts) {
  facts.forEach(([name, value], i) => {
    const fact = nthChild(place, "div", i);
    setText(nthChild(fact, "b", 0), value);
    setText(nthChild(fact, "span", 1), name);
  });
  cutTo(place, facts.length);
}

export function setList(list, texts) {
  texts.forEach((text, i) => setText(nthChild(list, "li", i), text));
  cutTo(list, texts.length);
}
