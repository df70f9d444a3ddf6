// Rules for the scripts of the pages and of all tests.
import js from "@eslint/js";

const names = list => Object.fromEntries(list.map(name => [name, "readonly"]));
const browser = names(["addEventListener", "document", "DOMPoint", "getComputedStyle", "matchMedia",
  "removeEventListener"]);

export default [
  { ignores: ["pages/uplot/"] },
  js.configs.recommended,
  {
    languageOptions: { ecmaVersion: 2022, sourceType: "module" },
    linterOptions: { reportUnusedDisableDirectives: "error" },
    rules: {
      complexity: ["error", 12],
      eqeqeq: "error",
      "max-len": ["error", 130],
      "max-lines": ["error", 400],
      "max-lines-per-function": ["error", 60],
      "max-params": ["error", 6],
      "no-shadow": "error",
      "no-var": "error",
      "prefer-const": "error",
    },
  },
  { files: ["pages/*.js", "host_tools/pages/*.js", "tests/bench/table/*.js"], languageOptions: { globals: browser } },
  { files: ["firmware/show/page/*.js"],
    languageOptions: {
      globals: { ...browser, ...names(["AbortSignal", "Blob", "fetch", "location", "sessionStorage", "setTimeout", "URL"]) } } },
  // The only script that knows the chart library.
  { files: ["pages/chart.js"], languageOptions: { globals: names(["ResizeObserver", "uPlot"]) } },
  { files: ["tests/pages/*.js", "tests/bench/table/take_picture.js"],
    languageOptions: { globals: { ...browser, ...names(["console", "process", "URL"]) } } },
  { files: ["tests/system/clients/*.js"], languageOptions: { globals: names(["Buffer", "console", "process"]) } },
];
