"""Modbus clients that Python reaches: bytes of our own, libmodbus, pymodbus and the program mbpoll.

Each has ask(unit, pdu) -> Outcome, which calls what the client has for that request, and value(table, offset, kind),
which lets the client decode a value by its own means; None where it has none.
"""
import ctypes
import errno
import re
import socket
import struct
import subprocess

from pymodbus import bit_read_message, bit_write_message, diag_message, file_message, mei_message, other_message
from pymodbus.client import ModbusTcpClient
from pymodbus.constants import Endian
from pymodbus.exceptions import ConnectionException, ModbusIOException
from pymodbus.payload import BinaryPayloadDecoder

from promises import NO_CALL, Outcome, outcome_of_reply

PATIENCE_S = 20.0  # an answer takes milliseconds; what takes this long has hung
HOLDING, INPUT = 4, 3  # tables, as the digit in front of a register's number says
FUNCTION_OF_TABLE = {HOLDING: 3, INPUT: 4}
WORDS = {"uint32": 2, "int32": 2, "float32": 2, "float32_cdab": 2}


def word(pdu, at):
    return pdu[at] << 8 | pdu[at + 1]


def words(data):
    return list(struct.unpack(f">{len(data) // 2}H", data))


class RawClient:
    """Sends what stands in the table, byte by byte as it stands there."""
    name = "bytes"

    def __init__(self, port):
        self.port = port

    def ask(self, unit, pdu):
        with socket.create_connection(("127.0.0.1", self.port), PATIENCE_S) as connection:
            connection.sendall(struct.pack(">HHHB", 0x5EED, 0, len(pdu) + 1, unit) + pdu)
            try:
                reply = b""
                while len(reply) < 6 or len(reply) < 6 + word(reply, 4):
                    more = connection.recv(4096)
                    if not more:
                        break
                    reply += more
            except ConnectionResetError:
                reply = b""
        if reply and (reply[:4] != b"\x5E\xED\0\0" or reply[6] != unit):
            return None
        return outcome_of_reply(pdu, reply[7:])

    def value(self, table, offset, kind):
        read = self.ask(1, struct.pack(">BHH", FUNCTION_OF_TABLE[table], offset, WORDS.get(kind, 1))).detail
        data = struct.pack(f">{len(read)}H", *(reversed(read) if kind == "float32_cdab" else read))
        form = {"uint16": ">H", "offset16": ">H", "int16": ">h", "uint32": ">I", "int32": ">i"}.get(kind, ">f")
        return struct.unpack(form, data)[0]

    def close(self):
        pass


