// PNGs of pages as a desktop and a phone show them, light and dark, for looking at.
//   node tests/pages/take_pictures.js FOLDER PAGE.html...
import { basename, join } from "node:path";
import { openPage, startBrowser } from "./browser.js";

const [folder, ...files] = process.argv.slice(2);
if (!files.length) {
  console.error("usage: node tests/pages/take_pictures.js FOLDER PAGE.html...");
  process.exit(2);
}
const windows = { desktop: { viewport: { width: 1280, height: 900 } },
  phone: { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, hasTouch: true, isMobile: true } };
const browser = await startBrowser();
for (const file of files) {
  for (const [name, window] of Object.entries(windows)) {
    for (const colorScheme of ["light", "dark"]) {
      const { page, complaints } = await openPage(browser, file, { ...window, colorScheme });
      const path = join(folder, `${basename(file, ".html")}_${name}_${colorScheme}.png`);
      await page.screenshot({ path, fullPage: true });
      console.log([path, ...complaints].join("\n  "));
      await page.context().close();
    }
  }
}
await browser.close();
