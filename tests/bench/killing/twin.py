"""A daemon behind the seam, the device that it reads, and the machine that the device stands at."""
import pathlib
import random
import signal
import socketserver
import struct
import subprocess
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "system"))

from pymodbus.client import ModbusTcpClient  # noqa: E402

from kept_files import demand  # noqa: E402
from ports import can_connect, free_port, wait_until  # noqa: E402
from running_daemon import BEGINNING, float32  # noqa: E402
from seam import Seam  # noqa: E402

CONFIG = BEGINNING + """
clock_rate = {clock_rate}
compare_uncorrected = true
[signals]
speed = {{ source = "device", register = 8, type = "float32" }}
load = {{ source = "device", register = 10, type = "float32" }}
coolant = {{ source = "device", register = 6, type = "float32" }}
ambient = {{ source = "constant", value = 22.0 }}
[correction]
law = "estimator"
{more}"""
CHECKPOINT = '[checkpoint]\npath = "files/twin.checkpoint"\ninterval_s = {interval_s}\n'

SEQUENCE, STATE, FAULT, NOSE, TARE, OVERRUNS, MODEL_TIME = 8, 10, 12, 20, 26, 30, 32
NOSE_SD, POINTS, UNCORRECTED = 122, 234, 266
ORDER_TARE, ORDER_ID, DONE = 1005, 1028, 2
ORDERS_LOST, ORDERS_NOT_KEPT, HISTORY_LOST, CHECKPOINT_LOST = 16, 32, 128, 256
AMBIENT_DEGC = 22.0


class Twin:
    """In a folder of its own, its files in `files` below it, one start after the other."""

    environment = None  # of a daemon without the seam; None: this process's

    def __init__(self, programs, folder, device_port, more="", clock_rate=100.0, runs_behind_seam=True, config=CONFIG):
        self.programs, self.folder, self.files = programs, folder, folder / "files"
        self.files.mkdir(parents=True)
        subprocess.run([programs["make_network"], folder / "small.rom"], check=True)
        self.port = free_port()
        self.config = folder / "twin.toml"
        self.config.write_text(config.format(port=self.port, device=device_port, more=more, clock_rate=clock_rate))
        self.seam = Seam(self.files, folder) if runs_behind_seam else None
        self.checkpoint, self.orders = self.files / "twin.checkpoint", self.files / "twin.checkpoint.orders"
        self.log_path, self.log_from = folder / "log", 0
        self.log_path.touch()
        self.daemon, self.client, self.order_number = None, None, 0

    def start(self):
        """The daemon's process; it answers once wait_until_it_answers() is back."""
        self.log_from = self.log_path.stat().st_size
        with open(self.log_path, "a") as log:
            self.daemon = subprocess.Popen([self.programs["daemon"], self.config], stderr=log,
                                           env=self.seam.environment() if self.seam else self.environment)
        self.client = ModbusTcpClient("127.0.0.1", port=self.port)

    def wait_until_it_answers(self):
        wait_until(lambda: self.is_over() or can_connect(self.port), "the daemon's port")
        demand(not self.is_over(), f"the daemon ended by itself with {self.daemon.returncode}: {self.log()}")
        demand(self.client.connect(), "no connection")

    def is_over(self):
        return self.daemon.poll() is not None

    def end(self, by=signal.SIGKILL):
        self.daemon.send_signal(by)
        self.gone()
        return self.daemon.returncode

    def gone(self, seconds=30.0):
        """Waits until the process is gone."""
        self.daemon.wait(seconds)
        self.client.close()

    def read(self, first, count):
        reply = self.client.read_input_registers(first, count, slave=1)
        demand(not reply.isError(), f"{self.folder.name}: no answer of {first}: {reply}")
        return reply.registers

    def floats(self, first, count):
        words = self.read(first, 2 * count)
        return [float32(*words[at:at + 2]) for at in range(0, 2 * count, 2)]

    def number(self, first):
        high, low = self.read(first, 2)
        return high << 16 | low

    def fault(self):
        return self.read(FAULT, 1)[0]

    def nose_um(self):
        """With the tare."""
        return self.floats(NOSE, 1)[0] + self.floats(TARE, 1)[0]

    def order_tare(self):
        self.order_number += 1
        for register, value in ((ORDER_ID, self.order_number), (ORDER_TARE, 1)):
            demand(not self.client.write_register(register, value, slave=1).isError(), "the order was refused")

    def order_result(self):
        block = self.read(1404, 24)
        return dict(zip(block[:8], block[16:])).get(self.order_number)

    def take_tare(self):
        """Until it is acknowledged; the tare in um."""
        self.order_tare()
        wait_until(lambda: self.order_result() == DONE, "the tare")
        return self.floats(TARE, 1)[0]

    def log(self):
        """Of this start."""
        with open(self.log_path) as log:
            log.seek(self.log_from)
            return log.read()


