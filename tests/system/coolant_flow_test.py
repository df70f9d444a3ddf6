"""The flow of a coolant circuit on its way from the machine to the prediction, and back out of the history.

coolant_flow_test.py SPINDLE_TWIN SPINDLE_TWIND SPINDLES_FOLDER [unittest options]
"""
import csv
import pathlib
import signal
import subprocess
import unittest

from pymodbus.client import ModbusTcpClient

from host_tool_case import DAEMON, SPINDLES, TWIN, Case
from ports import can_connect, free_port, wait_until

JACKET = pathlib.Path(SPINDLES) / "jacket_circuit.toml"
CONFIG = """
network = "jacket.rom"
[cycle]
clock_rate = 100.0
[serve]
port = {port}
[device]
port = {device}
poll_s = 1.0
[start]
temperature_degC = 22.0
[signals]
speed = {{ source = "device", register = 4, type = "uint16", first = 6000.0, stale_after_s = 100.0 }}
load = {{ source = "device", register = 5, scale = 0.001, first = 1.0, stale_after_s = 100.0 }}
coolant = {{ source = "device", register = 6, scale = 0.01, stale_after_s = 100.0 }}
ambient = {{ source = "device", register = 7, scale = 0.01, first = 22.0, stale_after_s = 100.0 }}
flow.helix = {{ source = "device", register = 24, scale = 1e-4, stale_after_s = 100.0 }}
[history]
path = "history.csv"
"""
# Forwards, backwards at a fifth.
SCHEDULE = "time_s,speed_rpm,load,helix_kg_per_s\n0,6000,1,0.02\n120,6000,1,-0.004\n100000,6000,1,-0.004\n"


class CoolantFlow(Case):
    def start(self, *command):
        log = open(self.folder / "log", "a")
        process = subprocess.Popen(list(map(str, command)), stdout=log, stderr=log)
        self.addCleanup(lambda: (process.kill(), process.wait(), log.close()))
        return process

    def history(self):
        with open(self.folder / "history.csv") as file:
            return [{name: float(value) for name, value in row.items() if value} for row in csv.DictReader(file)]

    def test_what_the_device_shows_drives_the_prediction_and_replays_from_the_history(self):
        self.good("build", JACKET, "-o", self.folder / "jacket.rom", "--nodes", 40, "--certificate-cases", 1)
        plant_port, port = free_port(), free_port()
        config = self.text("twin.toml", CONFIG.format(port=port, device=plant_port))
        schedule = self.text("plant.csv", SCHEDULE)
        plant = self.start(TWIN, "plant", JACKET, "--port", plant_port, "--rate", 100, "--schedule", schedule,
                           "--wait-for-client")
        wait_until(lambda: "serving" in (self.folder / "log").read_text(), "the plant's start")
        daemon = self.start(DAEMON, config)
        wait_until(lambda: can_connect(port), "the daemon's port")
        client = ModbusTcpClient("127.0.0.1", port=port)
        self.addCleanup(client.close)
        self.assertTrue(client.connect())
        read = lambda first, count: client.read_input_registers(first, count, slave=1).registers
        wait_until(lambda: read(32, 2)[1] >= 260, "260 s of model time")
        self.assertEqual(read(116, 5), [65536 - 40, 0x8000, 0x8000, 0x8000, 1])
        self.assertEqual(read(10, 1), [1], "not running")
        for process in (daemon, plant):
            process.send_signal(signal.SIGTERM)
            self.assertEqual(process.wait(20), 0)

        rows = self.history()
        flows = [row["flow.helix_kg_per_s"] for row in rows]
        self.assertEqual(sorted(set(flows)), [-0.004, 0.02])
        warmer_at_outlet = [row["predicted.bore_rear_degC"] - row["predicted.bore_front_degC"] for row in rows]
        self.assertGreater(warmer_at_outlet[flows.index(-0.004) - 1], 0.5)
        self.assertLess(warmer_at_outlet[-1], warmer_at_outlet[flows.index(-0.004) - 1] - 0.5)

        # A row's inputs were held over the period that ends with it.
        period_s = 1.0
        lines = ["time_s,speed_rpm,load,coolant_degC,ambient_degC,helix_kg_per_s"]
        begin_s = 0.0
        for row in rows:
            inputs = [row[key] for key in ("speed_rpm", "load", "coolant_degC", "ambient_degC", "flow.helix_kg_per_s")]
            lines.append(",".join(map(repr, [begin_s, *inputs])))
            begin_s = row["time_s"]
        lines.append(",".join(map(repr, [begin_s, *inputs])))
        again = self.folder / "again.csv"
        self.good("simulate", self.folder / "jacket.rom", "--schedule", self.text("replay.csv", "\n".join(lines) + "\n"),
                  "-o", again, "--period", period_s, "--every", period_s)
        with open(again) as file:
            replayed = {round(float(row["time_s"])): row for row in csv.DictReader(file)}
        for row in rows:
            for point in ("bore_front", "bore_rear"):
                self.assertAlmostEqual(float(replayed[round(row["time_s"])][f"{point}_degC"]),
                                       row[f"predicted.{point}_degC"], delta=0.01, msg=row["time_s"])

        # The daemon's own cycle on its own history: the same predictions to the last digit.
        replayed = self.folder / "replayed.csv"
        self.good("replay", self.folder / "jacket.rom", self.folder / "history.csv", "--config", config, "-o", replayed)
        with open(self.folder / "history.csv") as ours, open(replayed) as theirs:
            pairs = list(zip(csv.DictReader(ours), csv.DictReader(theirs), strict=True))
        for told, again in pairs:
            for name, value in told.items():
                if name not in ("quality", "state"):  # a signal that was held is simply there
                    self.assertEqual(again[name], value, f"{name} at {told['time_s']} s")


if __name__ == "__main__":
    unittest.main(verbosity=2)
