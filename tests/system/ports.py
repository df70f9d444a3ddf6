"""Ports of this machine, and waiting for what another program does."""
import os
import socket
import time

PATIENCE = float(os.environ.get("SPINDLE_TWIN_PATIENCE", "1"))  # for programs that run slowly, as under a sanitizer


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


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