class Libmodbus:
    """Its C functions, through ctypes."""
    name = "libmodbus"
    exceptions_from = 112345678  # MODBUS_ENOBASE of modbus.h
    too_many_data = exceptions_from + 12 + 4  # EMBMDATA

    def __init__(self, port):
        self.library = ctypes.CDLL("libmodbus.so.5", use_errno=True)
        self.library.modbus_new_tcp.restype = ctypes.c_void_p
        self.library.modbus_get_float_abcd.restype = self.library.modbus_get_float_cdab.restype = ctypes.c_float
        self.context = ctypes.c_void_p(self.library.modbus_new_tcp(b"127.0.0.1", port))
        self.library.modbus_set_response_timeout(self.context, ctypes.c_uint32(int(PATIENCE_S)), ctypes.c_uint32(0))
        if self.library.modbus_connect(self.context) != 0:
            raise OSError(ctypes.get_errno(), "modbus_connect")

    def call(self, function, *arguments):
        ctypes.set_errno(0)
        return getattr(self.library, function)(self.context, *arguments), ctypes.get_errno()

    def raw(self, unit, pdu):
        """For what the library has no function of its own; it knows where an exception ends."""
        request = bytes([unit]) + pdu
        self.call("modbus_send_raw_request", request, len(request))
        reply = (ctypes.c_uint8 * 260)()
        return self.call("modbus_receive_confirmation", reply), bytes(reply)

    def ask(self, unit, pdu):
        if self.call("modbus_set_slave", unit)[0] != 0:
            return NO_CALL  # from 248 to 254
        function, data = pdu[0], (ctypes.c_uint16 * 128)()
        if function in (1, 2, 3, 4):
            name = {1: "bits", 2: "input_bits", 3: "registers", 4: "input_registers"}[function]
            result = self.call(f"modbus_read_{name}", word(pdu, 1), word(pdu, 3), data)
        elif function in (5, 6):
            name = {5: "bit", 6: "register"}[function]
            result = self.call(f"modbus_write_{name}", word(pdu, 1), word(pdu, 3))
        elif function == 15:
            result = self.call("modbus_write_bits", word(pdu, 1), word(pdu, 3), (ctypes.c_uint8 * 8)(1))
        elif function == 16:
            if pdu[5] != 2 * word(pdu, 3):
                return NO_CALL
            values = words(pdu[6:])
            result = self.call("modbus_write_registers", word(pdu, 1), len(values), (ctypes.c_uint16 * 128)(*values))
        elif function == 17:
            result = self.call("modbus_report_slave_id", 64, data)
        elif function == 22:
            result = self.call("modbus_mask_write_register", word(pdu, 1), word(pdu, 3), word(pdu, 5))
        elif function == 23:
            values = words(pdu[10:])
            result = self.call("modbus_write_and_read_registers", word(pdu, 5), len(values),
                               (ctypes.c_uint16 * 128)(*values), word(pdu, 1), word(pdu, 3), data)
        elif function in (7, 8, 20, 24, 65):
            result, reply = self.raw(unit, pdu)
            if result[0] > 0:
                return outcome_of_reply(pdu, reply[7:result[0]])
        else:
            return NO_CALL
        if result[0] >= 0:
            return Outcome("words", list(data[:result[0]])) if function in (3, 4, 23) else Outcome("done")
        if result[1] == self.too_many_data:
            return Outcome("own refusal")
        if result[1] in (errno.ECONNRESET, errno.EPIPE):
            return Outcome("closed")
        return Outcome("exception", result[1] - self.exceptions_from)

    def value(self, table, offset, kind):
        data = (ctypes.c_uint16 * 2)()
        function = "modbus_read_registers" if table == HOLDING else "modbus_read_input_registers"
        self.call("modbus_set_slave", 1)
        self.call(function, offset, WORDS.get(kind, 1), data)
        if kind.startswith("float32"):
            decode = "modbus_get_float_cdab" if kind == "float32_cdab" else "modbus_get_float_abcd"
            return getattr(self.library, decode)(data)
        # As the macro MODBUS_GET_INT32_FROM_INT16 does it.
        joined = data[0] << 16 | data[1] if kind in WORDS else data[0]
        signed = {"int16": ctypes.c_int16, "int32": ctypes.c_int32}.get(kind)
        return signed(joined).value if signed else joined

    def close(self):
        self.library.modbus_close(self.context)
        self.library.modbus_free(self.context)


class Pymodbus:
    name = "pymodbus"

    def __init__(self, port):
        self.client = ModbusTcpClient("127.0.0.1", port=port, timeout=PATIENCE_S, retries=0)
        self.client.connect()

    def request(self, unit, pdu):
        """The library's own object for this request; None where it has none."""
        client, function = self.client, pdu[0]
        if function in (3, 4):
            read = client.read_holding_registers if function == 3 else client.read_input_registers
            return lambda: read(word(pdu, 1), word(pdu, 3), slave=unit)
        if function == 6:
            return lambda: client.write_register(word(pdu, 1), word(pdu, 3), slave=unit)
        if function == 16 and pdu[5] == 2 * word(pdu, 3):
            return lambda: client.write_registers(word(pdu, 1), words(pdu[6:]), slave=unit)
        if function == 22:
            return lambda: client.mask_write_register(address=word(pdu, 1), and_mask=word(pdu, 3),
                                                      or_mask=word(pdu, 5), unit=unit)
        if function == 23:
            return lambda: client.readwrite_registers(read_address=word(pdu, 1), read_count=word(pdu, 3),
                                                      write_address=word(pdu, 5), write_registers=words(pdu[10:]),
                                                      unit=unit)
        others = {1: lambda: bit_read_message.ReadCoilsRequest(word(pdu, 1), word(pdu, 3), unit),
                  2: lambda: bit_read_message.ReadDiscreteInputsRequest(word(pdu, 1), word(pdu, 3), unit),
                  5: lambda: bit_write_message.WriteSingleCoilRequest(word(pdu, 1), True, unit),
                  7: lambda: other_message.ReadExceptionStatusRequest(unit),
                  8: lambda: diag_message.ReturnQueryDataRequest(0, unit=unit),
                  15: lambda: bit_write_message.WriteMultipleCoilsRequest(word(pdu, 1), [True], unit),
                  17: lambda: other_message.ReportSlaveIdRequest(unit),
                  20: lambda: file_message.ReadFileRecordRequest(
                      [file_message.FileRecord(file_number=1, record_number=0, record_length=1)], unit=unit),
                  24: lambda: file_message.ReadFifoQueueRequest(word(pdu, 1), unit=unit)}
        if function in others:
            return lambda: client.execute(others[function]())
        if function == 0x2B and pdu[1] == 0x0E:
            return lambda: client.execute(mei_message.ReadDeviceInformationRequest(pdu[2], pdu[3], unit=unit))
        return None

    def ask(self, unit, pdu):
        request = self.request(unit, pdu)
        if request is None:
            return NO_CALL
        try:
            reply = request()
        except (ConnectionException, ConnectionResetError):
            return Outcome("closed")
        if isinstance(reply, ModbusIOException):
            return Outcome("closed")
        if reply.isError():
            return Outcome("exception", reply.exception_code)
        if hasattr(reply, "registers") and pdu[0] in (3, 4, 23):
            return Outcome("words", reply.registers)
        return Outcome("objects", sorted(reply.information)) if pdu[0] == 0x2B else Outcome("done")

    def value(self, table, offset, kind):
        read = self.client.read_holding_registers if table == HOLDING else self.client.read_input_registers
        registers = read(offset, WORDS.get(kind, 1), slave=1).registers
        order = Endian.Little if kind == "float32_cdab" else Endian.Big
        decoder = BinaryPayloadDecoder.fromRegisters(registers, byteorder=Endian.Big, wordorder=order)
        decode = {"uint16": "16bit_uint", "offset16": "16bit_uint", "int16": "16bit_int", "uint32": "32bit_uint",
                  "int32": "32bit_int"}.get(kind, "32bit_float")
        return getattr(decoder, f"decode_{decode}")()

    def close(self):
        self.client.close()


