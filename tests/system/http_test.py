"""The daemon's HTTP port beside its Modbus server: the same values, seen by a Prometheus parser and a plain client, and
what slow, broken and stuck clients can do to it.

http_test.py DAEMON MAKE_SMALL_NETWORK [unittest options]
"""
import http.client
import json
import pathlib
import signal
import socket
import struct
import time
import tomllib
import urllib.error
import urllib.request

from prometheus_client.parser import text_string_to_metric_families

from ports import can_connect, free_port, wait_until
from running_daemon import RunningDaemon, main, run_daemon

FIRMWARE = pathlib.Path(__file__).resolve().parents[2] / "firmware"
WORDS = {"uint16": 1, "int16": 1, "offset16": 1, "uint32": 2, "int32": 2, "float32": 2, "float32_cdab": 2}
NOT_PRESENT = {"uint16": 0xFFFF, "int16": -0x8000, "offset16": -0x8000, "uint32": 0xFFFFFFFF, "int32": -0x80000000}
CHANGES_WITH_THE_ANSWER = {"prediction_age"}
KEY_POINTS = ["sleeve_inner", "sleeve_middle", "sleeve_outer"]


def decode(kind, words):
    """A register's number in counts; None: not present. From the map's documentation, not from our C++."""
    packed = struct.pack(f">{len(words)}H", *(reversed(words) if kind == "float32_cdab" else words))
    if kind.startswith("float32"):
        value, = struct.unpack(">f", packed)
        return None if value != value else value
    value, = struct.unpack({"uint16": ">H", "offset16": ">H", "int16": ">h", "uint32": ">I", "int32": ">i"}[kind], packed)
    if kind == "offset16":
        value -= 0x8000
    return None if value == NOT_PRESENT[kind] else value


class Http(RunningDaemon):
    def setUp(self):
        super().setUp()
        self.http_port = free_port()
        self.config.write_text(self.config.read_text() + f"[http]\nport = {self.http_port}\n")
        self.daemon.terminate()
        self.daemon.wait(20)
        self.start_again()
        wait_until(lambda: can_connect(self.http_port), "the HTTP port")

    def url(self, path):
        return f"http://127.0.0.1:{self.http_port}{path}"

    def get(self, path, method="GET", body=None):
        """Status, headers and body."""
        request = urllib.request.Request(self.url(path), data=body, method=method)
        try:
            with urllib.request.urlopen(request, timeout=20) as reply:
                return reply.status, reply.headers, reply.read().decode()
        except urllib.error.HTTPError as reply:
            return reply.code, reply.headers, reply.read().decode()

    def state(self):
        status, headers, body = self.get("/api/v1/state")
        self.assertEqual((status, headers["Content-Type"]), (200, "application/json"))
        return json.loads(body)["registers"]

    def metrics(self):
        status, headers, body = self.get("/metrics")
        self.assertEqual((status, headers["Content-Type"]), (200, "text/plain; version=0.0.4; charset=utf-8"))
        return {sample.name + "".join(f"/{value}" for _, value in sorted(sample.labels.items())): sample.value
                for family in text_string_to_metric_families(body) for sample in family.samples}

    def run_well(self):
        self.write_signals()
        self.wait_for_state(1)

    def raw(self, text, seconds=20.0):
        """All that comes back until the server closes."""
        with socket.create_connection(("127.0.0.1", self.http_port), timeout=seconds) as client:
            client.sendall(text)
            answer = b""
            while part := client.recv(65536):
                answer += part
            return answer

    def block(self, block):
        """The words of a block, and the sequence that it says."""
        words = self.read(block["address"], block["length"])
        at = 8 if block["name"] == "prediction" else 0
        return words, words[at] << 16 | words[at + 1]

    def state_and_block_of_one_cycle(self, block):
        def both():
            state = self.state()
            words, sequence = self.block(block)
            return (state, words) if state["sequence"]["value"] == sequence else None
        return wait_until(both, f"an answer of the same cycle by HTTP and Modbus for {block['name']}")


