// The bars of a page of tests/bench/run as a picture, light.
//   node tests/bench/table/take_picture.js PAGE.html OUT.png
import { openPage, startBrowser } from "../../pages/browser.js";

const [file, target] = process.argv.slice(2);
if (!target) {
  console.error("usage: node tests/bench/table/take_picture.js PAGE.html OUT.png");
  process.exit(2);
}
const browser = await startBrowser();
const { page, complaints } = await openPage(browser, file, { viewport: { width: 1080, height: 900 }, deviceScaleFactor: 1.5 });
await page.addStyleTag({ content: "#picture { padding: 14px; }" });
await page.locator("#picture").screenshot({ path: target });
await browser.close();
if (complaints.length) {
  console.error(complaints.join("\n"));
  process.exit(1);
}
