"""Sparkplug B payloads as a bridge needs them: which metrics, what time, what value; names or aliases. No library, because
a plant has thousands of them a second: fields that nobody asked for are skipped."""
import struct

VARINT, FIXED64, BYTES, FIXED32 = 0, 1, 2, 5
BOOLEAN, STRING = 11, 12  # Sparkplug's data types; what else is used here has a number as its value
INT32_BITS, INT64_BITS = 32, 64
SIGNED = {1: 32, 2: 32, 3: INT32_BITS, 4: INT64_BITS}  # Int8, Int16, Int32, Int64: bits of their field


class Damaged(ValueError):
    """No payload of Sparkplug B."""


def varint(data, at):
    value = shift = 0
    while True:
        byte = data[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, at
        shift += 7
        if shift > 63:
            raise Damaged("a number without an end")


def fields(data):
    """Number and value of each field: an int, or bytes."""
    at, end = 0, len(data)
    while at < end:
        tag, at = varint(data, at)
        kind = tag & 7
        if kind == VARINT:
            value, at = varint(data, at)
        elif kind == BYTES:
            length, at = varint(data, at)
            value, at = data[at:at + length], at + length
        elif kind in (FIXED32, FIXED64):
            length = 4 if kind == FIXED32 else 8
            value, at = data[at:at + length], at + length
        else:
            raise Damaged(f"a field of kind {kind}")
        if at > end:
            raise Damaged("cut")
        yield tag >> 3, value


class Metric:
    __slots__ = ("name", "alias", "time", "kind", "value", "unit", "quality")

    def __init__(self):
        self.name = self.alias = self.time = self.kind = self.value = self.quality = None
        self.unit = ""


def read_properties(data, metric):
    keys, values = [], []
    for number, value in fields(data):
        (keys if number == 1 else values).append(value)
    for key, value in zip(keys, values):
        inner = dict(fields(value))
        if key == b"engUnit":
            metric.unit = inner.get(8, b"").decode()
        elif key == b"Quality":
            metric.quality = inner.get(3)


def read_metric(data):
    metric = Metric()
    for number, value in fields(data):
        if number == 2:
            metric.alias = value
        elif number == 3:
            metric.time = value
        elif number in (10, 11, 14):
            metric.value = value
        elif number == 12:
            metric.value, = struct.unpack("<f", value)
        elif number == 13:
            metric.value, = struct.unpack("<d", value)
        elif number == 15:
            metric.value = value.decode()
        elif number == 1:
            metric.name = value.decode()
        elif number == 4:
            metric.kind = value
        elif number == 9:
            read_properties(value, metric)
    return metric


def signed(value, kind):
    """An integer as its type has it; `kind` is that of the birth."""
    bits = SIGNED.get(kind)
    return value - (1 << bits) if bits and isinstance(value, int) and value >> (bits - 1) else value


class Payload:
    def __init__(self, data):
        self.time = self.seq = None
        self.metrics = []
        try:
            for number, value in fields(data):
                if number == 2:
                    self.metrics.append(read_metric(value))
                elif number == 1:
                    self.time = value
                elif number == 3:
                    self.seq = value
        except (IndexError, struct.error, UnicodeDecodeError, TypeError, AttributeError) as error:
            raise Damaged(str(error)) from error


def rebirth_order():
    """The payload that asks a node for its births."""
    name = b"Node Control/Rebirth"
    metric = b"\x0a" + bytes([len(name)]) + name + b"\x20\x0b\x70\x01"
    return b"\x12" + bytes([len(metric)]) + metric
