// The commands whose pages are tested, and the numbers that they give otherwise: JSON, CSV, tables.
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

const [, , twin, spindles] = process.argv;
if (!spindles) {
  console.error("usage: tests/pages/run SPINDLE_TWIN SPINDLES_FOLDER");
  process.exit(2);
}

export const command = (...words) =>
  execFileSync(twin, words.map(String), { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] });

// A table of a CSV file: a list of numbers for each column, NaN for an empty cell.
export function readTable(path) {
  const [head, ...rows] = readFileSync(path, "utf8").trim().split("\n").map(line => line.split(","));
  const number = cell => cell ? Number(cell) : NaN;
  return Object.fromEntries(head.map((name, i) => [name, rows.map(row => number(row[i]))]));
}

function writeTable(path, table) {
  const rows = Object.values(table)[0].map((_, row) => Object.values(table).map(values => values[row]).join(","));
  writeFileSync(path, [Object.keys(table).join(","), ...rows, ""].join("\n"));
}

// Two nested rings, 12 nodes: a network from the FE model, quickly.
export function buildNetwork(folder) {
  const rom = join(folder, "rings.rom");
  command("build", join(spindles, "shaft_in_sleeve.toml"), "-o", rom, "--nodes", 12, "--certificate-cases", 2);
  return rom;
}

// A network of lumps, written by hand.
export function assembleLumps(folder) {
  const rom = join(folder, "lumps.rom");
  command("assemble", join(spindles, "../../rom/by_hand/motor_spindle.toml"), "-o", rom);
  return rom;
}

// Columns of `simulate` at a state that is held, from rest.
export function simulateHeld(folder, rom, speed_rpm, period_s, end_s) {
  const schedule = join(folder, "held.csv");
  const out = join(folder, "simulated.csv");
  writeFileSync(schedule, `time_s,speed_rpm,load\n0,${speed_rpm},1\n${end_s},${speed_rpm},1\n`);
  command("simulate", rom, "--schedule", schedule, "-o", out, "--period", period_s, "--every", period_s);
  return readTable(out);
}

// Half an hour of a test of the lumps' machine, whose heats are as described: a probe and two sensors.
export function makeTest(folder, rom) {
  const model = simulateHeld(folder, rom, 9000, 10, 1800);
  const log = join(folder, "test.csv");
  const speeds = model.time_s.map(() => 9000);
  writeTable(log, { time_s: model.time_s, speed_rpm: speeds, load: speeds.map(() => 1),
    ...Object.fromEntries(["front_seat", "winding_sensor"].map(name => [`measured.${name}_degC`, model[`${name}_degC`]])),
    "measured.nose_um": model.nose_um });
  return log;
}

// A run of ten minutes: the plant has .6 of the network's rises, the twin is the estimator with three of four sensors.
export function makeRun(folder, rom) {
  const model = simulateHeld(folder, rom, 6000, 10, 600);
  const cooler = name => model[name].map(value => 27 + 0.6 * (value - 27));
  const points = ["centre", "shaft_surface", "sleeve_bore", "sleeve_outside"];
  const files = Object.fromEntries(["plant", "log", "twin"].map(name => [name, join(folder, `${name}.csv`)]));
  writeTable(files.plant, { time_s: model.time_s,
    ...Object.fromEntries(points.map(name => [`key_point.${name}_degC`, cooler(`${name}_degC`)])),
    ...Object.fromEntries(["shaft", "sleeve"].map(name => [`part_maximum.${name}_degC`, cooler(`${name}_max_degC`)])),
    "deformation.outer_growth_um": model.outer_growth_um.map(um => 0.6 * um) });
  const held = value => model.time_s.map(() => value);
  writeTable(files.log, { time_s: model.time_s, speed_rpm: held(6000), load: held(1), ambient_degC: held(27),
    ...Object.fromEntries(points.slice(1).map(name => [`measured.${name}_degC`, cooler(`${name}_degC`)])) });
  command("replay", rom, files.log, "-o", files.twin);
  const words = ["report", rom, "--history", files.twin, "--plant", files.plant, "--part", "shaft"];
  const html = join(folder, "run.html");
  const table = command(...words, "--table", "-o", html);
  return { html, table, twin: readTable(files.twin), plant: readTable(files.plant), points };
}
