// The Modbus clients of npm, driven by lines of JSON: npm_clients.js NAME PORT [CA CERTIFICATE KEY], NAME modbus-serial or
// jsmodbus; that one by TLS where it gets the three files.
// In: {"unit", "pdu": [bytes]} or {"table", "offset", "kind"}. Out: {"kind", "detail"} as promises.py has it, or {"value"}.
import { readFileSync } from "node:fs";
import { Socket } from "node:net";
import { createInterface } from "node:readline";
import { connect as connectByTls } from "node:tls";
import jsmodbus from "jsmodbus";
import ModbusSerial from "modbus-serial";

const patience_ms = 10000;
const [name, port, ...files] = process.argv.slice(2);
const wide = { uint32: 2, int32: 2, float32: 2, float32_cdab: 2 };
const word = (pdu, at) => (pdu[at] << 8) | pdu[at + 1];
const words = (bytes) => Array.from({ length: bytes.length / 2 }, (_, n) => word(bytes, 2 * n));
const noCall = { kind: "no call" };

// What neither client lets one say: a byte count that contradicts the quantity, another MEI type than 14.
const unspeakable = (pdu) => (pdu[0] === 16 && pdu[5] !== 2 * word(pdu, 3)) || (pdu[0] === 43 && pdu[1] !== 14);

// Reads a value from the bytes that the client gives; a float with its words exchanged is one read from the end.
function decoded(buffer, kind) {
  const read = { uint16: "readUInt16BE", offset16: "readUInt16BE", int16: "readInt16BE", uint32: "readUInt32BE",
    int32: "readInt32BE", float32: "readFloatBE" };
  return kind === "float32_cdab" ? Buffer.from(buffer).swap16().readFloatLE(0) : buffer[read[kind]](0);
}

async function modbusSerial() {
  const client = new ModbusSerial();
  await client.connectTCP("127.0.0.1", { port: Number(port) });
  client.setTimeout(patience_ms);
  // Without FC17: reportServerID never settles when the answer is an exception (8.0.25).
  const calls = {
    1: (pdu) => client.readCoils(word(pdu, 1), word(pdu, 3)),
    2: (pdu) => client.readDiscreteInputs(word(pdu, 1), word(pdu, 3)),
    3: (pdu) => client.readHoldingRegisters(word(pdu, 1), word(pdu, 3)),
    4: (pdu) => client.readInputRegisters(word(pdu, 1), word(pdu, 3)),
    5: (pdu) => client.writeCoil(word(pdu, 1), true),
    6: (pdu) => client.writeRegister(word(pdu, 1), word(pdu, 3)),
    15: (pdu) => client.writeCoils(word(pdu, 1), [true]),
    16: (pdu) => client.writeRegisters(word(pdu, 1), words(pdu.slice(6))),
    20: () => client.readFileRecords(1, 0),
    22: (pdu) => client.maskWriteRegister(word(pdu, 1), word(pdu, 3), word(pdu, 5)),
    23: (pdu) => client.readWriteRegisters(word(pdu, 1), word(pdu, 3), word(pdu, 5), word(pdu, 7), words(pdu.slice(10))),
    43: (pdu) => client.readDeviceIdentification(pdu[2], pdu[3]),
    65: (pdu) => client.customFunction(65, pdu.slice(1)),
  };
  return {
    async ask(unit, pdu) {
      const call = calls[pdu[0]];
      if (!call || unspeakable(pdu)) return noCall;
      client.setID(unit);
      try {
        const reply = await call(pdu);
        if ([3, 4, 23].includes(pdu[0])) return { kind: "words", detail: reply.data };
        return pdu[0] === 43 ? { kind: "objects", detail: Object.keys(reply.data).map(Number) } : { kind: "done" };
      } catch (error) {
        if (error.modbusCode) return { kind: "exception", detail: error.modbusCode };
        if (!client.isOpen) {
          await client.connectTCP("127.0.0.1", { port: Number(port) });
          return { kind: "closed" };
        }
        return { kind: "own refusal", detail: String(error.message ?? error) };
      }
    },
    async value(table, offset, kind) {
      client.setID(1);
      const read = table === 4 ? "readHoldingRegisters" : "readInputRegisters";
      return decoded((await client[read](offset, wide[kind] ?? 1)).buffer, kind);
    },
  };
}