class Values(Http):
    def compare(self, register, shown, words, first):
        width = WORDS[register["type"]]
        slots = register["slots"] if isinstance(register.get("slots"), int) else None
        values = shown["values"] if "values" in shown else {"": shown["value"]}
        if slots:
            self.assertEqual(len(values), slots)
        values = list(values.values()) if isinstance(values, dict) else values
        for slot, value in enumerate(values):
            at = register["address"] - first + slot * width
            count = decode(register["type"], words[at:at + width])
            if register["name"] == "heartbeat":
                count = words[at]
            if count is None:
                self.assertIsNone(value, register["name"])
            elif register["type"].startswith("float32"):
                self.assertEqual(struct.pack(">f", value), struct.pack(">f", count), register["name"])
            else:
                self.assertAlmostEqual(value, count * register.get("resolution", 1.0), delta=1e-9 * max(1.0, abs(count)),
                                       msg=register["name"])
            self.assertEqual(shown.get("unit", ""), register.get("unit", ""), register["name"])

    def test_every_register_is_shown_with_the_value_that_modbus_reads_in_the_same_cycle(self):
        self.run_well()
        with open(FIRMWARE / "serve" / "registers.toml", "rb") as file:
            blocks = [block for block in tomllib.load(file)["block"] if not block["command"]]
        shown_names = {register["name"] for block in blocks for register in block["register"]}
        self.assertEqual(set(self.state()), shown_names)
        for block in blocks:
            state, words = self.state_and_block_of_one_cycle(block)
            for register in block["register"]:
                if register["name"] not in CHANGES_WITH_THE_ANSWER:
                    self.compare(register, state[register["name"]], words, block["address"])

    def test_codes_and_bits_have_their_names_and_slots_the_networks(self):
        self.run_well()
        state = self.state()
        self.assertEqual(state["state"], {"value": 1, "name": "running"})
        self.assertEqual(state["quality"], {"value": 0, "set": []})
        self.assertEqual(list(state["key_point_predicted"]["values"]), KEY_POINTS)
        self.assertEqual(state["key_point_measured"]["values"], dict(zip(KEY_POINTS, (28.5, 28.25, 28.0))))
        self.assertEqual(state["sensor_quality"]["names"], dict.fromkeys(KEY_POINTS, "good"))
        self.device.kill()
        wait_until(lambda: "device_offline" in self.state()["quality"]["set"], "the device to be missed")
        self.assertEqual(self.state()["state"]["name"], "degraded")

    def test_metrics_are_in_base_units_and_count(self):
        self.run_well()
        def same_cycle():
            before, metrics, after = self.state(), self.metrics(), self.state()
            return (before, metrics) if before["sequence"] == after["sequence"] else None
        state, metrics = wait_until(same_cycle, "state and metrics of one cycle")
        self.assertAlmostEqual(metrics["spindle_twin_nose_meters"], 1e-6 * state["nose_float32"]["value"],
                               delta=1e-12)
        self.assertEqual(metrics["spindle_twin_key_point_measured_celsius/sleeve_middle"], 28.25)
        self.assertEqual(metrics["spindle_twin_speed_revolutions_per_minute"], 6000)
        self.assertEqual(metrics["spindle_twin_load_ratio"], 1.0)
        self.assertEqual(metrics["spindle_twin_state"], 1)
        self.assertEqual(metrics["spindle_twin_fault/orders_lost"], 0)
        self.assertEqual(metrics["spindle_twin_overruns_total"], state["overruns"]["value"])
        self.assertEqual(metrics["spindle_twin_history_rows_lost_total"], 0)
        self.assertEqual(metrics["spindle_twin_log_lines_dropped_total"], 0)
        self.assertNotIn("spindle_twin_motor_current_amperes", metrics)
        asked = metrics["spindle_twin_http_requests_total/200"]
        self.assertGreater(self.metrics()["spindle_twin_http_requests_total/200"], asked)

    def test_healthz_says_whether_the_prediction_may_be_used(self):
        self.run_well()
        self.assertEqual(self.get("/healthz")[0], 200)
        self.daemon.kill()
        self.daemon.wait()
        self.device.kill()
        self.device.wait()
        (self.folder / "twin.checkpoint").unlink(missing_ok=True)
        self.start_again()
        wait_until(lambda: can_connect(self.http_port), "the HTTP port")
        status, _, body = self.get("/healthz")
        self.assertEqual((status, list(json.loads(body))), (503, ["error"]))


