"""What firmware/serve/README.md promises, as data: its tables of requests and of values."""
import collections
import csv
import pathlib
import re

SERVE = pathlib.Path(__file__).resolve().parents[3] / "firmware" / "serve"

# Outcome of a request. kind: "words" (detail: their values), "done" (a write), "objects" (ids), "exception" (code),
# "closed"; of a client also "no call" (it has none for this) and "own refusal" (it does not send it).
Outcome = collections.namedtuple("Outcome", "kind detail", defaults=[None])
Request = collections.namedtuple("Request", "name unit pdu answer")
NO_CALL = Outcome("no call")
EXCEPTION = 0x80


def rows(heading):
    """The table of the README whose first column has this heading, without its head."""
    lines = (SERVE / "README.md").read_text().splitlines()
    start = next(n for n, line in enumerate(lines) if line.startswith(f"| {heading} |"))
    table = []
    for line in lines[start + 2:]:
        if not line.startswith("|"):
            break
        table.append([cell.strip() for cell in line.strip("|").split("|")])
    return table


def pdu_of(text):
    repeated = re.sub(r"(\w+) \.\. x (\d+)", lambda match: match[1] * int(match[2]), text.strip("`"))
    return bytes.fromhex(repeated)


def requests():
    return [Request(name, int(unit), pdu_of(text), answer) for name, unit, text, answer in rows("request")]


def values():
    """Type -> (register, value or None where it is not constant)."""
    number = re.compile(r"-?\d+(\.\d+)?$")
    return {kind: (register.strip("`"), float(value) if number.match(value) else None)
            for kind, register, value in rows("type")}


def register_map():
    """Name -> row of registers.csv."""
    with open(SERVE / "registers.csv", newline="") as table:
        return {row["name"]: row for row in csv.DictReader(table)}


def outcome_of_reply(request, reply):
    """What an answer's PDU says; None for one that does not answer this request."""
    function = request[0]
    if not reply:
        return Outcome("closed")
    if reply[0] == function | EXCEPTION and len(reply) == 2:
        return Outcome("exception", reply[1])
    if reply[0] != function:
        return None
    if function in (3, 4, 23):
        words = [reply[at] << 8 | reply[at + 1] for at in range(2, len(reply), 2)]
        return Outcome("words", words) if reply[1] == len(reply) - 2 else None
    if function == 0x2B:
        ids, at = [], 7
        while at < len(reply):
            ids.append(reply[at])
            at += 2 + reply[at + 1]
        return Outcome("objects", ids) if at == len(reply) and len(ids) == reply[6] else None
    written = request if function in (6, 22) else request[:5]
    return Outcome("done") if reply == written else None


def keeps(promise, outcome):
    """Whether an outcome is what the table says."""
    if promise == "close":
        return outcome.kind == "closed"
    if promise in ("echo", "head"):
        return outcome.kind == "done"
    kind, _, rest = promise.partition(" ")
    if kind == "exception":
        return outcome == Outcome("exception", int(rest))
    if kind == "identification":
        return outcome == Outcome("objects", [int(number) for number in rest.split()])
    if kind == "words":
        return outcome == Outcome("words", [int(word, 16) for word in rest.split()])
    if rest == "words":
        return outcome.kind == "words" and len(outcome.detail) == int(kind)
    raise ValueError(f"firmware/serve/README.md: `{promise}` is no answer that this test knows")
