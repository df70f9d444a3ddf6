// Sparkplug B payloads, decoded by npm's sparkplug-payload: a payload in hex per line in, JSON per line out. Numbers of
// 64 bits become plain ones.
import { createInterface } from "node:readline";
import sparkplug from "sparkplug-payload";

const decoder = sparkplug.get("spBv1.0");
const plain = (key, value) => (value !== null && typeof value === "object" && "low" in value && "high" in value
  ? value.high * 2 ** 32 + (value.low >>> 0) : value);

createInterface({ input: process.stdin }).on("line", (line) => {
  process.stdout.write(`${JSON.stringify(decoder.decodePayload(Buffer.from(line, "hex")), plain)}\n`);
});
