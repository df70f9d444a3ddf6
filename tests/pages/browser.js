// A page in the headless shell of Debian's Chromium: what it wanted to load and what it complained of is kept. The shell takes
// half the processor time of the whole browser.
import { existsSync, readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const program = "/usr/bin/chromium-headless-shell";
const axe = readFileSync(new URL("node_modules/axe-core/axe.min.js", import.meta.url), "utf8");

export async function startBrowser() {
  if (!existsSync(program)) throw new Error(`${program} is missing: host_tools/setup tests`);
  // Root may run it only without its own sandbox; it sees nothing but the page under test.
  return chromium.launch({ executablePath: program, args: ["--no-sandbox", "--disable-gpu"] });
}

// Opens the file; `requests` beyond the file itself are refused and kept, `complaints` are what the console says and what
// is thrown.
export async function openPage(browser, file, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, offline: true, ...options });
  const page = await context.newPage();
  const address = pathToFileURL(file).href;
  const seen = { page, requests: [], complaints: [] };
  await context.route(() => true, route => {
    if (route.request().url() === address) return route.continue();
    seen.requests.push(route.request().url());
    return route.abort();
  });
  page.on("console", message => {
    if (["error", "warning"].includes(message.type())) seen.complaints.push(message.text());
  });
  page.on("pageerror", error => seen.complaints.push(String(error)));
  await page.goto(address);
  await page.evaluate(() => document.fonts.ready);
  return seen;
}

// What axe-core finds wrong with a page, a line each.
export async function findingsOfAxe(page) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate("axe.run()");
  return violations.map(({ id, nodes }) => `${id}: ${nodes.map(node => node.html).join(" ")}`);
}
