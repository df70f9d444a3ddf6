// The page of `spindle-twin inspect --html`: a network in its steady state.
import { drawChart } from "./time_chart.js";
import { addFacts, addRow, aside, byId, duration, fixed, left, pageData, power, signed } from "./pages/elements.js";
import { drawSection } from "./pages/section.js";

const mostRows = 22;  // of a table that is ranked; 40 outputs of a certificate
const data = pageData();
const nose = data.deformations[0];
const total = key => data.balance.reduce((sum, body) => sum + body[key], 0);
const bySize = (list, key) => [...list].sort((a, b) => Math.abs(b[key]) - Math.abs(a[key])).slice(0, mostRows);
const watts = value => Math.abs(value) < 0.005 ? { text: "·", kind: "zero" } : fixed(value, 2);

function writeHead() {
  const title = `Thermal network of spindle “${data.spindle}”`;
  document.title = title;
  byId("title").textContent = title;
  byId("state").textContent = `Steady state at ${fixed(data.speed_rpm, 0)} rpm, load ${fixed(data.load, 2)}` +
    data.environments.map(e => `, ${e.name} ${fixed(e.degC, 1)} °C`).join("");
  byId("hash").textContent = `Built from a description with SHA-256 ${data.description_sha256}`;
  const hottest = data.nodes.reduce((best, node) => node.rise_K > best.rise_K ? node : best);
  addFacts(byId("facts"), [["nodes", data.nodes.length], ["heat in", `${fixed(total("source_W"), 1)} W`],
    ["to coolant", `${fixed(total("coolant_W"), 1)} W`], ["to ambient", `${fixed(total("ambient_W"), 1)} W`],
    [`hottest node, ${data.hand_written ? hottest.name : hottest.part || hottest.name}`, `${signed(hottest.rise_K, 1)} K`],
    ...data.key_points.map(p => [`key point ${p.name}`, `${signed(p.rise_K, 2)} K`]),
    ...data.deformations.map(d => [d.name, `${fixed(d.um, 2)} µm`])]);
}

function showSection() {
  const lumps = data.hand_written;
  const centre = body => {
    const own = data.nodes.filter(n => (lumps ? n.name : n.part || n.name) === body.name);
    return [0, 1].map(k => own.reduce((sum, n) => sum + n.at_m[k], 0) / own.length);
  };
  const rises = data.nodes.map(n => n.rise_K);
  const low_K = Math.min(0, ...rises);
  drawSection(byId("section"), byId("pointed"), {
    outlines: data.outlines, nodes: data.nodes, flows: data.flows, lumps, low_K, high_K: Math.max(low_K + 1e-9, ...rises),
    bodies: data.balance.map(body => {
      const rise_K = body.mean_degC - data.rest_degC;
      const heated = body.source_W > 0.005 ? `, heated by ${fixed(body.source_W, 1)} W` : "";
      return { name: body.name, rise_K, centre_m: centre(body),
        tip: `${body.name}: mean ${fixed(body.mean_degC, 2)} °C, ${signed(rise_K, 2)} K${heated}` };
    }),
    key_points: data.key_points.map(p => ({ ...p, tip: `key point ${p.name}: ${signed(p.rise_K, 3)} K` })),
  });
}

function showBalance() {
  const body = data.hand_written ? "node" : "part";
  byId("balance-title").textContent = `Heat balance of every ${body}`;
  const ways = [["contact_W", "by contact"], ["gas_W", "through gas"], ["coolant_W", "to coolant"], ["ambient_W", "to ambient"]];
  if (data.balance.some(b => Math.abs(b.conduction_W) > 0.005)) ways.push(["conduction_W", "by conduction"]);
  const table = byId("balance");
  addRow(table, [body, "mean °C", "heated by", ...ways.map(way => way[1]), "residue"], "th");
  for (const b of data.balance) {
    addRow(table, [b.name, fixed(b.mean_degC, 2), watts(b.source_W), ...ways.map(way => watts(b[way[0]])), power(b.residue_W)]);
  }
  addRow(table, ["sum", "", fixed(total("source_W"), 2), ...ways.map(way => fixed(total(way[0]), 2)), power(total("residue_W"))],
    "td", "sum");
}

