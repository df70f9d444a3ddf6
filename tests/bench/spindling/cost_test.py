"""Processor time for each cycle, memory and time to the first valid register, of one spindle and of many in one daemon.

cost_test.py DAEMON [MAKE_SMALL_NETWORK] [--network FILE] [--spindles N] [--seconds S]
"""
import argparse
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

from pymodbus.client import ModbusTcpClient

HERE = pathlib.Path(__file__).resolve().parent
SYSTEM = HERE.parents[1] / "system"
sys.path.insert(0, str(SYSTEM))
from ports import can_connect, free_port, wait_until  # noqa: E402

MOST_COST = 1.2      # of many, to as often one
MOST_MIB = 40.0      # resident, of one
CLOCK_RATE = 10.0    # cycles a second
HEARTBEAT, SEQUENCE, STATE = 7, 8, 10
USABLE = (1, 2)

SPINDLE = """
network = "{network}"
[device]
port = {device}
poll_s = 1.0
{sensors}
[cycle]
clock_rate = {rate}
[signals]
speed = {{ source = "constant", value = 6000.0 }}
load = {{ source = "constant", value = 0.5 }}
coolant = {{ source = "constant", value = 22.0 }}
ambient = {{ source = "constant", value = 22.0 }}
[history]
path = "{name}.csv"
[checkpoint]
path = "{name}.checkpoint"
"""
SENSOR = '[[sensor]]\nkey_point = "{key_point}"\nregister = {register}\ntype = "float32"\n'


class Daemon:
    """With so many spindles, all of the same network and device."""

    def __init__(self, asked, folder, count, device, key_points):
        sensors = "".join(SENSOR.format(key_point=name, register=2 * n) for n, name in enumerate(key_points))
        self.port, self.count = free_port(), count
        text = f"[serve]\nport = {self.port}\n"
        for n in range(1, count + 1):
            text += f'[[spindle]]\nname = "s{n}"\nunit = {n}\nconfig = "s{n}.toml"\n'
            (folder / f"s{n}.toml").write_text(SPINDLE.format(
                network=asked.network.resolve(), device=device, sensors=sensors, rate=CLOCK_RATE, name=f"s{n}"))
        config = folder / "list.toml"
        config.write_text(text)
        begin = time.monotonic()
        self.process = subprocess.Popen([asked.daemon, config], stderr=open(folder / "log", "w"))
        self.client = ModbusTcpClient("127.0.0.1", port=self.port)
        wait_until(lambda: self.process.poll() is not None or can_connect(self.port), "the daemon's port")
        if self.process.poll() is not None:
            sys.exit((folder / "log").read_text())
        self.client.connect()
        for n in range(1, count + 1):
            wait_until(lambda: self.read(n, STATE)[0] in USABLE, f"a prediction of spindle {n}")
        self.first_s = time.monotonic() - begin

    def read(self, unit, address, words=1):
        return self.client.read_input_registers(address, words, slave=unit).registers

    def cycles(self):
        return sum(high << 16 | low for high, low in (self.read(n, SEQUENCE, 2) for n in range(1, self.count + 1)))

    def processor_s(self):
        threads = pathlib.Path(f"/proc/{self.process.pid}/task").glob("*/schedstat")
        return 1e-9 * sum(int(thread.read_text().split()[0]) for thread in threads)

    def cost_s(self, seconds):
        """Processor time for each cycle, by the way with all that the other threads do for it."""
        cycles, processor_s = self.cycles(), self.processor_s()
        time.sleep(seconds)
        return (self.processor_s() - processor_s) / (self.cycles() - cycles)

    def resident_MiB(self):
        for line in pathlib.Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                return int(line.split()[1]) / 1024
        return 0.0

    def end(self):
        self.client.close()
        self.process.send_signal(signal.SIGTERM)
        if self.process.wait(60) != 0:
            sys.exit("the daemon did not end well")


def options():
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("daemon", type=os.path.abspath)
    reader.add_argument("make_network", nargs="?", help="makes a small network where none is named")
    reader.add_argument("--network", type=pathlib.Path)
    reader.add_argument("--key-points", nargs="+", default=["inner", "middle", "outer"])
    reader.add_argument("--spindles", type=int, default=16)
    reader.add_argument("--seconds", type=float, default=30.0)
    return reader.parse_args()


def measure(asked, folder):
    """By number of spindles the least cost of three, the memory at the end, and the time to the first valid register."""
    device = free_port()
    fake = subprocess.Popen([sys.executable, "-B", SYSTEM / "fake_device.py", str(device)], stderr=subprocess.DEVNULL)
    try:
        wait_until(lambda: can_connect(device), "the device's port")
        costs, memory, first = {}, {}, {}
        for turn in range(3):
            for count in (1, asked.spindles):
                own = folder / f"{turn}.{count}"
                own.mkdir()
                daemon = Daemon(asked, own, count, device, asked.key_points)
                first[count] = min(first.get(count, 1e9), daemon.first_s)
                costs[count] = min(costs.get(count, 1e9), daemon.cost_s(asked.seconds / 3))
                memory[count] = max(memory.get(count, 0.0), daemon.resident_MiB())
                daemon.end()
        return costs, memory, first
    finally:
        fake.kill()
        fake.wait()


def main():
    asked = options()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if asked.network is None:
            asked.network, asked.key_points = folder / "small.rom", [f"sleeve_{n}" for n in ("inner", "middle", "outer")]
            subprocess.run([asked.make_network, asked.network], check=True)
        costs, memory, first = measure(asked, folder)
    many = asked.spindles
    print(f"{'spindles':>8} {'ms of processor a cycle':>24} {'resident MiB':>13} {'s to a valid register of all':>29}")
    for count in (1, many):
        print(f"{count:>8} {1e3 * costs[count]:>24.3f} {memory[count]:>13.1f} {first[count]:>29.2f}")
    ratio = costs[many] / costs[1]
    print(f"a cycle of {many} spindles, to {many} times that of one: {ratio:.2f} (at most {MOST_COST})")
    print(f"resident memory of one: {memory[1]:.1f} MiB (at most {MOST_MIB:g})")
    sys.exit(0 if ratio <= MOST_COST and memory[1] <= MOST_MIB else 1)


main()
