"""Ports of this machine, and waiting for what another program does."""
import itertools
import os
import socket
import time

PATIENCE = float(os.environ.get("SPINDLE_TWIN_PATIENCE", "1"))  # for programs that run slowly, as under a sanitizer


# Below those that the system gives to clients: one of those may be taken by any connection before a server has it. Each
# process begins elsewhere and asks for none twice.
FIRST, COUNT = 16000, 16000
offers = itertools.count(61 * os.getpid())


def free_port():
    for offer in itertools.islice(offers, COUNT):
        port = FIRST + offer % COUNT
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
        return port
    raise AssertionError(f"no port from {FIRST} on is free")


def can_connect(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def wait_until(condition, what, seconds=60.0):
    end = time.monotonic() + PATIENCE * seconds
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError(f"{what} did not happen within {seconds} s")
