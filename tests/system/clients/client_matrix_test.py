"""Each request and each value of firmware/serve/README.md, asked by each Modbus client that a PLC programmer may have
at hand, and the whole conversation judged by Wireshark's dissector.

client_matrix_test.py DAEMON MAKE_SMALL_NETWORK [unittest options]; prints the matrix.
"""
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE)]

from capture_judgement import judge  # noqa: E402
from npm_client import NpmClient  # noqa: E402
from ports import wait_until  # noqa: E402
from promises import Outcome, keeps, register_map, requests, values  # noqa: E402
from python_clients import HOLDING, INPUT, Libmodbus, Mbpoll, Pymodbus, RawClient  # noqa: E402
from recording_relay import RecordingRelay  # noqa: E402
from running_daemon import RunningDaemon, main  # noqa: E402

QUEUE, TARE = 64, 1005  # orders that wait at most; a register that takes them
KEPT, NO_CALL, OWN_REFUSAL = "ok", "-", "self"
# The functions that each client has a call for; so no cell of the matrix is empty by mistake.
FUNCTIONS = {
    "bytes": {0, 1, 2, 3, 4, 5, 6, 7, 8, 15, 16, 17, 20, 22, 23, 24, 43, 65, 0x84},
    "libmodbus": {1, 2, 3, 4, 5, 6, 7, 8, 15, 16, 17, 20, 22, 23, 24, 65},
    "mbpoll": {1, 2, 3, 4, 5, 6, 15, 16},
    "pymodbus": {1, 2, 3, 4, 5, 6, 7, 8, 15, 16, 17, 20, 22, 23, 24, 43},
    "modbus-serial": {1, 2, 3, 4, 5, 6, 15, 16, 20, 22, 23, 43, 65},
    "jsmodbus": {1, 2, 3, 4, 5, 6, 15, 16, 43},
}


