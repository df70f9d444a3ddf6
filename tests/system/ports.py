"""Ports of this machine, and waiting for what another program does."""
import itertools
import os
import socket
import time

PATIENCE = float(os.environ.get("SPINDLE_TWIN_PATIENCE", "1"))  # for programs that run slowly, as under a sanitizer


# Below those that the system gives to clients: one of those may be taken by any connection before a server has it, even
# by one that tries to reach that server. Each process begins elsewhere and asks for none twice.
FIRST = 10000


def first_of_clients():
    with open("/proc/sys/net/ipv4/ip_local_port_range", encoding="ascii") as bounds:
        return int(bounds.read().split()[0])


COUNT = max(first_of_clients() - FIRST, 5000)
offers = itertools.count(61 * os.getpid())
kept = []  # a name per port, held until this process ends


def keep_from_others(port):
    """False if another test's process has this port, though nothing may listen there just now. A name without a file
    belongs to the network namespace, as the ports do, and goes with its process."""
    name = socket.socket(socket.AF_UNIX)
    try:
        name.bind(f"\0spindle_twin_port_{port}")
    except OSError:
        name.close()
        return False
    kept.append(name)
    return True


def free_port():
    for offer in itertools.islice(offers, COUNT):
        port = FIRST + offer % COUNT
        with socket.socket() as probe:
            try:  # without SO_REUSEADDR, as some servers do: connections that have ended hold their port for a minute
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
        if keep_from_others(port):
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
