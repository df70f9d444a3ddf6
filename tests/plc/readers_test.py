"""What reads the registers around the function block, beside a stand-in for the control's own Modbus block: requests one
after the other, each for one of the two reads, also when every other one fails.

readers_test.py [unittest options]

The stand-ins have the inputs and outputs that the makers' pages name: MB_CLIENT in the S7-1200 system manual
A5E02486680, FB_MBReadInputRegs in infosys.beckhoff.com/content/1033/tf6250_tc3_modbus_tcp/192757003.html.
"""
import pathlib
import unittest

import checked_block
import structured_text

PLC = pathlib.Path(__file__).resolve().parents[2] / "host_tools" / "plc"
MB_CLIENT = ({"REQ": "BOOL", "DISCONNECT": "BOOL", "MB_MODE": "USINT", "MB_DATA_ADDR": "UDINT", "MB_DATA_LEN": "UINT",
              "CONNECT": "VARIANT", "MB_DATA_PTR": "VARIANT"}, {"DONE": "BOOL", "BUSY": "BOOL", "ERROR": "BOOL", "STATUS": "WORD"})
READ_INPUT_REGS = ({"sIPAddr": "STRING", "nTCPPort": "UINT", "nUnitID": "BYTE", "nQuantity": "WORD", "nMBAddr": "WORD",
                    "cbLength": "UDINT", "pDestAddr": "POINTER", "bExecute": "BOOL", "tTimeout": "TIME"},
                   {"bBusy": "BOOL", "bError": "BOOL"})
READS = [(0, 7), (1502, 14)]  # offset and registers, as host_tools/plc/interface.md has them
BUSY_CALLS = 3


class Master:
    """A control's Modbus block: a rising edge, or a level, starts a read, which takes some calls; its inputs must stay
    meanwhile."""

    def __init__(self, test, daemon, execute, idle, request, fails, level=False):
        self.test, self.daemon, self.execute, self.request, self.fails, self.level = test, daemon, execute, request, fails, level
        self.outputs, self.inputs, self.before, self.left, self.made = dict(idle), {}, False, 0, []

    def call(self, inputs):
        self.inputs.update(inputs)
        edge, self.before = self.inputs[self.execute] and (self.level or not self.before), self.inputs[self.execute]
        if self.left > 0:
            self.test.assertEqual(self.request(self.inputs)[:2], self.made[-1], "another request while the block is busy")
            self.left -= 1
            if self.left == 0:
                self.end()
        elif edge:
            self.made.append(self.request(self.inputs)[:2])
            self.left = BUSY_CALLS
            self.show(busy=True)
        else:
            self.show()

    def end(self):
        failed = self.fails(len(self.made))
        if not failed:
            offset, count, words = self.request(self.inputs)
            self.test.assertEqual(len(words), count)
            words[:] = self.daemon(offset, count)
        self.show(done=not failed, error=failed)


class MbClient(Master):
    def __init__(self, test, daemon, fails, level=False):
        super().__init__(test, daemon, "REQ", dict(DONE=False, BUSY=False, ERROR=False, STATUS=0), self.asked, fails, level)

    def asked(self, inputs):
        self.test.assertEqual((inputs["MB_MODE"], inputs["DISCONNECT"]), (0, False))
        return inputs["MB_DATA_ADDR"] - 30001, inputs["MB_DATA_LEN"], inputs["MB_DATA_PTR"]

    def show(self, busy=False, done=False, error=False):
        self.outputs = dict(DONE=done, BUSY=busy, ERROR=error, STATUS=0x80C8 if error else 0)


class ReadInputRegs(Master):
    def __init__(self, test, daemon, fails):
        super().__init__(test, daemon, "bExecute", dict(bBusy=False, bError=False), self.asked, fails)

    def asked(self, inputs):
        self.test.assertEqual(inputs["cbLength"], 2 * inputs["nQuantity"])
        return inputs["nMBAddr"], inputs["nQuantity"], inputs["pDestAddr"]

    def show(self, busy=False, done=False, error=False):
        self.outputs = dict(bBusy=busy, bError=error)


class Twin:
    """The function block as an instance in another one."""

    def __init__(self, block):
        self.block, self.outputs = checked_block.checked(block), {}
        self.values = self.block.initial_values()
        self.outputs = self.values

    def call(self, inputs):
        self.values.update({name: list(value) if isinstance(value, list) else value for name, value in inputs.items()})
        self.block.step(self.values)


class Daemon:
    """Registers of one that runs and wants + 12.3 um."""

    def __init__(self):
        self.heartbeat = 0

    def __call__(self, offset, count):
        self.heartbeat += 1
        return [0x1234, 0, 0, 0, 0, 0, 2] if offset == 0 else [self.heartbeat, 1, 0, 0, 1] + [0] * 7 + [123, 0]


def read(name, dialect):
    return structured_text.read_blocks((PLC / name).read_text(encoding="utf-8"), dialect)[0]


