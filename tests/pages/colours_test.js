// Whether colours can be told apart with every kind of colour vision, and read on their ground.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

const folder = new URL("../../pages/", import.meta.url);
const style = readFileSync(new URL("style.css", folder), "utf8");
const [light, dark] = style.split("@media screen and (prefers-color-scheme: dark)");
const theme = text => Object.fromEntries([...text.matchAll(/--([\w-]+): #([\da-f]{3,6});/g)].map(([, name, hex]) =>
  [name, (hex.length === 3 ? [...hex].map(h => h + h) : hex.match(/../g)).map(h => linear(parseInt(h, 16)))]));
const linear = level => level <= 10.31475 ? level / 3294.6 : ((level / 255 + 0.055) / 1.055) ** 2.4;
const times = (matrix, colour) => matrix.map(row => Math.min(1, Math.max(0, row.reduce((sum, m, k) => sum + m * colour[k], 0))));

// G. Machado, M. Oliveira, L. Fernandes: A physiologically-based model for simulation of color vision deficiency (2009),
// on linear sRGB, full severity.
const visions = {
  usual: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  protanopia: [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
  deuteranopia: [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
  tritanopia: [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
};

// Oklab (B. Ottosson, 2020) of linear sRGB.
function oklab([r, g, b]) {
  const [l, m, s] = [0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b,
    0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b,
    0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b].map(Math.cbrt);
  return [0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s, 1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s];
}
const apart = (a, b) => Math.hypot(...oklab(a).map((v, k) => v - oklab(b)[k]));
const luminance = ([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;
const contrast = (a, b) => (Math.max(luminance(a), luminance(b)) + 0.05) / (Math.min(luminance(a), luminance(b)) + 0.05);

test("curves and bars of one chart stay apart for every kind of colour vision", () => {
  for (const [name, inks] of [["light", theme(light)], ["dark", theme(dark)]]) {
    for (const [vision, matrix] of Object.entries(visions)) {
      for (const group of [["k1", "k2", "k3"], ["plant", "twin", "raw"], ["bar", "less"], ["flow", "out"]]) {
        const seen = group.map(ink => times(matrix, inks[ink]));
        seen.forEach((a, i) => seen.slice(0, i).forEach((b, k) =>
          assert.ok(apart(a, b) > 0.08, `${name}, ${vision}: ${group[i]} and ${group[k]} differ by ${apart(a, b).toFixed(3)}`)));
      }
    }
  }
});

test("texts and curves are readable on their ground", () => {
  for (const [name, inks] of [["light", theme(light)], ["dark", theme(dark)]]) {
    const least = { text: 7, soft: 4.5, k1: 3, k2: 3, k3: 3, twin: 3, raw: 3, reading: 2.5 };
    for (const [ink, wanted] of Object.entries(least)) {
      const found = contrast(inks[ink], inks.card);
      assert.ok(found >= wanted, `${name}: ${ink} has ${found.toFixed(2)} on a card`);
    }
    assert.ok(contrast(inks["warn-text"], inks.warn) >= 4.5, name);
  }
});

test("a warmer place is a lighter one", () => {
  const text = readFileSync(new URL("colours.js", folder), "utf8").match(/const ramp = (\[\[.*\]\]);/)[1];
  const lightness = JSON.parse(text).map(colour => oklab(colour.map(linear))[0]);
  lightness.slice(1).forEach((value, i) => assert.ok(value > lightness[i] + 0.05, `step ${i}: ${lightness[i]} to ${value}`));
});
