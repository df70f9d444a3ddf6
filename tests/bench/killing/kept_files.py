"""The daemon's files as another program reads them: sealed protobuf of checkpoint and orders, histories."""
import csv
import hashlib
import io
import struct


class Broken(AssertionError):
    """A file that is not whole, or a promise that was not kept."""


def demand(condition, what):
    if not condition:
        raise Broken(what)


def unseal(data, kind):
    """The payload behind a first line that names its SHA-256."""
    line, _, payload = data.partition(b"\n")
    whole = f"spindle-twin {kind} 1 {hashlib.sha256(payload).hexdigest()}".encode()
    demand(line == whole, f"{kind}: no whole file of {len(data)} bytes, begins {data[:40]!r}")
    return payload


def varint(data, at):
    value, shift = 0, 0
    while True:
        byte = data[at]
        value |= (byte & 127) << shift
        at, shift = at + 1, shift + 7
        if byte < 128:
            return value, at


def fields(payload):
    """Numbers of a protobuf message by the field's number; of texts and lists the bytes."""
    found, at = {}, 0
    while at < len(payload):
        key, at = varint(payload, at)
        if key & 7 == 0:
            found[key >> 3], at = varint(payload, at)
        elif key & 7 == 1:
            found[key >> 3] = struct.unpack_from("<d", payload, at)[0]
            at += 8
        else:
            size, at = varint(payload, at)
            found[key >> 3] = payload[at:at + size]
            at += size
    return found


SAVED, TARE_OF_CHECKPOINT, TARE_OF_ORDERS, REVISION_OF_ORDERS = 2, 4, 5, 3


def saved_unix_s(data):
    return fields(unseal(data, "checkpoint"))[SAVED]


def orders(data):
    """How many there were, and the tare in m."""
    found = fields(unseal(data, "orders"))
    return found.get(REVISION_OF_ORDERS, 0), found.get(TARE_OF_ORDERS, 0.0)


def history_sequences(data, name, may_end_within=False):
    """Sequences of a CSV history that is whole: the header, then rows of as many numbers, one behind the other."""
    text = data.decode("ascii", errors="replace")
    if may_end_within:
        text = text[:text.rfind("\n") + 1]
    demand(text == "" or text.endswith("\n"), f"{name}: its last row is not whole")
    rows = list(csv.reader(io.StringIO(text)))
    if not rows:
        return []
    header = rows[0]
    demand(header[:2] == ["time_s", "sequence"] or "sequence" in header, f"{name}: no header but {text[:60]!r}")
    column = header.index("sequence")
    for row in rows[1:]:
        demand(len(row) == len(header), f"{name}: a row of {len(row)} instead of {len(header)} columns")
        for value in row:
            demand(value == "" or is_number(value), f"{name}: {value!r} is no number")
    sequences = [int(float(row[column])) for row in rows[1:]]
    for before, after in zip(sequences, sequences[1:]):
        demand(after == before + 1, f"{name}: cycle {after} behind {before}")
    return sequences


def is_number(text):
    try:
        float(text)
        return True
    except ValueError:
        return False