class Mbpoll:
    """The program; counts from 0 as told by `-0` or, as it does by itself, from 1."""
    name = "mbpoll"
    codes = {"Illegal function": 1, "Illegal data address": 2, "Illegal data value": 3,
             "Slave device or server is busy": 6, "Target device failed to respond": 11}

    def __init__(self, port):
        self.port = port

    def run(self, *arguments, values=()):
        command = ["mbpoll", "-m", "tcp", "-1", "-q", "-p", self.port, "-o", "10", *arguments, "127.0.0.1"]
        command += ["--", *values] if values else []
        return subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=PATIENCE_S)

    def ask(self, unit, pdu):
        function = pdu[0]
        if function not in (1, 2, 3, 4, 5, 6, 15, 16) or 247 < unit < 255:
            return NO_CALL  # where libmodbus does not take the unit, mbpoll goes on with 255
        table = {1: "0", 2: "1", 3: "4", 4: "3", 5: "0", 6: "4", 15: "0", 16: "4"}[function]
        values = {5: ["1"], 6: [word(pdu, 3)], 15: ["1"]}.get(function, words(pdu[6:]) if function == 16 else [])
        if function == 16 and not 1 < len(values) == word(pdu, 3):
            return NO_CALL  # without a value it reads, with one it takes FC6
        count = [] if values else ["-c", word(pdu, 3)]
        result = self.run("-0", "-a", unit, "-r", word(pdu, 1), "-t", table, *count, values=values)
        failed = re.search(r"(?:Read|Write) .*failed: (.*)", result.stderr + result.stdout)
        if failed and failed[1] in self.codes:
            return Outcome("exception", self.codes[failed[1]])
        if failed and "reset" in failed[1]:
            return Outcome("closed")
        if result.returncode != 0:
            return Outcome("own refusal")
        read = re.findall(r"^\[\d+\]:\s+(\d+)", result.stdout, re.MULTILINE)
        return Outcome("done") if values else Outcome("words", list(map(int, read)))

    def value(self, table, offset, kind):
        return self.shown(table, kind, "-0", "-r", offset)

    def value_at_number(self, table, number, kind):
        """By the number behind the digit of the table, which is what it counts by itself."""
        return self.shown(table, kind, "-r", number)

    def shown(self, table, kind, *place):
        form = {"uint32": ":int", "int32": ":int", "float32": ":float", "float32_cdab": ":float"}.get(kind, "")
        order = ["-B"] if kind in ("uint32", "int32", "float32") else []
        result = self.run(*place, "-c", 1, "-t", f"{table}{form}", *order)
        shown = re.search(r"^\[\d+\]:\s+(\S+)(?:\s+\((-?\d+)\))?", result.stdout, re.MULTILINE)
        if not shown:
            raise AssertionError(result.stdout + result.stderr)
        # A word from 32768 on is shown both ways, "65411 (-125)".
        return float(shown[2] if kind == "int16" and shown[2] else shown[1])

    def close(self):
        pass