class Readers(unittest.TestCase):
    def started(self, name, dialect, modbus, own_name, twin_block):
        """The reader of this file and its variables, but for the Modbus block."""
        twin = read(twin_block, dialect)
        kinds = {own_name: modbus, twin.name: checked_block.signature(twin), "TCON_IP_v4": ({}, {})} if modbus else \
            {twin.name: checked_block.signature(twin)}
        reader = checked_block.checked(read(name, dialect), kinds)
        values = reader.initial_values()
        values["Twin"] = Twin(twin)
        return reader, values

    def simatic(self, fails, level=False):
        reader, values = self.started("spindle_twin_read.scl", structured_text.SCL, MB_CLIENT, "MB_CLIENT", "spindle_twin.scl")
        values.update(Client=MbClient(self, Daemon(), fails, level), ElapsedUs=10000, Ready=True)
        return reader, values, "Client"

    def simatic_by_level(self, fails):
        return self.simatic(fails, level=True)

    def twincat(self, fails):
        reader, values = self.started("spindle_twin_twincat.st", structured_text.ST, READ_INPUT_REGS, "FB_MBReadInputRegs",
                                      "spindle_twin.st")
        values.update(Read=ReadInputRegs(self, Daemon(), fails), AxisReferenced=True)
        return reader, values, "Read"

    def test_both_reads_are_made_in_turn_and_the_value_is_followed(self):
        for started in (self.simatic, self.simatic_by_level, self.twincat):
            reader, values, modbus = started(lambda n: False)
            for _ in range(300):
                reader.step(values)
            made = values[modbus].made
            self.assertGreater(len(made), 30)
            self.assertEqual(made, (READS * len(made))[:len(made)])
            outputs = values["Twin"].outputs
            self.assertEqual((outputs["ValueNm"], outputs["Valid"], outputs["Settled"]), (12300, True, True))

    def test_it_goes_on_through_failed_requests(self):
        for started in (self.simatic, self.simatic_by_level, self.twincat):
            for fails in (lambda n: n % 3 == 0, lambda n: n < 20):
                reader, values, modbus = started(fails)
                for _ in range(400):
                    reader.step(values)
                self.assertTrue(values["Twin"].outputs["Settled"])
            reader, values, modbus = started(lambda n: True)
            for _ in range(400):
                reader.step(values)
            self.assertGreater(len(values[modbus].made), 30)
            self.assertEqual(values["Twin"].outputs["ValueNm"], 0)

    def test_a_value_that_stops_coming_is_noticed(self):
        for started in (self.simatic, self.simatic_by_level, self.twincat):
            reader, values, modbus = started(lambda n: n > 20)
            for _ in range(600):
                reader.step(values)
            outputs = values["Twin"].outputs
            self.assertEqual((outputs["ValueNm"], outputs["Valid"]), (12300, False))

    def test_the_example_for_codesys_hands_on_the_value_in_mm(self):
        reader, values = self.started("spindle_twin_codesys.st", structured_text.ST, None, "", "spindle_twin.st")
        daemon = Daemon()
        values["AxisReferenced"] = True
        for _ in range(200):
            values.update(Head=daemon(*READS[0]), Answer=daemon(*READS[1]))
            reader.step(values)
        self.assertAlmostEqual(values["CompensationMm"], 0.0123, places=7)

    def test_what_does_not_fit_the_makers_blocks_is_refused(self):
        for name, dialect, kinds, before, after in (
                ("spindle_twin_read.scl", structured_text.SCL, {"MB_CLIENT": MB_CLIENT}, "REQ :=", "REQUEST :="),
                ("spindle_twin_read.scl", structured_text.SCL, {"MB_CLIENT": MB_CLIENT}, ".DONE", ".READY"),
                ("spindle_twin_read.scl", structured_text.SCL, {"MB_CLIENT": MB_CLIENT}, "ARRAY[0..6]", "ARRAY[0..5]"),
                ("spindle_twin_twincat.st", structured_text.ST, {"FB_MBReadInputRegs": READ_INPUT_REGS}, "T#500MS", "500"),
                ("spindle_twin_twincat.st", structured_text.ST, {"FB_MBReadInputRegs": READ_INPUT_REGS}, "nUnitID := 1,", "nUnitID := 256,")):
            text = (PLC / name).read_text(encoding="utf-8")
            self.assertIn(before, text)
            twin = read("spindle_twin.scl" if dialect == structured_text.SCL else "spindle_twin.st", dialect)
            kinds = {**kinds, "TCON_IP_v4": ({}, {}), twin.name: checked_block.signature(twin)}
            checked_block.checked(structured_text.read_blocks(text, dialect)[0], kinds)
            with self.assertRaises(checked_block.TypeProblem):
                checked_block.checked(structured_text.read_blocks(text.replace(before, after, 1), dialect)[0], kinds)


if __name__ == "__main__":
    unittest.main()
