"""Bridge and board of a fleet by themselves: what becomes of births, data and deaths, of what is damaged or unknown, and
who stands first on the board. With broker and store: fleet_load.
"""
import importlib.machinery
import importlib.util
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

FLEET = pathlib.Path(__file__).resolve().parents[2] / "host_tools" / "fleet"
sys.path.append(str(FLEET))
from sparkplug import Damaged, Payload, rebirth_order, signed  # noqa: E402


def script(name):
    loader = importlib.machinery.SourceFileLoader(name, str(FLEET / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module


sys.dont_write_bytecode = True
BRIDGE, BOARD = script("bridge"), script("board")


def varint(value):
    out = b""
    while value > 0x7F:
        out += bytes([value & 0x7F | 0x80])
        value >>= 7
    return out + bytes([value])


def field(number, value):
    if isinstance(value, float):
        return varint(number << 3 | 5) + struct.pack("<f", value)
    if isinstance(value, int):
        return varint(number << 3) + varint(value)
    return varint(number << 3 | 2) + varint(len(value)) + value


def metric(alias, value, where, name=None, kind=None, unit=None):
    data = (field(1, name.encode()) if name else b"") + field(2, alias) + (field(4, kind) if kind else b"")
    if unit:
        data += field(9, field(1, b"engUnit") + field(2, field(1, 12) + field(8, unit.encode())))
    return field(2, data + (field(where, value) if value is not None else field(7, 1)))


BIRTH = field(1, 1000) + metric(1, 1.5, 12, "nose", 9, "um") + metric(2, 1, 14, "fault/orders_lost", 11) \
    + metric(3, 2 ** 32 - 2, 10, "load/a b", 3) + metric(4, None, 12, "speed", 9) + metric(5, b"mill", 15, "Properties/x", 12)
DATA = field(1, 2000) + metric(1, 2.5, 12) + metric(2, 0, 14) + metric(3, 2 ** 32 - 3, 10) + metric(9, 1.0, 12)
WHO = 'group="hall",node="mill",spindle="left"'


class FakeStore:
    def __init__(self):
        self.lines = []

    def put(self, text, count):
        self.lines += text.splitlines()
        assert count == text.count("\n")


class FakeClient:
    def __init__(self):
        self.sent = []

    def publish(self, topic, payload):
        self.sent.append((topic, payload))


class FakeMessage:
    def __init__(self, topic, payload):
        self.topic, self.payload = topic, payload


class Bridge(unittest.TestCase):
    def setUp(self):
        self.store = FakeStore()
        self.bridge = BRIDGE.Bridge(self.store, "+")
        self.bridge.client = FakeClient()

    def hear(self, kind, payload, device="left"):
        topic = f"spBv1.0/hall/{kind}/mill" + (f"/{device}" if device else "")
        self.bridge.hear(None, None, FakeMessage(topic, payload))

    def test_a_birth_names_what_data_say_by_aliases(self):
        self.hear("DBIRTH", BIRTH)
        self.assertEqual(self.store.lines, [
            f"spindle_twin_alive{{{WHO}}} 1 1000", f'spindle_twin_nose{{{WHO},unit="um"}} 1.5 1000',
            f'spindle_twin_fault{{{WHO},bit="orders_lost"}} 1 1000', f'spindle_twin_load{{{WHO},of="a b"}} -2 1000'])
        self.store.lines.clear()
        self.hear("DDATA", DATA)
        self.assertEqual(self.store.lines, [
            f'spindle_twin_nose{{{WHO},unit="um"}} 2.5 2000', f'spindle_twin_fault{{{WHO},bit="orders_lost"}} 0 2000',
            f'spindle_twin_load{{{WHO},of="a b"}} -3 2000'])

    def test_data_without_a_birth_ask_for_it_once(self):
        for _ in range(3):
            self.hear("DDATA", DATA)
        self.assertEqual(self.store.lines, [])
        self.assertEqual(self.bridge.client.sent, [("spBv1.0/hall/NCMD/mill", rebirth_order())])
        self.assertEqual(self.bridge.unknown, 3)

    def test_deaths_of_a_node_and_of_a_device_are_said_of_each_spindle(self):
        self.hear("DBIRTH", BIRTH)
        self.hear("DBIRTH", BIRTH, "right")
        self.store.lines.clear()
        self.hear("DDEATH", field(1, 3000))
        self.hear("NDEATH", field(1, 4000), None)
        self.assertEqual(self.store.lines, [f"spindle_twin_alive{{{WHO}}} 0 3000", f"spindle_twin_alive{{{WHO}}} 0 4000",
                                            f"spindle_twin_alive{{{WHO.replace('left', 'right')}}} 0 4000"])

    def test_what_is_cut_or_noise_is_counted_and_harms_nobody(self):
        self.hear("DBIRTH", BIRTH)
        for length in range(1, len(DATA)):
            self.hear("DDATA", DATA[:length])
        self.hear("DDATA", bytes(range(256)))
        self.bridge.hear(None, None, FakeMessage("spBv1.0/STATE", b""))
        self.assertGreater(self.bridge.damaged, 10)

    def test_labels_are_escaped(self):
        self.assertEqual(BRIDGE.labels_of(("a\"b", "c\\d", "e\nf")), 'group="a\\"b",node="c\\\\d",spindle="e\\nf"')

    def test_integers_have_the_sign_of_their_type(self):
        self.assertEqual([signed(2 ** 32 - 1, 3), signed(2 ** 64 - 1, 4), signed(65535, 6), signed(None, 3)],
                         [-1, -1, 65535, None])
        with self.assertRaises(Damaged):
            Payload(b"\x18" + b"\xff" * 20)


class Board(unittest.TestCase):
    def row(self, name, state="running", faults=(), quality=(), nose=0.0):
        return BOARD.Row(("hall", name, "spindle"), state, 1.0, faults, quality, nose, None)

    def test_who_needs_somebody_most_stands_first(self):
        rows = [self.row("well", nose=3.0), self.row("grown", nose=-50.0), self.row("held", quality=["signal_held"]),
                self.row("degraded", "degraded"), self.row("fault", "fault", ["prediction_lost"]),
                self.row("silent", "silent"), self.row("gone", "gone"), self.row("worse", "fault", ["a", "b"])]
        order = [row.key[1] for row in sorted(rows, key=BOARD.Row.order)]
        self.assertEqual(order, ["gone", "silent", "worse", "fault", "degraded", "held", "grown", "well"])

    def test_a_table_and_a_page_show_so_many_and_count_all(self):
        rows = [self.row("<one>"), self.row("two"), self.row("three", "gone")]
        table = BOARD.table(rows, 2)
        self.assertIn("3 spindles: 1 gone, 2 running", table)
        self.assertEqual(len(table.splitlines()), 4)
        page = BOARD.page(rows, 3, 5.0)
        self.assertIn("hall/&lt;one&gt;/spindle", page)
        self.assertIn('<tr class="gone">', page)

    def test_without_an_answer_the_page_says_so_in_place_of_old_states(self):
        with tempfile.TemporaryDirectory() as folder:
            page = pathlib.Path(folder) / "board.html"
            page.write_text("running, age 1")
            board = subprocess.Popen([sys.executable, "-B", BOARD.__file__, "--store", "http://127.0.0.1:9", "--page", page,
                                      "--each", "0.1"], stderr=subprocess.PIPE, text=True)
            try:
                self.assertIn("127.0.0.1:9", board.stderr.readline())
                board.stderr.readline()  # the second time: the first page is written
            finally:
                board.terminate()
                board.communicate()
            text = page.read_text()
            self.assertIn("No states: the store does not answer since ", text)
            self.assertNotIn("running, age 1", text)

    def test_states(self):
        self.assertEqual([BOARD.state_of(1, 0.0, 1.0), BOARD.state_of(1, 1.0, 1e3), BOARD.state_of(2, 1.0, 1.0)],
                         ["gone", "silent", "degraded"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
