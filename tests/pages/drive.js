// A browser that a test in another language drives: each line of the input is JSON, each gives one line of JSON.
//   {"open": ADDRESS, "options": {...}}    a new page there, the only one, which knows nothing of those before
//   {"close": true}                        no page
//   {"evaluate": EXPRESSION}               its value in the page
//   {"choose": [SELECTOR, VALUE]}          in a select element
//   {"reload": true}                       the page again, in the same tab
//   {"picture": FILE}                      of the whole page
//   {"judge": true}                        what axe-core finds wrong
//   {"seen": true}                         requests to elsewhere, and complaints of the console
import { createInterface } from "node:readline";
import { findingsOfAxe, startBrowser } from "./browser.js";

const browser = await startBrowser();
let page, seen;

async function close() {
  await page?.context().close();
  page = undefined;
  return null;
}

async function open(address, options) {
  await close();
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, ...options });
  page = await context.newPage();
  seen = { elsewhere: [], complaints: [] };
  const { origin } = new URL(address);
  page.on("request", request => {
    if (!request.url().startsWith(`${origin}/`) && !request.url().startsWith("data:")) seen.elsewhere.push(request.url());
  });
  page.on("console", message => {
    if (["error", "warning"].includes(message.type())) seen.complaints.push(message.text());
  });
  page.on("pageerror", error => seen.complaints.push(String(error)));
  await page.goto(address);
  return null;
}

async function picture(path) {
  await page.screenshot({ path, fullPage: true });
  return null;
}

async function choose([selector, value]) {
  await page.selectOption(selector, value);
  return null;
}

function obey(order) {
  if (order.open) return open(order.open, order.options ?? {});
  if (order.close) return close();
  if (order.evaluate) return page.evaluate(order.evaluate);
  if (order.choose) return choose(order.choose);
  if (order.reload) return page.reload().then(() => null);
  if (order.picture) return picture(order.picture);
  return order.judge ? findingsOfAxe(page) : seen;
}

for await (const line of createInterface({ input: process.stdin })) {
  let answer;
  try {
    answer = { value: await obey(JSON.parse(line)) ?? null };
  } catch (error) {
    answer = { error: String(error) };
  }
  console.log(JSON.stringify(answer));
}
await browser.close();