function showWarmUp() {
  const run = data.warm_up;
  const inks = ["k1", "k2", "k3", "plant", "reading"];
  const chart = (id, label, curves, values) => {
    const series = curves.map((curve, i) =>
      ({ name: curve.name, values: values(curve), ink: inks[i % inks.length], dashed: i >= inks.length }));
    drawChart(byId(`${id}-legend`), byId(id), { label, time_s: run.time_s, series });
  };
  if (!data.key_points.length) byId("rises").parentElement.remove();
  else chart("rises", "rise, K", run.key_points, curve => curve.rises_K);
  if (!nose) byId("growth").parentElement.remove();
  else chart("growth", "deformation, µm", run.deformations, curve => curve.um);
}

function showFlows() {
  const flows = bySize(data.flows, "heat_W");
  const table = byId("flows");
  addRow(table, ["from → to", aside("through"), "W", { bar: 0 }], "th");
  for (const f of flows) {
    const [source, target] = f.heat_W >= 0 ? [f.from, f.to] : [f.to, f.from];
    const through = f.name.includes("/") ? f.kind : f.name;
    addRow(table, [`${source} → ${target}`, aside(through), fixed(Math.abs(f.heat_W), 2),
      { bar: Math.abs(f.heat_W / (flows[0].heat_W || 1)) }]);
  }
}

function showSensitivities() {
  byId("sensitivity-title").textContent = nose ? `What moves the ${nose.name} (${fixed(nose.um, 2)} µm)` : "Sensitivities";
  const ranked = bySize(data.sensitivities, "um_per_doubling");
  const table = byId("sensitivities");
  addRow(table, ["contact or film", aside("kind"), "µm", { bar: 0 }], "th");
  for (const s of ranked) {
    addRow(table, [s.name, aside(s.kind), fixed(s.um_per_doubling, 3),
      { bar: s.um_per_doubling / (Math.abs(ranked[0].um_per_doubling) || 1) }]);
  }
}

function showModes() {
  const table = byId("modes");
  addRow(table, ["time constant", left("where its heat lies")], "th");
  for (const mode of data.modes) {
    const where = mode.where.map(w => `${w.name} ${fixed(100 * w.share, 0)} %`).join(", ");
    addRow(table, [duration(mode.time_constant_s), left(where)]);
  }
}

function showCertificate() {
  const { cases, seed, outputs } = data.certificate;
  byId("certificate-text").textContent = cases === 0 ? "No certificate: this network was not compared with an FE model." :
    `Certificate: largest difference over ${cases} random cases that the network was not built from, seed ${seed}. ` +
    "Bars: worst case, and darker the median." + (data.certificate.limit ? ` Limit: ${data.certificate.limit}.` : "") +
    (data.certificate.found ? ` Worst found by a search: ${data.certificate.found}.` : "");
  if (cases === 0) return;
  const shown = outputs.slice(0, 40);
  const meshed = shown.some(o => o.mesh > 0);
  const limited = shown.some(o => o.limit > 0);
  const largest = {};
  for (const o of shown) largest[o.unit] = Math.max(largest[o.unit] || 0, o.worst);
  const table = byId("certificate");
  addRow(table, ["output", "worst", "median", ...(limited ? ["limit"] : []), ...(meshed ? ["mesh"] : []), { bar: 0 }], "th");
  for (const o of shown) {
    const share = value => value / (largest[o.unit] || 1);
    addRow(table, [o.name, `${fixed(o.worst, 4)} ${o.unit}`, fixed(o.median, 4),
      ...(limited ? [fixed(o.limit, 4)] : []), ...(meshed ? [fixed(o.mesh, 4)] : []),
      { bar: share(o.worst), within: share(o.median) }]);
  }
}

writeHead();
showSection();
showBalance();
showWarmUp();
showFlows();
showSensitivities();
showModes();
showCertificate();
