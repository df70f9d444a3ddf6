// The page of `spindle-twin identify --html`: what sensors tell, where the next one helps, and which test is proposed.
import { drawChart } from "./time_chart.js";
import { addFacts, addRow, aside, byId, fixed, left, pageData } from "./pages/elements.js";
import { drawSection } from "./pages/section.js";

const mostPlaces = 12;
const data = pageData();
const { test } = data;
const um = value => `${fixed(value, 2)} µm`;
const minutes = seconds => `${fixed(seconds / 60, 0)} min`;

function writeHead() {
  const title = test ? `A test of spindle “${data.spindle}”` : `What sensors tell of spindle “${data.spindle}”`;
  document.title = title;
  byId("title").textContent = title;
  byId("state").textContent = data.state;
  byId("section-text").textContent = "Meridian section. Crosses: sensors. Dots: places for one more, coloured by the standard " +
    `deviation of ${data.deformation} that is left with it; dark is best. ${data.left_out}`;
  byId("sensors-text").textContent = `1σ of ${data.deformation} where this one is left out, all others in place.`;
  byId("places-text").textContent = `1σ of ${data.deformation} with one more sensor there.`;
  addFacts(byId("facts"), data.facts.map(fact => [fact.name, um(fact.um)]));
}

function showTest() {
  if (!test) {
    byId("test").remove();
    return;
  }
  byId("cycle-text").textContent = `Probe at ${data.deformation}, ${test.load === 0 ? "without load" :
    `at load ${fixed(test.load, 2)}`}; from a spindle that has the temperature of its surroundings.`;
  byId("compared-text").textContent = `1σ of ${data.deformation} in service, rms over the service drive, with the sensors ` +
    "that stay and without any; after the first half hour of the test and after all of it.";
  const draw = (id, label, series) =>
    drawChart(byId(`${id}-legend`), byId(id), { label, time_s: test.time_s, series: [series], from_zero: true });
  draw("speed", "speed, rpm", { name: "speed", values: test.speed_rpm, ink: "twin", steps: true });
  draw("growth", "growth, µm", { name: data.deformation, values: test.growth_um, ink: "k1" });
  addRow(byId("schedule"), ["from", "for", "speed, rpm"], "th");
  for (const stage of test.stages) {
    addRow(byId("schedule"), [minutes(stage.from_s), minutes(stage.for_s), fixed(stage.speed_rpm, 0)]);
  }
  const table = byId("compared");
  addRow(table, ["test", "30 min, sensors", aside("30 min, none"), "all, sensors", aside("all, none"), { bar: 0 }], "th");
  const most = Math.max(...test.compared.map(row => row.whole.with_sensors_um));
  for (const row of test.compared) {
    addRow(table, [row.name, ...[row.first, row.whole].flatMap(part => [um(part.with_sensors_um), aside(um(part.open_loop_um))]),
      { bar: row.whole.with_sensors_um / most }], "td", row.name === "proposed" ? "sum" : "");
  }
}

function showSection() {
  const values = data.places.map(place => place.um);
  const low_K = Math.min(...values, data.now_um);
  drawSection(byId("section"), byId("pointed"), {
    outlines: data.outlines, flows: [], bodies: [], lumps: false, dot: 4.5, sign: "sensor", unit: "µm left", digits: 2,
    low_K, high_K: Math.max(low_K + 1e-9, data.now_um, ...values),
    nodes: data.places.map(place => ({ ...place, rise_K: place.um, tip: `${place.name}, ${place.part}: ${um(place.um)} left` })),
    key_points: data.sensors.filter(sensor => sensor.at_m).map(sensor => ({ name: sensor.name, at_m: sensor.at_m,
      label: sensor.name, tip: `${sensor.role} sensor ${sensor.name}: ${um(sensor.without_um)} without it` })),
  });
}

function showTables() {
  addRow(byId("sensors"), ["sensor", left("role"), "1σ without it"], "th");
  for (const sensor of data.sensors) addRow(byId("sensors"), [sensor.name, left(sensor.role), um(sensor.without_um)]);
  addRow(byId("places"), ["place", aside("part"), aside("r, mm"), aside("z, mm"), "1σ with it"], "th");
  for (const place of data.places.slice(0, mostPlaces)) {
    addRow(byId("places"), [place.name, aside(place.part), ...place.at_m.map(m => aside(fixed(1000 * m, 1))), um(place.um)]);
  }
}

writeHead();
showTest();
showSection();
showTables();
