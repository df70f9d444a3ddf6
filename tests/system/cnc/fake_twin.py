"""A spindle-twind that shows what a test tells it: the registers that LinuxCNC reads, and every way to fail."""
import contextlib
import pathlib
import socket
import struct
import threading
import tomllib

REGISTERS = pathlib.Path(__file__).resolve().parents[3] / "firmware" / "serve" / "registers.toml"
PORT = 1502  # as in spindle_twin_mb2hal.ini


def addresses():
    """Address of each register by its name, and the version of the map."""
    table = tomllib.loads(REGISTERS.read_text(encoding="utf-8"))
    return ({register["name"]: register["address"] for block in table["block"] for register in block["register"]},
            table["map_version"])


class FakeTwin:
    """Serves from start() on; the heartbeat counts once a second, as a daemon's does."""

    def __init__(self):
        self.address, self.version = addresses()
        self.words = {}
        self.lock = threading.Lock()
        self.beats = True
        self.answers = True
        self.closed = threading.Event()
        self.door = None
        self.clients = []
        self.be_good(0)
        threading.Thread(target=self.beat, daemon=True).start()

    def put(self, **values):
        """Registers by name; all at once, as one cycle publishes them."""
        with self.lock:
            for name, value in values.items():
                self.words[self.address[name]] = value & 0xFFFF

    def be_good(self, tenths_um):
        self.beats = self.answers = True
        self.put(compensation_state=1, compensation_quality=0, compensation_fault=0, compensation_rung=1,
                 compensation_bits=1, compensation_age=0, known_uint16=0x1234, map_version=self.version,
                 compensation_int16=tenths_um)

    def beat(self):
        heartbeat = 65530  # over its wrap soon
        while not self.closed.wait(1.0):
            if self.beats:
                heartbeat += 1
                self.put(compensation_heartbeat=heartbeat)

    def start(self):
        self.door = socket.create_server(("127.0.0.1", PORT))
        threading.Thread(target=self.accept, args=(self.door,), daemon=True).start()

    def stop(self):
        """As when the daemon ends: no new connection, and those that are there break."""
        self.door.shutdown(socket.SHUT_RDWR)
        self.door.close()
        for client in self.clients:
            with contextlib.suppress(OSError):
                client.shutdown(socket.SHUT_RDWR)
            client.close()
        self.clients = []

    def accept(self, door):
        with contextlib.suppress(OSError):
            while True:
                client, _ = door.accept()
                self.clients.append(client)
                threading.Thread(target=self.serve, args=(client,), daemon=True).start()

    def serve(self, client):
        with contextlib.suppress(OSError):
            while len(request := client.recv(12, socket.MSG_WAITALL)) == 12:
                number, protocol, _, unit, function, first, count = struct.unpack(">HHHBBHH", request)
                while not self.answers and not self.closed.wait(0.05):
                    pass
                with self.lock:
                    words = [self.words.get(first + n, 0xFFFF) for n in range(count)]
                head = struct.pack(">HHHBBB", number, protocol, 3 + 2 * count, unit, function, 2 * count)
                client.sendall(head + struct.pack(f">{count}H", *words))

    def close(self):
        self.closed.set()
        self.stop()
