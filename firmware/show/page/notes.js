// What was entered and measured on this page, kept in the tab for each spindle, so that loading the page again in the middle
// loses nothing. A name or a password is not among it.
import { byId } from "./pages/elements.js";
import { setText } from "./cells.js";

const nothingYet = () => ({
  fields: {},                                                        // by id, of the elements with data-keep
  trial: { ordered_um: [null, null, null, null], value_um: [null, null, null, null], gauge_um: [null, null, null, null],
    step: null, isMine: false },
  warmUp: { begun_s: null, ended_s: null, every_s: 2, samples: [], lengths: [] },
});
let place = "";

export const notes = nothingYet();

export function keepNotes() {
  try {
    sessionStorage.setItem(place, JSON.stringify(notes));
    setText(byId("not-kept"), "");
  } catch (error) {
    setText(byId("not-kept"), `This browser keeps nothing (${error.name}): loading the page again loses what is entered here.`);
  }
}

function stored() {
  try {
    return JSON.parse(sessionStorage.getItem(place)) ?? {};
  } catch {
    return {};
  }
}

const keptFields = () => [...document.querySelectorAll("[data-keep]")];

// Of the spindle of this name.
export function openNotes(name) {
  place = `commissioning ${name}`;
  Object.assign(notes, nothingYet(), stored());
  for (const field of keptFields()) field.value = notes.fields[field.id] ?? field.defaultValue;
}

for (const field of keptFields()) {
  field.addEventListener("input", () => {
    notes.fields[field.id] = field.value;
    keepNotes();
  });
}
