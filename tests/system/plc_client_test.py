"""The C client of host_tools/plc beside a daemon that runs, ends and comes back, and beside servers that are none.

plc_client_test.py DAEMON MAKE_SMALL_NETWORK CLIENT [unittest options]
"""
import errno
import os
import queue
import re
import socket
import struct
import subprocess
import threading
import time
import unittest

from ports import wait_until
from running_daemon import PROGRAMS, RunningDaemon, float32, main

COMPENSATION = 1508
LINE = re.compile(r"output_um=(\S+) counts=(\S+) valid=(\d) settled=(\d) limited=(\d) lost=(\d) reason=(\w+)\n")


class Client(RunningDaemon):
    def setUp(self):
        super().setUp()
        self.lines = queue.SimpleQueue()
        self.errors = open(self.folder / "client_log", "w+")
        self.addCleanup(self.errors.close)
        self.addCleanup(lambda: self.twin.stdout.close())  # after the client has ended, as the thread reads until then
        self.twin = self.start([PROGRAMS["client"], "127.0.0.1", self.port], stdout=subprocess.PIPE, stderr=self.errors, text=True)
        threading.Thread(target=self.collect, daemon=True).start()

    def collect(self):
        for line in self.twin.stdout:
            self.lines.put(line)

    def line(self):
        """The next line that the client prints."""
        match = LINE.fullmatch(self.lines.get(timeout=20))
        self.assertTrue(match)
        return {"um": float(match[1]), "counts": int(match[2]), "valid": match[3] == "1", "settled": match[4] == "1",
                "lost": match[6] == "1", "reason": match[7]}

    def test_it_follows_the_daemon_holds_while_it_is_gone_and_goes_on(self):
        self.assertIn(self.line()["reason"], ("state", "stale", "no_twin", "ok"))
        self.write_signals()
        self.wait_for_state(1)
        followed = wait_until(lambda: (lambda line: line if line["settled"] and line["um"] > 0.3 else None)(self.line()), "a growth")
        self.assertAlmostEqual(followed["um"], float32(*self.read(COMPENSATION, 2)), delta=0.6)
        self.assertAlmostEqual(followed["counts"], followed["um"], delta=0.501)
        self.daemon.kill()
        self.daemon.wait(20)
        gone = wait_until(lambda: (lambda line: None if line["valid"] else line)(self.line()), "the loss")
        self.assertEqual((gone["reason"], gone["lost"]), ("stale", False))
        held = self.line()
        self.assertEqual(held["um"], gone["um"])
        self.start_again()
        self.write_signals()
        back = wait_until(lambda: (lambda line: line if line["valid"] else None)(self.line()), "the value again")
        self.assertLess(abs(back["um"] - held["um"]), 10.0)
        self.assertEqual(back["reason"], "ok")
        self.errors.seek(0)
        self.assertRegex(self.errors.read(), f"127.0.0.1:{self.port}: (cannot read|no connection): ")


def served(answer):
    """Port of a server that gives each connection to `answer`."""
    listening = socket.create_server(("127.0.0.1", 0))

    def serve():
        while True:
            try:
                connection, _ = listening.accept()
            except OSError:
                return
            with connection:
                try:
                    answer(connection)
                except OSError:
                    pass
    threading.Thread(target=serve, daemon=True).start()
    return listening


def framed(request, body, transaction=0, length=0):
    return struct.pack(">HHHB", struct.unpack(">H", request[:2])[0] + transaction, 0, len(body) + 1 + length, request[6]) + body


WRONG = {  # what a server does with the first request, and what the client says of it
    "silence": (lambda connection, request: time.sleep(3), "timed out"),
    "end": (lambda connection, request: None, "reset"),
    "exception": (lambda connection, request: connection.sendall(framed(request, b"\x84\x02")), "Protocol error|reset"),
    "another_transaction": (lambda connection, request: connection.sendall(framed(request, b"\x04\x0e" + bytes(14), 1)), "Protocol error"),
    "another_function": (lambda connection, request: connection.sendall(framed(request, b"\x03\x0e" + bytes(14))), "Protocol error"),
    "too_short": (lambda connection, request: connection.sendall(framed(request, b"\x04\x0c" + bytes(12))), "Protocol error"),
    "wrong_length": (lambda connection, request: connection.sendall(framed(request, b"\x04\x0e" + bytes(14), 0, 5)), "Protocol error"),
    "half": (lambda connection, request: connection.sendall(framed(request, b"\x04\x0e" + bytes(14))[:12]), "reset"),
}


class Wrong(unittest.TestCase):
    """Servers that answer wrongly or not at all; the client notices, and its cycle goes on."""

    def test_no_wrong_answer_is_taken(self):
        running = []
        for name, (answer, said) in WRONG.items():
            listening = served(lambda connection, answer=answer: answer(connection, connection.recv(12, socket.MSG_WAITALL)))
            self.addCleanup(listening.close)
            client = subprocess.Popen([PROGRAMS["client"], "127.0.0.1", str(listening.getsockname()[1]), "1", "1"],
                                      stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            running.append((name, said, client))
        client = subprocess.Popen([PROGRAMS["client"], "a.name", "502", "1", "1"], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                  text=True)
        running.append(("a name", f"a.name:502: no connection: {os.strerror(errno.EINVAL)}", client))
        for name, said, client in running:
            lines, errors = client.communicate(timeout=20)
            self.assertEqual(client.returncode, 0, name)
            self.assertRegex(errors, said, name)
            self.assertEqual([LINE.fullmatch(line)[7] for line in lines.splitlines(True)], ["no_twin"] * 2, name)

    def test_what_it_cannot_take_it_says(self):
        for arguments, words in ((("127.0.0.1", "0"), "PORT: 0, allowed: 1 to 65535"), (("127.0.0.1", "x"), "PORT: x"),
                                 (("127.0.0.1", "502", "256"), "UNIT: 256"), (("127.0.0.1", "502", "1", "0"), "SECONDS: 0"),
                                 (("a", "b", "c", "d", "e"), "usage")):
            said = subprocess.run([PROGRAMS["client"], *arguments], capture_output=True, text=True, timeout=10)
            self.assertEqual(said.returncode, 2)
            self.assertIn(words, said.stderr)


if __name__ == "__main__":
    main("client")
