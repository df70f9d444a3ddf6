"""A device by Modbus/TCP that does wrong what the test asks for, and the cable to it."""
import ctypes
import os
import socket
import struct
import subprocess
import threading
import time

CLONE_NEWNET = 0x40000000


def far_networks_are_possible():
    """Whether this process may make network namespaces; it has to be in one of its own then."""
    return os.geteuid() == 0 and subprocess.run(["unshare", "--net", "true"], capture_output=True).returncode == 0


class Cable:
    """To another network namespace, in which the device then is; this process has to be in one of its own."""

    def __init__(self, number):
        self.near = f"near{number}"
        # A process of its own keeps the namespace; it ends with its standard input.
        self.keeper = subprocess.Popen(["unshare", "--net", "sh", "-c", "echo here; cat"], stdin=subprocess.PIPE,
                                       stdout=subprocess.PIPE)
        self.keeper.stdout.readline()
        self.address = f"10.77.{number}.2"
        far = ["nsenter", "--net", "--target", str(self.keeper.pid), "ip"]
        for command in (["ip", "link", "add", self.near, "type", "veth", "peer", "name", "far", "netns",
                         str(self.keeper.pid)],
                        ["ip", "addr", "add", f"10.77.{number}.1/24", "dev", self.near], ["ip", "link", "set", self.near, "up"],
                        far + ["addr", "add", f"{self.address}/24", "dev", "far"], far + ["link", "set", "far", "up"]):
            subprocess.run(command, check=True)

    def enter(self):
        """The calling thread; what it opens from then on is at the cable's other end."""
        with open(f"/proc/{self.keeper.pid}/ns/net") as network:
            if ctypes.CDLL(None, use_errno=True).setns(network.fileno(), CLONE_NEWNET) != 0:
                raise OSError(ctypes.get_errno(), "setns")

    def pull(self, out=True):
        subprocess.run(["ip", "link", "set", self.near, "down" if out else "up"], check=True)

    def end(self):
        self.keeper.stdin.close()
        self.keeper.wait()


class Device:
    """Float32 numbers, those that `machine` has then. `change` gives the bytes to send in place of an answer, None: the
    connection is reset; they are sent after `wait_s`."""

    def __init__(self, machine, cable=None):
        self.machine, self.cable, self.address, self.port = machine, cable, "127.0.0.1", 0
        if cable is not None:
            self.address = cable.address
        self.be_well()
        self.come()

    def be_well(self):
        self.change, self.wait_s = lambda answer: answer, 0.0

    def come(self):
        ready = threading.Event()
        self.here = True
        threading.Thread(target=self.serve, args=(ready,), daemon=True).start()
        if not ready.wait(30.0):
            raise AssertionError("the device's port cannot be listened on")

    def go(self):
        self.here = False
        self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()

    def serve(self, ready):
        if self.cable is not None:
            self.cable.enter()
        while True:
            try:
                self.listener = socket.create_server((self.address, self.port))
                break
            except OSError:  # the connections of before are still being closed
                time.sleep(0.05)
        self.port = self.listener.getsockname()[1]
        ready.set()
        listener = self.listener
        while True:
            try:
                client, _ = listener.accept()
            except OSError:
                return
            threading.Thread(target=self.answer, args=(client,), daemon=True).start()

    def answer(self, client):
        with client:
            try:
                while len(request := client.recv(12)) == 12 and self.here:
                    first, count = struct.unpack(">HH", request[8:])
                    numbers = self.machine.numbers
                    data = struct.pack(f">{len(numbers)}f", *numbers)[2 * first:2 * (first + count)]
                    sent = self.change(request[:4] + struct.pack(">H", 3 + len(data)) + request[6:8] + bytes([len(data)]) + data)
                    time.sleep(self.wait_s)
                    if sent is None:
                        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                        return
                    client.sendall(sent)
            except OSError:
                pass