class Protocol(Http):
    def test_the_list_names_every_route_and_each_answers(self):
        status, _, body = self.get("/routes")
        self.assertEqual(status, 200)
        routes = [line.split()[0] for line in body.splitlines() if line.startswith("/")]
        self.assertEqual(routes, ["/", "/commissioning", "/routes", "/healthz", "/api/v1/spindles", "/api/v1/words", "/api/v1/scene",
                                  "/api/v1/state", "/api/v1/events", "/api/v1/session", "/api/v1/login", "/api/v1/logout",
                                  "/api/v1/command", "/api/v1/history/{HOURS}", "/api/v1/growth", "/metrics"])
        for route in routes:
            if route == "/api/v1/history/{HOURS}":
                self.assertEqual(self.get("/api/v1/history/1")[0], 404, "the history of this daemon is a CSV file")
            elif route == "/api/v1/growth":
                self.assertEqual(self.get(route)[0], 404, "likewise")
            elif route in ("/api/v1/login", "/api/v1/logout", "/api/v1/command"):
                self.assertEqual(self.get(route)[0], 403, "no commands are configured")
            elif route != "/api/v1/events":
                self.assertIn(self.get(route)[0], (200, 503), route)

    def test_what_is_not_there_is_404_and_what_would_change_something_405(self):
        for path in ("/nothing", "/api/v1", "/api/v1/state/", "/%2e%2e/etc/passwd", "/a?b=" + "c" * 4000):
            status, headers, body = self.get(path)
            self.assertEqual((status, headers["Content-Type"], list(json.loads(body))), (404, "application/json", ["error"]))
        for method in ("POST", "PUT", "PATCH", "DELETE", "OPTIONS", "TRACE"):
            body = b"x" * 100_000 if method in ("POST", "PUT") else None
            status, headers, body = self.get("/api/v1/state", method, body)
            self.assertEqual((status, headers["Allow"], list(json.loads(body))), (405, "GET, HEAD", ["error"]), method)

    def test_head_is_get_without_the_body_and_a_query_is_of_no_account(self):
        client = http.client.HTTPConnection("127.0.0.1", self.http_port, timeout=20)
        client.request("HEAD", "/api/v1/state?x=1", headers={"Range": "bytes=0-9", "Accept-Encoding": "gzip, br"})
        reply = client.getresponse()
        self.assertEqual(reply.status, 200)
        self.assertGreater(int(reply.headers["Content-Length"]), 1000)
        self.assertIsNone(reply.headers["Content-Encoding"])
        self.assertEqual(reply.read(), b"")
        self.assertEqual(self.raw(b"HEAD /api/v1/events HTTP/1.1\r\n\r\n").count(b"\ndata:"), 0)

    def test_what_is_no_request_is_refused_and_a_long_one_too(self):
        for text in (b"hello\r\n\r\n", b"GET\r\n\r\n", b"\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n",
                     bytes(range(256)).replace(b"\r", b"") + b"\r\n\r\n", b"GET / HTTP/1.1\r\nno colon\r\n\r\n"):
            self.assertRegex(self.raw(text), rb"^(HTTP/1.1 (400|200|404|405) |$)")
        for text in (b"GET /" + b"a" * 9000, b"GET / HTTP/1.1\r\nx: " + b"y" * 9000 + b"\r\n\r\n"):
            self.assertTrue(self.raw(text).startswith(b"HTTP/1.1 431 "))
        self.assertEqual(self.get("/")[0], 200)

    def test_who_is_not_allowed_is_not_answered(self):
        self.config.write_text(self.config.read_text() + 'allow = ["192.0.2.0/24"]\n')
        self.daemon.terminate()
        self.daemon.wait(20)
        self.start_again()
        wait_until(lambda: can_connect(self.http_port), "the HTTP port")
        try:
            self.assertEqual(self.raw(b"GET / HTTP/1.1\r\n\r\n"), b"")
        except ConnectionError:
            pass
        wait_until(lambda: "client 127.0.0.1 is not in http.allow" in self.log_text(), "the line in the log")

    def test_without_the_table_nobody_listens_and_a_port_that_is_taken_is_an_error_with_its_number(self):
        self.daemon.terminate()
        self.daemon.wait(20)
        with_http = self.config.read_text()
        self.config.write_text(with_http.split("[http]")[0])
        self.start_again()
        self.assertFalse(can_connect(self.http_port))
        self.daemon.terminate()
        self.daemon.wait(20)
        with socket.socket() as other:
            other.bind(("127.0.0.1", self.http_port))
            other.listen()
            self.config.write_text(with_http)
            result = run_daemon(self.config)
        self.assertEqual(result.returncode, 1)
        self.assertIn(f"cannot listen on 127.0.0.1 port {self.http_port}", result.stderr)


