"""Ten pages that are open at once, and clients that take nothing: what each reads is whole and the same, and the cycle misses
none for it.

viewers_test.py DAEMON MAKE_SMALL_NETWORK [unittest options]
"""
import json
import socket
import threading

from http_test import Http
from ports import wait_until
from running_daemon import CONFIG, main

VIEWERS, QUESTIONS = 10, 30
# What a page asks for, in its order; the state alone changes from cycle to cycle.
PATHS = ("/api/v1/spindles", "/api/v1/words", "/api/v1/scene", "/api/v1/history/8", "/")


class Viewers(Http):
    # A cycle of a second: on a busy machine a tenth may be missed for other reasons.
    config_text = CONFIG.replace("clock_rate = 10.0", "clock_rate = 1.0").replace('"history.csv"', '"history.sqlite"')

    def take_nothing(self, request):
        client = socket.socket()
        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
        client.connect(("127.0.0.1", self.http_port))
        client.sendall(request)
        self.addCleanup(client.close)

    def look(self, viewer, looking, seen):
        """One page: what does not change once, then the state again and again."""
        for path in PATHS:
            status, _, body = self.get(path)
            seen[viewer].append((path, status, body))
        for _ in range(QUESTIONS):
            status, _, body = self.get("/api/v1/state")
            seen[viewer].append(("state", status, body))
        looking.discard(viewer)

    def test_ten_viewers_and_stuck_ones_change_neither_missed_cycles_nor_each_others_answers(self):
        self.run_well()
        wait_until(lambda: self.get("/api/v1/history/8")[0] == 200, "the history's first rows", 60)
        missed = self.state()["overruns"]["value"]
        for path in (b"state", b"events", b"history/8", b"scene"):
            self.take_nothing(b"GET /api/v1/" + path + b" HTTP/1.1\r\n\r\n")
        self.take_nothing(b"GET /api/v1/sta")  # and one that never ends its question
        seen, looking = [[] for _ in range(VIEWERS)], set(range(VIEWERS))
        threads = [threading.Thread(target=self.look, args=(viewer, looking, seen)) for viewer in range(VIEWERS)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(120)
        self.assertEqual(looking, set(), "every viewer was answered to the end")
        self.assertEqual({status for answers in seen for _, status, _ in answers}, {200})
        self.assert_same_for_all(seen)
        self.assertEqual(self.state()["overruns"]["value"], missed)

    def assert_same_for_all(self, seen):
        constant, by_cycle = {}, {}
        for answers in seen:
            for path, _, body in answers:
                if path == "state":
                    registers = json.loads(body)["registers"]
                    registers.pop("prediction_age")  # of the moment of the answer
                    by_cycle.setdefault(registers["sequence"]["value"], set()).add(json.dumps(registers, sort_keys=True))
                elif path not in ("/api/v1/history/8", "/api/v1/spindles"):  # these move with the cycles
                    constant.setdefault(path, set()).add(body)
        self.assertEqual({path: len(bodies) for path, bodies in constant.items()}, dict.fromkeys(constant, 1))
        self.assertEqual({cycle: len(bodies) for cycle, bodies in by_cycle.items()}, dict.fromkeys(by_cycle, 1))
        order = [[json.loads(body)["registers"]["sequence"]["value"] for path, _, body in answers if path == "state"]
                 for answers in seen]
        self.assertEqual(order, [sorted(each) for each in order], "no viewer goes back in time")


if __name__ == "__main__":
    main()
