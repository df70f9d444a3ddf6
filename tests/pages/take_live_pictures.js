// PNGs of a daemon's live page after some seconds: desktop and phone, light and dark, and the top of it for a guide.
//   node tests/pages/take_live_pictures.js ADDRESS SECONDS FOLDER TOP.png
import { join } from "node:path";
import { startBrowser } from "./browser.js";

const [address, seconds, folder, top] = process.argv.slice(2);
if (!top) {
  console.error("usage: node tests/pages/take_live_pictures.js ADDRESS SECONDS FOLDER TOP.png");
  process.exit(2);
}
const desktop = { viewport: { width: 1240, height: 1460 } };
const phone = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, hasTouch: true, isMobile: true };
const browser = await startBrowser();
const pages = [];
for (const [name, window] of Object.entries({ desktop, phone })) {
  for (const colorScheme of ["light", "dark"]) {
    const page = await (await browser.newContext({ ...window, colorScheme })).newPage();
    page.on("console", message => console.log(`${name} ${colorScheme}: ${message.text()}`));
    await page.goto(address);
    pages.push({ page, name: `live_page_${name}_${colorScheme}.png` });
  }
}
await pages[0].page.waitForTimeout(1000 * Number(seconds));
await pages[0].page.screenshot({ path: top });
for (const { page, name } of pages) await page.screenshot({ path: join(folder, name), fullPage: true });
await browser.close();