class Events(Http):
    def watch(self):
        client = socket.create_connection(("127.0.0.1", self.http_port), timeout=20)
        self.addCleanup(client.close)
        client.sendall(b"GET /api/v1/events HTTP/1.1\r\nAccept: text/event-stream\r\n\r\n")
        return client

    def test_each_event_is_a_state_and_there_is_at_most_one_a_second(self):
        self.run_well()
        lines = self.watch().makefile()
        self.assertIn(" 200 ", lines.readline())
        head = {line.split(":")[0].lower(): line.split(":", 1)[1].strip() for line in iter(lines.readline, "\n")}
        self.assertEqual(head["content-type"], "text/event-stream")
        self.assertNotIn("content-length", head)
        start = time.monotonic()
        numbers = []
        for _ in range(4):  # the cycle itself runs ten times a second
            event = dict(line.rstrip("\n").split(": ", 1) for line in iter(lines.readline, "\n"))
            registers = json.loads(event["data"])["registers"]
            self.assertEqual((event["event"], registers["sequence"]["value"]), ("state", int(event["id"])))
            numbers.append(int(event["id"]))
        self.assertGreaterEqual(time.monotonic() - start, 1.9, "the first may come at once")
        self.assertEqual(sorted(set(numbers)), numbers)

    def test_the_ninth_viewer_is_refused_and_one_that_goes_makes_room(self):
        viewers = [self.watch() for _ in range(8)]
        for viewer in viewers:
            self.assertIn(b" 200 ", viewer.recv(100))
        self.assertEqual(self.get("/api/v1/events")[0], 503)
        self.assertEqual(self.metrics()["spindle_twin_http_viewers"], 8)
        viewers[0].close()
        wait_until(lambda: self.metrics()["spindle_twin_http_viewers"] == 7, "the viewer to be gone")

    def test_a_viewer_that_reads_nothing_is_dropped_and_the_others_go_on(self):
        with socket.socket() as stuck:
            stuck.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
            stuck.connect(("127.0.0.1", self.http_port))
            stuck.sendall(b"GET /api/v1/events HTTP/1.1\r\n\r\n")
            good = self.watch()
            wait_until(lambda: self.metrics()["spindle_twin_http_viewers"] == 2, "both")
            def only_one():
                good.recv(1 << 20)
                return self.metrics()["spindle_twin_http_viewers"] == 1
            wait_until(only_one, "the stuck one to be dropped", 300)
            self.assertGreaterEqual(self.metrics()["spindle_twin_http_dropped_total"], 1)
            self.assertGreater(len(good.recv(1 << 20)), 0)

    def test_the_daemon_stops_with_open_streams_and_half_requests(self):
        viewers = [self.watch() for _ in range(8)]
        half = socket.create_connection(("127.0.0.1", self.http_port))
        self.addCleanup(half.close)
        half.sendall(b"GET /api")
        for viewer in viewers:
            self.assertIn(b" 200 ", viewer.recv(100))
        self.daemon.send_signal(signal.SIGTERM)
        self.assertEqual(self.daemon.wait(20), 0)
        self.assertRegex(self.log_text().splitlines()[-1], "stopped by SIGTERM$")


class SlowClients(Http):
    def cycles_missed(self, meanwhile):
        """During 100 answers by Modbus and HTTP, beside what else is done."""
        before = self.state()["overruns"]["value"]
        for _ in range(100):
            meanwhile()
            self.assertEqual(self.read(0, 1), [0x1234])
            self.assertEqual(self.get("/healthz")[0], 200)
            time.sleep(0.02)
        return self.state()["overruns"]["value"] - before

    def test_32_slow_clients_cost_neither_a_cycle_nor_an_answer(self):
        self.run_well()
        alone = self.cycles_missed(lambda: None)
        slow = []
        def drip():
            for client in slow:
                try:
                    client.send(b"G")
                except OSError:
                    pass
        for _ in range(32):
            client = socket.create_connection(("127.0.0.1", self.http_port))
            self.addCleanup(client.close)
            slow.append(client)
        sequence = self.state()["sequence"]["value"]
        beside = self.cycles_missed(drip)
        self.assertGreater(self.state()["sequence"]["value"], sequence)
        # A machine that is busy with other work may miss one by itself.
        self.assertLessEqual(beside, alone + 2)
        wait_until(lambda: self.metrics()["spindle_twin_http_dropped_total"] >= 32, "the slow ones to be dropped")
        self.assertLessEqual(self.metrics()["spindle_twin_http_connections"], 32)


if __name__ == "__main__":
    main()
