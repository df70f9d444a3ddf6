"""The clients of npm_clients.js, asked from Python."""
import json
import pathlib
import select
import subprocess

from promises import Outcome
from python_clients import PATIENCE_S

HERE = pathlib.Path(__file__).resolve().parent


class NpmClient:
    """A client of npm in a process of its own, asked by lines of JSON; by TLS with authority, certificate and key."""

    def __init__(self, name, port, *certificates):
        self.name = name
        self.process = subprocess.Popen(["node", HERE / "npm_clients.js", name, str(port),
                                         *map(str, certificates)], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, text=True)

    def answer(self, order):
        print(json.dumps(order), file=self.process.stdin, flush=True)
        ready, _, _ = select.select([self.process.stdout], [], [], PATIENCE_S)
        if not ready:
            raise AssertionError(f"{self.name} says nothing to {order}")
        return json.loads(self.process.stdout.readline())

    def ask(self, unit, pdu):
        answer = self.answer({"unit": unit, "pdu": list(pdu)})
        return Outcome(answer["kind"], answer.get("detail"))

    def value(self, table, offset, kind):
        return self.answer({"table": table, "offset": offset, "kind": kind})["value"]

    def close(self):
        self.process.kill()
        self.process.communicate()
