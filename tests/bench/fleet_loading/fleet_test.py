"""Simulated spindles publish through a real mosquitto and host_tools/fleet/bridge into a real victoria-metrics, the
broker goes away meanwhile; then the store has every sample that was not counted as dropped, and the board every spindle.

fleet_test.py FLEET_NODES [--spindles N] [--period S] [--seconds S] [--away S] [--queue N] [--processes N]
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import urllib.parse
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "system"))
from ports import can_connect, free_port, wait_until  # noqa: E402

FLEET = ROOT / "host_tools" / "fleet"
PYTHON = "/usr/bin/python3"  # for which Debian has paho-mqtt


class Plant:
    """Broker, store and bridge, with what each took of memory at the most."""

    def __init__(self, folder):
        self.folder, self.processes, self.most_MiB = folder, {}, {}
        self.broker_port, self.store_port = free_port(), free_port()
        kept = [line for line in (FLEET / "mosquitto.conf").read_text().splitlines() if line.startswith(("queue", "max", "autosave"))]
        (folder / "mosquitto.conf").write_text(f"listener {self.broker_port} 127.0.0.1\nallow_anonymous true\n"
                                               f"persistence true\npersistence_location {folder}/\nuser root\n" + "\n".join(kept) + "\n")
        self.log = open(folder / "log", "a")
        self.store = f"http://127.0.0.1:{self.store_port}"
        self.start("store", ["/usr/bin/victoria-metrics", f"-storageDataPath={folder / 'store'}", "-retentionPeriod=1",
                             f"-httpListenAddr=127.0.0.1:{self.store_port}", "-search.latencyOffset=0s",
                             "-dedup.minScrapeInterval=1ms", "-search.disableCache", "-loggerLevel=ERROR"])
        self.start_broker()
        wait_until(lambda: can_connect(self.store_port), "the store's port")
        self.start("bridge", [PYTHON, FLEET / "bridge", "--broker", f"127.0.0.1:{self.broker_port}", "--store", self.store])
        wait_until(lambda: "bridge: hears" in (folder / "log").read_text(), "the bridge's subscription")

    def start(self, name, command):
        self.processes[name] = subprocess.Popen(["bash", "-c", 'ulimit -n "$(ulimit -Hn)"; exec "$@"', "_",
                                                 *map(str, command)], stderr=self.log,
                                                stdout=self.log if name != "store" else subprocess.DEVNULL)

    def start_broker(self):
        self.start("broker", ["/usr/sbin/mosquitto", "-c", self.folder / "mosquitto.conf"])
        wait_until(lambda: can_connect(self.broker_port), "the broker's port")

    def stop(self, name):
        self.processes[name].terminate()
        self.processes.pop(name).wait(60)

    def look_at_memory(self):
        for name, process in self.processes.items():
            status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
            used = re.search(r"VmRSS:\s+(\d+)", status)
            self.most_MiB[name] = max(self.most_MiB.get(name, 0.0), int(used[1]) / 1024 if used else 0.0)

    def ask(self, query):
        url = f"{self.store}/api/v1/query?" + urllib.parse.urlencode({"query": query, "nocache": "1"})
        with urllib.request.urlopen(url, timeout=120) as reply:
            return json.load(reply)["data"]["result"]

    def stored(self):
        """Samples of each node."""
        urllib.request.urlopen(f"{self.store}/internal/force_flush", timeout=120).close()
        return {sample["metric"]["node"]: int(sample["value"][1])
                for sample in self.ask("count_over_time(spindle_twin_sequence[1d])")}

    def close(self):
        for name in list(self.processes):
            self.stop(name)
        self.log.close()


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--spindles", type=int, default=200)
    parser.add_argument("--period", type=float, default=1.0)
    parser.add_argument("--seconds", type=float, default=16.0)
    parser.add_argument("--away", type=float, default=5.0, help="the broker is away for so long, in the middle")
    parser.add_argument("--queue", type=int, default=3)
    parser.add_argument("--processes", type=int, default=1)
    return parser.parse_args()


def start_spindles(options, plant):
    each = options.spindles // options.processes
    started = []
    for number in range(options.processes):
        said = open(plant.folder / f"said_{number}", "w+")
        started.append((subprocess.Popen([options.program, "--port", str(plant.broker_port), "--nodes", str(each), "--first",
                                          str(each * number), "--period", str(options.period), "--seconds",
                                          str(options.seconds), "--queue", str(options.queue)], stdout=said,
                                         stderr=plant.log), said))
    return started


def watch(plant, seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        plant.look_at_memory()
        time.sleep(min(1.0, max(0.0, end - time.monotonic())))


def publish(options, plant):
    """What each node says of itself."""
    spindles = start_spindles(options, plant)
    watch(plant, (options.seconds - options.away) / 2)
    if options.away > 0.0:
        plant.stop("broker")
        watch(plant, options.away)
        plant.start_broker()
    said = {}
    try:
        while any(process.poll() is None for process, _ in spindles):
            watch(plant, 1.0)
        for _, lines in spindles:
            lines.seek(0)
            for line in lines:
                node = json.loads(line)
                said[node.pop("node")] = node
    finally:
        for process, lines in spindles:
            process.kill()
            process.wait()
            lines.close()
    return said


def judge(options, plant, said):
    wrong = []
    for node, counts in said.items():
        if counts["made"] - counts["dropped"] != counts["published"]:
            wrong.append(f"{node}: {counts}")
    if len(said) != options.spindles:
        wrong.append(f"{len(said)} nodes, not {options.spindles}")
    def lacking():
        """Nodes with fewer samples in the store than made and not dropped, or with more than made. One that was sent and
        not answered before it was dropped may be there all the same."""
        stored = plant.stored()
        return {node: stored.get(node, 0) for node, counts in said.items()
                if not counts["made"] - counts["dropped"] <= stored.get(node, 0) <= counts["made"]}

    try:
        wait_until(lambda: not lacking(), "all samples in the store", 120)
    except AssertionError:
        different = lacking()
        wrong += [f"{len(different)} nodes are not whole in the store",
                  *(f"{node}: stored {count}, {said[node]}" for node, count in list(different.items())[:5])]
    plant.look_at_memory()
    return wrong


def main():
    options = arguments()
    with tempfile.TemporaryDirectory() as folder:
        plant = Plant(pathlib.Path(folder))
        try:
            said = publish(options, plant)
            wrong = judge(options, plant, said)
            board = subprocess.run([PYTHON, FLEET / "board", "--store", plant.store], capture_output=True, text=True,
                                   timeout=120)
            if f"{options.spindles} spindles: " not in board.stdout:
                wrong.append(f"the board says {board.stdout[-500:]} {board.stderr}")
        finally:
            plant.close()
        if wrong:
            print(pathlib.Path(folder, "log").read_text()[-3000:])
    total = {kind: sum(counts[kind] for counts in said.values()) for kind in ("made", "published", "dropped")}
    print(f"{options.spindles} spindles, a sample each {options.period:g} s for {options.seconds:g} s, the broker away for "
          f"{options.away:g} s, queue {options.queue}:")
    print(f"  {total['made']} samples made, {total['dropped']} dropped and counted, {total['published']} read by the broker and "
          f"{'not all' if wrong else 'all'} in the store")
    print("  memory at the most: " + ", ".join(f"{name} {most:.1f} MiB" for name, most in sorted(plant.most_MiB.items())))
    for line in wrong:
        print("WRONG:", line)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
