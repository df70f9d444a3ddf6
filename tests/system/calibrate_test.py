"""A thermal test becomes a calibration, and the daemon starts from it.

calibrate_test.py DAEMON MAKE_SMALL_NETWORK SPINDLE_TWIN [unittest options]
"""
import csv
import json
import os
import random
import signal
import struct
import subprocess
import sys
import time

from ports import wait_until
from running_daemon import PROGRAMS, RunningDaemon, float32, main

SENSORS = ("sleeve_inner", "sleeve_middle", "sleeve_outer")
FASTER_THAN_TOLD = ((0, 7000, 6000), (2400, 12000, 10300), (4800, 3500, 3000))  # from time_s on: real rpm, told rpm
RUNS_WHILE_TOLD_TO_STAND = ((0, 6000, 6000), (2400, 3000, 0))


class Calibrate(RunningDaemon):
    def setUp(self):
        super().setUp()
        self.daemon.send_signal(signal.SIGTERM)
        self.daemon.wait(20)
        self.rom = self.folder / "small.rom"

    def tool(self, *arguments):
        return subprocess.run([PROGRAMS["tool"], *map(str, arguments)], capture_output=True, text=True, timeout=120)

    def thermal_test(self, name, probe=lambda time_s, nose_um: nose_um + 40.0, drives=FASTER_THAN_TOLD):
        """Two hours of a machine whose heats are not what its network says: it runs at other speeds than it tells."""
        real = self.folder / "schedule.csv"
        rows = [f"{time_s},{real_rpm},1,20,20\n" for time_s, real_rpm, _ in (*drives, (7200, *drives[-1][1:]))]
        real.write_text("time_s,speed_rpm,load,ambient_degC,coolant_degC\n" + "".join(rows))
        run = self.folder / "run.csv"
        made = self.tool("simulate", self.rom, "--schedule", real, "-o", run)
        self.assertEqual(made.returncode, 0, made.stderr)
        chance = random.Random(5)
        lines = ["time_s,speed_rpm,load,ambient_degC,coolant_degC,"
                 + ",".join(f"measured.{sensor}_degC" for sensor in SENSORS) + ",measured.nose_um"]
        for row in csv.DictReader(run.read_text().splitlines()):
            time_s = float(row["time_s"])
            told_rpm = next(told for from_s, _, told in reversed(drives) if time_s >= from_s)
            readings = [f"{float(row[sensor + '_degC']) + chance.gauss(0, 0.02):.4f}" for sensor in SENSORS]
            nose_um = probe(time_s, float(row["nose_um"])) + chance.gauss(0, 1)
            lines.append(f"{time_s},{told_rpm},1,20,20,{','.join(readings)},{nose_um:.3f}")
        log = self.folder / name
        log.write_text("\n".join(lines) + "\n")
        return log

    def calibrated(self):
        file = self.folder / "machine.calibration"
        made = self.tool("calibrate", self.rom, self.thermal_test("test.csv"), "-o", file, "--json")
        self.assertEqual((made.returncode, made.stderr), (0, ""))
        return file, json.loads(made.stdout)

    def configure(self, text):
        """`text`: of [correction], behind its header."""
        config = self.config_text.format(port=self.port, device=self.device_port)
        self.config.write_text(config.replace('law = "estimator"\n', 'law = "estimator"\n' + text))

    def check(self):
        return subprocess.run([PROGRAMS["daemon"], "--check", self.config], capture_output=True, text=True, timeout=60)

    def test_a_machine_that_runs_hotter_than_its_network_is_found_and_promised(self):
        file, said = self.calibrated()
        self.assertTrue(file.stat().st_size > 300)
        self.assertTrue(said["fits"])
        found = {parameter["name"]: parameter for parameter in said["parameters"]}
        self.assertGreater(found["heat bearing"]["value"], 0.1)  # ln of some (7000 / 6000)^1.3
        self.assertLess(found["heat bearing"]["deviation"], 0.1)
        self.assertFalse(found["film air"]["determined"])
        self.assertLess(said["promised_um"], 2.0)
        again = self.tool("calibrate", self.rom, self.folder / "test.csv", "--json")
        self.assertEqual(json.loads(again.stdout), said)

    def test_the_daemon_starts_from_it_and_says_of_when_it_is(self):
        before = self.check()
        self.assertEqual(before.returncode, 0, before.stderr)
        file, said = self.calibrated()
        self.configure(f'calibration = "{file.name}"\n[correction.drift]\nheat = 0.02\n')
        after = self.check()
        self.assertEqual(after.returncode, 0, after.stderr)
        self.assertRegex(after.stdout, r"machine\.calibration: calibrated 20\d\d-\d\d-\d\d from 2\.0 h of test")
        deviation_um = [float(result.stdout.split("standard deviation ")[1].split(" um")[0]) for result in (before, after)]
        self.assertLess(deviation_um[1], 0.5 * deviation_um[0])
        self.start_again()
        self.assert_logged("machine.calibration: calibrated")
        self.write_signals()
        self.wait_for_state(1)
        made, promise = self.read(936, 2), self.read(938, 2)
        self.assertLess(abs(time.time() - (made[0] * 65536 + made[1])), 600)
        self.assertAlmostEqual(float32(*promise), said["promised_um"], places=4)
        replayed = self.tool("replay", self.rom, self.folder / "test.csv", "--sensors", "sleeve_inner", "--json",
                             "--calibration", file, "--start-degC", "20")
        self.assertEqual(replayed.returncode, 0, replayed.stderr)
        plain = self.tool("replay", self.rom, self.folder / "test.csv", "--sensors", "sleeve_inner", "--json",
                          "--start-degC", "20")
        rms_um = [json.loads(result.stdout)["deformations"][0]["sd_um"] for result in (replayed, plain)]
        self.assertLess(rms_um[0], 0.5 * rms_um[1])

    def test_without_sensors_the_calibrated_model_is_what_is_published(self):
        file, said = self.calibrated()
        log = self.folder / "test.csv"
        asked = ("replay", self.rom, log, "--json", "--start-degC", "20", "--correction", "none")
        errors = [json.loads(self.tool(*asked, *more).stdout)["deformations"][0]["twin"]
                  for more in ((), ("--calibration", file))]
        self.assertLess(errors[1]["rms_um"], errors[0]["rms_um"])
        config = self.config_text.format(port=self.port, device=self.device_port)
        self.config.write_text(config.replace('law = "estimator"\n', f'law = "none"\ncalibration = "{file.name}"\n'))
        self.assertRegex(self.check().stderr, r"correction\.law: .*a calibration needs .estimator., or no \[\[sensor\]\]")

    def test_a_sensor_that_begins_late_says_nothing_of_the_start(self):
        rows = list(csv.reader(self.thermal_test("whole.csv").read_text().splitlines()))
        late = rows[0].index("measured.sleeve_outer_degC")
        for row in rows[1:]:
            if float(row[0]) < 3600:
                row[late] = ""
        log = self.folder / "late.csv"
        log.write_text("\n".join(",".join(row) for row in rows) + "\n")
        made = self.tool("calibrate", self.rom, log, "--json")
        self.assertEqual((made.returncode, json.loads(made.stdout)["fits"]), (0, True), made.stderr)

    def test_a_probe_that_comes_for_the_last_quarter_is_judged_without_its_zero(self):
        rows = list(csv.reader(self.thermal_test("whole.csv").read_text().splitlines()))
        for row in rows[1:]:
            if float(row[0]) < 5700:
                row[-1] = ""
        log = self.folder / "late.csv"
        log.write_text("\n".join(",".join(row) for row in rows) + "\n")
        made = self.tool("calibrate", self.rom, log, "--json")
        self.assertEqual((made.returncode, json.loads(made.stdout)["misfits"]), (0, []), made.stderr)

    def test_a_probe_that_slips_is_named_and_nothing_is_written_without_a_persons_word(self):
        log = self.thermal_test("slipped.csv", lambda time_s, nose_um: nose_um + (25.0 if time_s > 6000 else 0.0))
        file = self.folder / "slipped.calibration"
        refused = self.tool("calibrate", self.rom, log, "-o", file)
        self.assertEqual(refused.returncode, 3)
        self.assertRegex(refused.stdout, r"nose, held out: \d+\.\d\d um rms, at most 2\.00 um")
        self.assertIn("nothing is written", refused.stderr)
        self.assertFalse(file.exists())
        self.assertEqual(self.tool("calibrate", self.rom, log, "-o", file, "--accept").returncode, 0)
        self.configure(f'calibration = "{file.name}"\n')
        self.assertIn("although it missed its limits", self.check().stdout)

    def test_a_heat_that_no_source_explains_is_asked_for_before_the_last_quarter_and_tried_on_it(self):
        log = self.thermal_test("untold.csv", drives=RUNS_WHILE_TOLD_TO_STAND)
        refused = self.tool("calibrate", self.rom, log, "-o", self.folder / "untold.calibration", "--json")
        self.assertEqual(refused.returncode, 3, refused.stderr)
        said = json.loads(refused.stdout)
        heat = said["held_out_heat"]
        for part in ("before", "last_quarter"):
            self.assertGreater(heat[f"{part}_W"], 3 * heat[f"{part}_deviation_W"])
        self.assertIn(f"held out: before the last quarter readings ask for {heat['before_W']:.3g} W +- "
                      f"{heat['before_deviation_W']:.2g} W in {heat['group']} that no source explains, in it for "
                      f"{heat['last_quarter_W']:.3g} W +- {heat['last_quarter_deviation_W']:.2g} W", said["misfits"])
        self.assertIn(heat["group"], {asked["group"] for asked in said["asked_heats"]})
        for channel in said["held_out"]:
            unit = "um" if channel["name"] == "nose" else "K"
            self.assertGreater(channel[f"mean_{unit}"], 3 * channel[f"mean_deviation_{unit}"], channel["name"])

    def test_what_is_no_calibration_of_this_spindle_ends_in_one_line_that_names_it(self):
        file, _ = self.calibrated()
        damaged = self.folder / "damaged.calibration"
        bytes_of = bytearray(file.read_bytes())
        bytes_of[len(bytes_of) // 2] ^= 1
        damaged.write_bytes(bytes_of)
        for text, message in (
                ('calibration = "damaged.calibration"\n', "no calibration of this version, or damaged"),
                ('calibration = "nowhere.calibration"\n', "nowhere.calibration"),
                ('calibration = "machine.calibration"\n[correction.prior]\ncontact = 0\n',
                 '"contact rotor_bearing"')):
            self.configure(text)
            result = self.check()
            self.assertEqual(result.returncode, 1, text)
            self.assertIn(message, result.stderr)
            self.assertEqual(len(result.stderr.splitlines()), 1)

    def test_where_signatures_are_required_a_calibration_needs_one_too(self):
        file, _ = self.calibrated()
        for key in ("ours", "theirs"):
            self.assertEqual(self.tool("keys", "new", self.folder / key).returncode, 0)
        network = self.rom.read_bytes()
        self.addCleanup(self.rom.write_bytes, network)
        sign = lambda what, key: self.assertEqual(self.tool("sign", what, "--key", self.folder / f"{key}.key").returncode, 0)
        sign(self.rom, "ours")
        self.configure(f'calibration = "{file.name}"\n')
        text = self.config.read_text()
        line = next(line for line in text.splitlines() if line.startswith("network = "))
        self.config.write_text(text.replace(line, f'network = {{ file = "{self.rom.name}", allow_uncertified = true, '
                                                  'require_signature = true, trusted_keys = ["ours.pub"] }'))
        refused = self.check()
        self.assertEqual(refused.returncode, 1)
        self.assertIn("correction.calibration: ", refused.stderr)
        self.assertIn("machine.calibration is not signed, and require_signature asks for it", refused.stderr)
        sign(file, "theirs")
        self.assertIn("which is not among the trusted_keys", self.check().stderr)
        sign(file, "ours")
        accepted = self.check()
        self.assertEqual(accepted.returncode, 0, accepted.stderr)
        verified = self.tool("verify-signature", file, "--key", self.folder / "ours.pub")
        self.assertEqual((verified.returncode, verified.stderr), (0, ""))

    def test_a_daemons_history_with_touch_offs_is_a_test_too(self):
        self.config.write_text(self.config.read_text().replace("clock_rate = 10.0", "clock_rate = 100.0"))
        for file in self.folder.glob("history*"):
            file.unlink()
        self.start_again()
        self.write_signals()
        self.wait_for_state(1)
        for touched in range(6):
            nose_um = float32(*self.read(20, 2))
            words = struct.unpack(">4H", struct.pack(">2f", nose_um, 1.0))
            self.assertFalse(self.client.write_registers(1010, [*words, 0, 1], slave=1).isError())
            wait_until(lambda: self.read(926, 1)[0] > touched, "the touch-off to be taken in")
            time.sleep(1.0)  # 100 s of the machine; closer ones count as one
        self.daemon.send_signal(signal.SIGTERM)
        self.daemon.wait(20)
        made = self.tool("calibrate", self.rom, self.folder / "history.csv", "--json")
        self.assertIn(made.returncode, (0, 3), made.stderr)  # the device's constant temperatures are no spindle's
        readings = {channel["name"]: channel["readings"] for channel in json.loads(made.stdout)["channels"]}
        self.assertEqual(set(readings), {*SENSORS, "nose"})
        self.assertGreaterEqual(readings["nose"], 5)
        self.break_wire(self.folder / "history.csv", "sleeve_inner")
        broken = self.tool("calibrate", self.rom, self.folder / "history.csv", "--json")
        self.assertRegex(broken.stderr, r"history\.csv: \d+ readings of sleeve_inner are left out, which the daemon did not believe")
        said = json.loads(broken.stdout)
        self.assertEqual([each["sensor"] for each in said["left_out"]], ["sleeve_inner"])
        self.assertGreater(said["left_out"][0]["readings"], 10)
        fewer = {channel["name"]: channel for channel in said["channels"]}
        self.assertLess(fewer["sleeve_inner"]["readings"], fewer["sleeve_outer"]["readings"])
        self.assertLess(fewer["sleeve_inner"]["rms_K"], 50)  # of 850 degC

    def break_wire(self, history, sensor):
        """In the second half of it, as the daemon writes it then; before, and of the others, all is believed."""
        rows = list(csv.DictReader(history.read_text().splitlines()))
        for row in rows:
            row.update({f"sensor_state.{each}": "0" for each in SENSORS})
        for row in rows[len(rows) // 2:]:
            row[f"measured.{sensor}_degC"] = row[f"raw.{sensor}_degC"] = "850"
            row[f"sensor_state.{sensor}"] = "2"
        with history.open("w", newline="") as file:
            table = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            table.writeheader()
            table.writerows(rows)

    def test_a_test_counts_once_and_is_long_enough_to_be_judged(self):
        log = self.thermal_test("test.csv")
        copy = self.folder / "copy.csv"
        copy.write_text(log.read_text())
        twice = self.tool("calibrate", self.rom, log, copy)
        self.assertEqual(twice.returncode, 1)
        self.assertRegex(twice.stderr, r"^spindle-twin: \S+copy\.csv: logs: holds the readings of \S+test\.csv: .*\n$")
        short = self.folder / "short.csv"
        short.write_text("".join(line for line in log.read_text().splitlines(True)
                                 if not line[0].isdigit() or float(line.split(",")[0]) <= 600))
        made = self.tool("calibrate", self.rom, short, "-o", self.folder / "short.calibration")
        self.assertEqual(made.returncode, 3)
        self.assertIn("10 min of test are too short to be judged, at least 20", made.stdout)

    def test_bad_logs_end_in_one_line(self):
        log = self.folder / "bad.csv"
        for text, message in (("time_s,speed_rpm,load,ambient_degC\n0,0,0,20\n10,0,0,20\n20,0,0,20\n", "key point"),
                              ("time_s,speed_rpm,load,measured.sauna_degC\n0,0,0,20\n", "measured.sauna_degC"),
                              ("time_s,speed_rpm,load,measured.sleeve_inner_degC\n0,0,0,20\n", "3 rows")):
            log.write_text(text)
            result = self.tool("calibrate", self.rom, log, "-o", self.folder / "none.calibration")
            self.assertEqual(result.returncode, 1, result.stdout)
            self.assertIn(message, result.stderr)
            self.assertEqual(len(result.stderr.splitlines()), 1)
        self.assertFalse((self.folder / "none.calibration").exists())


if __name__ == "__main__":
    PROGRAMS["tool"] = os.path.abspath(sys.argv.pop(3))
    main()