function begunByTls() {
  const [ca, cert, key] = files.map((file) => readFileSync(file));
  return connectByTls({ port: Number(port), host: "127.0.0.1", servername: "edge-7", ca, cert, key });
}

async function jsModbus() {
  const clients = new Map();
  // A client has one unit and believes that all that comes over its socket is for it: a socket for each unit. It goes
  // by the socket's events, so it is there before the connection.
  const clientOf = async (unit) => {
    if (clients.has(unit) && !clients.get(unit).socket.destroyed) return clients.get(unit);
    const socket = files.length > 0 ? begunByTls() : new Socket();
    const client = new jsmodbus.client.TCP(socket, unit, patience_ms);
    clients.set(unit, client);
    socket.on("error", () => socket.destroy());
    await new Promise((resolve) => {
      if (files.length > 0) socket.once("secureConnect", resolve);
      else socket.connect({ port: Number(port), host: "127.0.0.1" }, resolve);
    });
    return client;
  };
  const calls = {
    1: (client, pdu) => client.readCoils(word(pdu, 1), word(pdu, 3)),
    2: (client, pdu) => client.readDiscreteInputs(word(pdu, 1), word(pdu, 3)),
    3: (client, pdu) => client.readHoldingRegisters(word(pdu, 1), word(pdu, 3)),
    4: (client, pdu) => client.readInputRegisters(word(pdu, 1), word(pdu, 3)),
    5: (client, pdu) => client.writeSingleCoil(word(pdu, 1), true),
    6: (client, pdu) => client.writeSingleRegister(word(pdu, 1), word(pdu, 3)),
    15: (client, pdu) => client.writeMultipleCoils(word(pdu, 1), [true]),
    16: (client, pdu) => client.writeMultipleRegisters(word(pdu, 1), words(pdu.slice(6))),
    43: (client, pdu) => client.readDeviceIdentification(pdu[2], pdu[3]),
  };
  return {
    async ask(unit, pdu) {
      const call = calls[pdu[0]];
      // With more than 120 registers it writes another length into the header than it sends (5.0.0).
      if (!call || unspeakable(pdu) || (pdu[0] === 16 && pdu[5] > 240)) return noCall;
      const client = await clientOf(unit);
      try {
        const { body } = (await call(client, pdu)).response;
        if ([3, 4].includes(pdu[0])) return { kind: "words", detail: words([...body.valuesAsBuffer]) };
        return pdu[0] === 43 ? { kind: "objects", detail: body.objects.map((each) => each.id) } : { kind: "done" };
      } catch (error) {
        if (error.err === "ModbusException") return { kind: "exception", detail: error.response.body.code };
        if (client.socket.destroyed || error.err === "Offline") return { kind: "closed" };
        return { kind: "own refusal", detail: String(error.message ?? error) };
      }
    },
    async value(table, offset, kind) {
      const client = await clientOf(1);
      const read = table === 4 ? "readHoldingRegisters" : "readInputRegisters";
      return decoded((await client[read](offset, wide[kind] ?? 1)).response.body.valuesAsBuffer, kind);
    },
  };
}

const asked = await { "modbus-serial": modbusSerial, jsmodbus: jsModbus }[name]();
for await (const line of createInterface({ input: process.stdin })) {
  const order = JSON.parse(line);
  const answer = order.pdu
    ? await asked.ask(order.unit, order.pdu)
    : { value: await asked.value(order.table, order.offset, order.kind) };
  process.stdout.write(`${JSON.stringify(answer)}\n`);
}
process.exit(0);