class Device:
    """Input registers by Modbus/TCP: float32 numbers that the test sets."""

    def __init__(self, numbers):
        self.numbers = numbers
        device = self

        class Answer(socketserver.BaseRequestHandler):
            def next_one(self):
                try:
                    return self.request.recv(12)
                except ConnectionResetError:  # a daemon that was killed
                    return b""

            def handle(self):
                while len(request := self.next_one()) == 12:
                    first, count = struct.unpack(">HH", request[8:])
                    data = struct.pack(f">{len(device.numbers)}f", *device.numbers)[2 * first:2 * (first + count)]
                    self.request.sendall(request[:4] + struct.pack(">H", 3 + len(data)) + request[6:8] +
                                         bytes([len(data)]) + data)

        class Server(socketserver.ThreadingTCPServer):
            allow_reuse_address = daemon_threads = True

        self.server = Server(("127.0.0.1", 0), Answer)
        self.port = self.server.server_address[1]
        threading.Thread(target=self.server.serve_forever, daemon=True).start()


class Machine:
    """A spindle that is 0.8 as warm as the network's model says, whose sensors have 0.01 K of noise. Its speed and load
    change by the clock. What the model says is told by an uninterrupted twin, `reference`, as that of no correction."""
    SHARE, NOISE_K = 0.8, 0.01
    COURSE = ((6000.0, 1.0), (3000.0, 0.5), (9000.0, 0.8), (0.0, 0.0), (4500.0, 0.3))  # rpm, load
    EACH_S = 240.0  # of the model

    def __init__(self, programs, folder, seed, clock_rate):
        self.noise, self.clock_rate, self.began_s, self.is_on = random.Random(seed), clock_rate, time.time(), True
        self.device = Device([AMBIENT_DEGC] * 4 + [0.0, 0.0])
        self.reference = Twin(programs, folder, self.device.port, clock_rate=clock_rate, runs_behind_seam=False)
        self.reference.start()
        self.reference.wait_until_it_answers()
        self.watch = ModbusTcpClient("127.0.0.1", port=self.reference.port)
        demand(self.watch.connect(), "no connection to the reference")
        self.thread = threading.Thread(target=self.go_on)
        self.thread.start()

    def go_on(self):
        while self.is_on:
            words = self.watch.read_input_registers(UNCORRECTED, 6, slave=1).registers
            model_degC = [float32(*words[at:at + 2]) for at in (0, 2, 4)]
            step = self.step()
            self.device.numbers = [
                AMBIENT_DEGC if value != value else
                AMBIENT_DEGC + self.SHARE * (value - AMBIENT_DEGC) + self.noise.gauss(0.0, self.NOISE_K)
                for value in model_degC] + [AMBIENT_DEGC, *self.COURSE[step % len(self.COURSE)]]
            time.sleep(0.5 / self.clock_rate)

    def step_at(self, unix_s):
        """How often speed and load had changed then."""
        return int(self.clock_rate * (unix_s - self.began_s) / self.EACH_S)

    def step(self):
        return self.step_at(time.time())

    def end(self):
        self.is_on = False
        self.thread.join()
        self.watch.close()
        self.reference.end()
