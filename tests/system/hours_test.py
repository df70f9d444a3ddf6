"""Hours and days of the history by HTTP, beside what SQLite itself says of the same file; many that ask at once, clients
that go, a file that is lost.

hours_test.py DAEMON MAKE_SMALL_NETWORK [unittest options]
"""
import json
import signal
import socket
import sqlite3
import time

from http_test import Http
from ports import can_connect, wait_until
from running_daemon import CONFIG, main


class Hours(Http):
    config_text = CONFIG.replace('"history.csv"', '"history.sqlite"')

    def hours(self, count=1):
        status, headers, body = self.get(f"/api/v1/history/{count}")
        self.assertEqual((status, headers["Content-Type"]), (200, "application/json"), body)
        return json.loads(body)

    def test_what_the_history_holds_is_shown_thinned_with_a_gap_between_two_runs(self):
        self.run_well()
        wait_until(lambda: len(self.hours()["unix_s"]) >= 2, "two spans of the history")
        self.daemon.terminate()
        self.daemon.wait(20)
        time.sleep(13)  # two spans without a row
        self.start_again()
        wait_until(lambda: can_connect(self.http_port), "the HTTP port")
        def gone_on():
            mean = self.hours()["columns"]["measured.sleeve_middle_degC"]["mean"]
            return mean if None in mean[:-1] and mean[-1] is not None else None
        self.assertEqual(wait_until(gone_on, "the second run").count(None), 1)
        with sqlite3.connect(f"file:{self.folder / 'history.sqlite'}?mode=ro", uri=True) as file:
            for count, span_s in ((1, 6), (8, 48), (24, 144), (168, 1008)):
                complete_s = time.time() - 2  # rows of before are written
                shown = self.hours(count)
                self.assertEqual((shown["hours"], shown["span_s"], shown["is_whole"]), (count, span_s, True))
                self.assertEqual(shown["unix_s"], sorted(shown["unix_s"]))
                begun = shown["unix_s"][-1] // span_s * span_s
                if begun + span_s > complete_s:
                    begun -= span_s
                for name in ("nose_um", "measured.sleeve_middle_degC", "predicted_sd.sleeve_outer_K"):
                    found = file.execute(f'SELECT avg(unix_s), min("{name}"), avg("{name}"), max("{name}") FROM cycle '
                                         "WHERE unix_s >= ? AND unix_s < ?", (begun, begun + span_s)).fetchone()
                    at = [i for i, at_s in enumerate(shown["unix_s"]) if found[0] and abs(at_s - found[0]) < 0.06]
                    for place in at:
                        got = [shown["columns"][name][kind][place] for kind in ("min", "mean", "max")]
                        for value, expected in zip(got, found[1:]):
                            self.assertAlmostEqual(value, expected, delta=0.001, msg=name)
                    self.assertEqual(len(at), 1 if found[0] else 0)
        self.assertEqual(json.loads(self.get("/api/v1/scene")[2])["has_history"], True)

    def test_other_hours_are_refused_with_what_is_allowed_and_a_lost_file_is_an_error_in_words(self):
        for hours in ("2", "0", "-1", "1.0", "01", "1/", "", "%31x", "99999999999999999999", "day"):
            status, _, body = self.get(f"/api/v1/history/{hours}")
            self.assertEqual((status, json.loads(body)["error"]), (400, "hours: allowed are 1, 8, 24, 168"), hours)
        self.assertEqual(self.get("/api/v1/history")[0], 404)
        self.assertEqual(self.get("/api/v1/history/1", "POST", b"")[0], 405)
        (self.folder / "history.sqlite").unlink()
        status, _, body = self.get("/api/v1/history/8")
        self.assertEqual(status, 500)
        self.assertIn("history.sqlite: cannot be read as a history in SQLite", json.loads(body)["error"])
        self.assertEqual(self.get("/")[0], 200)

    def test_clients_that_go_make_room_and_of_many_at_once_each_gets_its_hours(self):
        self.run_well()
        for _ in range(40):
            with socket.create_connection(("127.0.0.1", self.http_port)) as client:
                client.sendall(b"GET /api/v1/history/168 HTTP/1.1\r\n\r\n")
        wait_until(lambda: self.get("/api/v1/history/1")[0] == 200, "room where nobody waits any more")
        clients = [socket.create_connection(("127.0.0.1", self.http_port), timeout=60) for _ in range(20)]
        for client in clients:
            self.addCleanup(client.close)
            client.sendall(b"GET /api/v1/history/24 HTTP/1.1\r\n\r\n")
        before = self.state()["sequence"]["value"]
        answers = {client.recv(100).split()[1] for client in clients}
        self.assertEqual(answers, {b"200"})
        wait_until(lambda: self.state()["sequence"]["value"] > before, "the cycle to go on")
        wait_until(lambda: self.get("/api/v1/history/1")[0] == 200, "room again")

    def test_the_daemon_stops_while_hours_are_asked_for(self):
        self.run_well()
        for _ in range(8):
            client = socket.create_connection(("127.0.0.1", self.http_port))
            self.addCleanup(client.close)
            client.sendall(b"GET /api/v1/history/168 HTTP/1.1\r\n\r\n")
        self.daemon.send_signal(signal.SIGTERM)
        self.assertEqual(self.daemon.wait(20), 0)
        self.assertRegex(self.log_text().splitlines()[-1], "stopped by SIGTERM$")


if __name__ == "__main__":
    main()
