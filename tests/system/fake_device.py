"""A data-acquisition device for tests: fake_device.py PORT. Input registers 0-7: four float32 (ABCD), in degC;
a test may write them as holding registers."""
import struct
import sys

from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.server import StartTcpServer

TEMPERATURES_DEGC = (28.5, 28.25, 28.0, 21.5)


def words(value):
    return list(struct.unpack(">HH", struct.pack(">f", value)))


if __name__ == "__main__":
    registers = [word for value in TEMPERATURES_DEGC for word in words(value)]
    block = ModbusSequentialDataBlock(0, registers + [0] * 8)
    slave = ModbusSlaveContext(ir=block, hr=block, zero_mode=True)
    StartTcpServer(context=ModbusServerContext(slaves=slave, single=True), address=("127.0.0.1", int(sys.argv[1])),
                   allow_reuse_address=True)  # what ended a moment ago does not hold the port for a minute
