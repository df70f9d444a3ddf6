"""Passes connections on to a server and keeps what went over them as a capture file of TCP frames, port 502, so that
Wireshark judges the conversation; needs no rights beyond opening a socket."""
import itertools
import selectors
import socket
import struct
import threading
import time

SERVER_PORT = 502
CLIENT_ADDRESS, SERVER_ADDRESS = bytes((10, 0, 0, 1)), bytes((10, 0, 0, 2))
FIN, SYN, PUSH, ACK = 0x01, 0x02, 0x08, 0x10
RAW_IPV4 = 228  # link type: packets begin with the IPv4 header


def ones_complement_sum(data):
    words = struct.unpack(f">{(len(data) + 1) // 2}H", data + bytes(len(data) % 2))
    total = sum(words)
    while total > 0xFFFF:
        total = (total & 0xFFFF) + (total >> 16)
    return ~total & 0xFFFF


class Capture:
    """A pcap file; one connection is told apart from the next by its client's port."""

    def __init__(self, path):
        self.file = open(path, "wb")
        self.file.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, RAW_IPV4))

    def packet(self, ends, ports, numbers, flags, payload):
        tcp = struct.pack(">HHIIBBHHH", *ports, *numbers, 5 << 4, flags, 65535, 0, 0)
        pseudo = ends[0] + ends[1] + struct.pack(">BBH", 0, 6, len(tcp) + len(payload))
        tcp = tcp[:16] + struct.pack(">H", ones_complement_sum(pseudo + tcp + payload)) + tcp[18:]
        ip = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(tcp) + len(payload), 0, 0, 64, 6, 0) + ends[0] + ends[1]
        ip = ip[:10] + struct.pack(">H", ones_complement_sum(ip)) + ip[12:]
        data = ip + tcp + payload
        now_s = time.time()
        self.file.write(struct.pack("<IIII", int(now_s), int(now_s % 1 * 1e6), len(data), len(data)) + data)

    def close(self):
        self.file.close()


class Conversation:
    """One connection: two sockets, and how far each side has counted its bytes."""

    def __init__(self, capture, client, server, port):
        self.capture, self.port = capture, port
        self.sockets = (client, server)
        self.sent = [0, 0]
        self.record(0, SYN)
        self.record(1, SYN | ACK)
        self.record(0, ACK)

    def record(self, side, flags, payload=b""):
        ends = (CLIENT_ADDRESS, SERVER_ADDRESS) if side == 0 else (SERVER_ADDRESS, CLIENT_ADDRESS)
        ports = (self.port, SERVER_PORT) if side == 0 else (SERVER_PORT, self.port)
        acknowledged = self.sent[1 - side] if flags & ACK else 0
        self.capture.packet(ends, ports, (self.sent[side], acknowledged), flags, payload)
        self.sent[side] += len(payload) + (1 if flags & (SYN | FIN) else 0)


class RecordingRelay:
    """Listens on `port` and passes everything on to the server's; one thread, ended by close()."""

    def __init__(self, server_port, path):
        self.server_port = server_port
        self.capture = Capture(path)
        self.client_ports = itertools.count(20000)
        self.selector = selectors.DefaultSelector()
        self.listener = socket.create_server(("127.0.0.1", 0), backlog=128)
        self.port = self.listener.getsockname()[1]
        self.selector.register(self.listener, selectors.EVENT_READ)
        self.open = True
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        while self.open:
            for key, _ in self.selector.select(0.1):
                if key.fileobj is self.listener:
                    self.accept()
                else:
                    self.pass_on(key.fileobj, *key.data)
        for key in list(self.selector.get_map().values()):
            key.fileobj.close()
        self.capture.close()

    def accept(self):
        client, _ = self.listener.accept()
        try:
            server = socket.create_connection(("127.0.0.1", self.server_port))
        except OSError:
            client.close()
            return
        both = Conversation(self.capture, client, server, next(self.client_ports))
        for side, end in enumerate(both.sockets):
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.selector.register(end, selectors.EVENT_READ, (both, side))

    def pass_on(self, end, both, side):
        if end.fileno() < 0:
            return  # the other side has ended in the same round
        try:
            data = end.recv(65536)
            if data:
                both.record(side, PUSH | ACK, data)
                both.sockets[1 - side].sendall(data)
                return
        except OSError:
            pass
        both.record(side, FIN | ACK)
        both.record(1 - side, FIN | ACK)
        for each in both.sockets:
            self.selector.unregister(each)
            each.close()

    def close(self):
        self.open = False
        self.thread.join()
        self.selector.close()