class Matrix(RunningDaemon):
    maxDiff = None

    def setUp(self):
        if not (HERE / "node_modules").exists():
            self.fail("the packages of tests/system/clients are missing: host_tools/setup tests")
        super().setUp()
        self.config.write_text(self.config.read_text().replace("clock_rate = 10.0", "period_s = 0.5")
                               + "[compensation]\nsign = -1\n")
        self.client.close()
        self.daemon.terminate()
        self.daemon.wait(20)
        self.start_again()
        self.relay = RecordingRelay(self.port, self.folder / "conversations.pcap")
        self.addCleanup(self.end_recording)
        self.direct = RawClient(self.port)

    def end_recording(self):
        if self.relay.open:
            self.relay.close()

    def clients(self):
        kinds = [RawClient, Libmodbus, Mbpoll, Pymodbus, lambda port: NpmClient("modbus-serial", port),
                 lambda port: NpmClient("jsmodbus", port)]
        for kind in kinds:
            client = kind(self.relay.port)
            try:
                yield client
            finally:
                client.close()

    def judge_conversations(self):
        self.relay.close()
        answers, complaints = judge(self.relay.capture.file.name)
        print(f"tshark: {answers} answers, {len(complaints)} complaints")
        self.assertEqual(complaints, [])
        return answers

    def print_matrix(self, head, rows):
        names = list(FUNCTIONS)
        width = max(len(row[0]) for row in rows)
        print(f"\n{head:<{width}}  " + "  ".join(names))
        for title, cells in rows:
            print(f"{title:<{width}}  " + "  ".join(f"{cells[name]:<{len(name)}}" for name in names).rstrip())

    def test_each_request_is_answered_to_each_client_as_the_table_says(self):
        asked = requests()
        table = [(f"{request.name} (unit {request.unit})", {}) for request in asked]
        wrong, sent = [], 0
        for client in self.clients():
            for request, (_, cells) in zip(asked, table):
                outcome = client.ask(request.unit, request.pdu)
                kind = outcome.kind if outcome else "no answer to this request"
                if outcome and keeps(request.answer, outcome):
                    cells[client.name] = KEPT
                    sent += 1
                elif kind == "no call":
                    cells[client.name] = NO_CALL
                    self.direct.ask(request.unit, request.pdu)  # what follows may read what it left
                elif kind == "own refusal" and self.may_refuse(client.name, request):
                    cells[client.name] = OWN_REFUSAL
                else:
                    cells[client.name] = "WRONG"
                    wrong.append(f"{client.name}, {request.name}: {outcome}, promised: {request.answer}")
            served = {request.pdu[0] for request, (_, cells) in zip(asked, table) if cells[client.name] == KEPT}
            with self.subTest(client=client.name):
                self.assertEqual(served, FUNCTIONS[client.name])
        self.print_matrix("request", table)
        self.assertEqual(wrong, [])
        self.assertTrue(all(cells["bytes"] == KEPT for _, cells in table))
        self.assertGreaterEqual(self.judge_conversations(), sent - len(FUNCTIONS))

    def may_refuse(self, name, request):
        """Clients that look at quantity and address themselves; what they let pass is up to them."""
        return name != "bytes" and re.match(r"exception [23]|close", request.answer) is not None

    def value_around(self, offset, kind, read):
        """What `read` gives while the register stays what it was before and after; with what it was."""
        def told():
            before = self.direct.value(INPUT, offset, kind)
            shown = read()
            return (shown, before) if before == self.direct.value(INPUT, offset, kind) else None
        return wait_until(told, f"a reading of the {kind} at {offset} between two cycles")

    def test_each_client_decodes_each_type_in_each_way_of_counting(self):
        self.write_signals()
        self.wait_for_state(1)
        registers = register_map()
        offset_of = {kind: int(registers[name]["offset"]) for kind, (name, _) in values().items()}
        wait_until(lambda: self.direct.value(INPUT, offset_of["int32"], "int32") < -10, "a growth")
        ways = [("offset", INPUT), ("offset", HOLDING), ("number", INPUT), ("number", HOLDING)]
        table = [(f"{kind}, {way} {'3' if place == INPUT else '4'}xxxx", {}) for kind in offset_of for way, place in ways]
        for client in self.clients():
            cells = iter(table)
            for kind, (name, known) in values().items():
                self.assertEqual(registers[name]["type"], kind)
                for way, place in ways:
                    column = "input_register" if place == INPUT else "holding_register"
                    digit, number = divmod(int(registers[name][column]), 10000)
                    self.assertEqual(digit, place)
                    if way == "number" and isinstance(client, Mbpoll):
                        read = lambda: client.value_at_number(digit, number, kind)
                    else:
                        at = number - 1 if way == "number" else offset_of[kind]
                        read = lambda: client.value(place, at, kind)
                    shown, stood = self.value_around(offset_of[kind], kind, read)
                    row, row_cells = next(cells)
                    with self.subTest(client=client.name, value=row):
                        self.assertEqual(shown, stood)
                        self.assertTrue(known is None or shown == known, shown)
                    row_cells[client.name] = KEPT
        self.print_matrix("value", table)
        words_read = self.read(15, 2)
        self.assertEqual(words_read[1], (words_read[0] ^ 0x8000))
        self.judge_conversations()

    def test_orders_beyond_the_queue_are_answered_with_busy_to_each_client(self):
        self.write_signals()
        self.wait_for_state(1)
        order = bytes([6, TARE >> 8, TARE & 255, 0, 1])
        for client in self.clients():
            def asked_at_a_full_queue():
                for _ in range(QUEUE):
                    if self.direct.ask(1, order).kind == "exception":
                        break
                outcome = client.ask(1, order)
                self.assertIn(outcome, (Outcome("done"), Outcome("exception", 6)))
                return outcome.kind == "exception"  # else a cycle took an order out meanwhile
            wait_until(asked_at_a_full_queue, f"exception 6 to {client.name}")
        self.judge_conversations()

    def nmap(self, *arguments):
        command = ["nmap", "-n", "-Pn", "-sT", "-p", str(self.relay.port), "--script", "+modbus-discover", *arguments]
        return subprocess.run([*command, "127.0.0.1"], capture_output=True, text=True, timeout=200).stdout

    def test_nmap_discovers_unit_1_by_its_identification_and_no_unit_behind_it(self):
        found = self.nmap()
        self.assertRegex(found, r"sid 0x1:\s+\|\s+error: ILLEGAL FUNCTION")
        self.assertRegex(found, r"Device identification: spindle-twin spindle-twind \d+\.\d+")
        everywhere = self.nmap("--script-args", "modbus-discover.aggressive=true")
        self.assertEqual(len(re.findall("GATEWAY TARGET DEVICE FAILED TO RESPOND", everywhere)), 245)
        self.assertEqual(everywhere.count("Device identification"), 1)
        self.assertGreater(self.judge_conversations(), 2 * 245)


if __name__ == "__main__":
    main()
