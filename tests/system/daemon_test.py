"""The daemon as its users meet it: started with a configuration, read by two independent Modbus clients, stopped.

daemon_test.py DAEMON MAKE_SMALL_NETWORK [unittest options]
"""
import pathlib
import re
import signal
import socket
import statistics
import struct
import subprocess
import tempfile
import threading
import time
import unittest

from ports import can_connect, free_port, wait_until
from running_daemon import CONFIG, PROGRAMS, RunningDaemon, float32, int16, main, run_daemon

SLOWEST_ANSWER_S = 0.5  # beside a client that sends one byte a second: who waited for it would take longer


class Running(RunningDaemon):
    def mbpoll(self, *arguments):
        command = ["mbpoll", "-m", "tcp", "-1", "-0", "-q", "-p", str(self.port), *map(str, arguments)]
        result = subprocess.run(command, capture_output=True, text=True, timeout=20)
        values = {int(at): float(value) for at, value in re.findall(r"^\[(\d+)\]:\s+(\S+)", result.stdout, re.MULTILINE)}
        return result.returncode, values, result.stdout

    def test_mbpoll_and_pymodbus_read_the_same_values(self):
        code, words, output = self.mbpoll("-r", 0, "-c", 2, "-t", "3", "127.0.0.1")
        self.assertEqual(code, 0, output)
        self.assertEqual([int(words[0]), int(words[1]) & 0xFFFF], self.read(0, 2))
        self.assertEqual(self.read(0, 2), [0x1234, 65536 - 125])
        for table, holding in (("3", False), ("4", True)):
            code, abcd, output = self.mbpoll("-r", 2, "-c", 1, "-t", f"{table}:float", "-B", "127.0.0.1")
            self.assertEqual((code, abcd[2]), (0, -12.5), output)
            code, cdab, output = self.mbpoll("-r", 4, "-c", 1, "-t", f"{table}:float", "127.0.0.1")
            self.assertEqual((code, cdab[4]), (0, -12.5), output)
            self.assertEqual(float32(*self.read(2, 2, holding)), -12.5)

    def test_measured_temperatures_agree_between_device_both_clients_and_both_tables(self):
        self.write_signals()
        self.wait_for_state(1)
        measured = [28.5, 28.25, 28.0]
        self.assertEqual([int16(word) / 100 for word in self.read(40, 3)], measured)
        self.assertEqual([int16(word) / 100 for word in self.read(40, 3, holding=True)], measured)
        words = self.read(202, 6)
        self.assertEqual([float32(*words[at:at + 2]) for at in (0, 2, 4)], measured)
        code, values, output = self.mbpoll("-r", 202, "-c", 3, "-t", "3:float", "-B", "127.0.0.1")
        self.assertEqual((code, list(values.values())), (0, measured), output)
        self.assertEqual(self.read(36, 2), [2150, 2200])
        self.assertEqual(self.read(43, 13), [0x8000] * 13)

    def test_plc_signals_drive_the_prediction_and_tare_zeroes_the_nose(self):
        self.wait_for_state(2)
        self.write_signals()
        self.wait_for_state(1)
        self.assertEqual(self.read(34, 2), [6000, 1000])
        before = self.read(7, 1)[0]
        wait_until(lambda: self.read(7, 1)[0] != before, "a heartbeat")
        block = self.read(0, 124)
        self.assertGreater(int16(block[15]), 10)  # the sensors are warmer than the reference temperature
        nose_um = float32(*block[20:22])
        self.assertEqual(int16(block[15]), round(nose_um * 10))
        self.assertEqual(block[16], int16(block[15]) + 32768)
        self.assertEqual(block[22:24], [block[21], block[20]])
        self.assertFalse(self.client.write_register(1005, 1, slave=1).isError())
        wait_until(lambda: self.read(28, 1)[0] == 1, "the tare")
        self.assertLess(abs(int16(self.read(15, 1)[0])), 5)
        self.assertEqual(self.read(1005, 1, holding=True), [0])

    def test_both_clients_read_the_deviations_and_what_became_of_each_reading(self):
        self.write_signals()
        self.wait_for_state(1)
        wait_until(lambda: self.read(920, 12)[3] >= 3, "three updates")
        def nose_sd_um():
            return float32(*self.read(122, 2))
        self.assertGreater(nose_sd_um(), 0.0)
        deviations = self.read(700, 100)
        self.assertTrue(all(0 < word < 65535 for word in deviations[2:5]), deviations)
        self.assertEqual(deviations[5:18], [0xFFFF] * 13)
        code, values, output = self.mbpoll("-r", 122, "-c", 1, "-t", "3:float", "-B", "127.0.0.1")
        self.assertEqual(code, 0, output)
        self.assertAlmostEqual(values[122], nose_sd_um(), delta=0.2 * values[122])
        sensors = self.read(800, 114)
        self.assertEqual([int16(word) / 100 for word in sensors[2:5]], [28.5, 28.25, 28.0])
        self.assertTrue(all(word in (1, 2) for word in sensors[82:85]), sensors)
        self.assertEqual(sensors[85], 0xFFFF)
        count, determined = self.read(924, 2)
        self.assertLess(determined, count)

    def test_a_measured_length_reaches_the_estimator(self):
        self.write_signals()
        self.wait_for_state(1)
        nose_um = float32(*self.read(20, 2))
        length = struct.unpack(">HH", struct.pack(">f", nose_um)) + struct.unpack(">HH", struct.pack(">f", 0.5))
        self.assertFalse(self.client.write_registers(1010, [*length, 0, 1], slave=1).isError())
        wait_until(lambda: self.read(926, 2) == [1, 1], "the length to be fused")
        self.assertLess(float32(*self.read(122, 2)), 0.6)
        self.assertEqual(self.read(1015, 1, holding=True), [0])

    def test_writes_outside_the_command_block_are_refused_for_both_clients(self):
        self.assertEqual(self.client.write_register(15, 0, slave=1).exception_code, 2)
        code, _, output = self.mbpoll("-r", 15, "-t", "4", "127.0.0.1", "7")
        self.assertEqual(code, 1, output)

    def latencies_s(self, requests):
        taken = []
        for _ in range(requests):
            start = time.monotonic()
            self.read(0, 124)
            taken.append(time.monotonic() - start)
            time.sleep(0.02)
        return taken

    def test_a_client_that_sends_one_byte_a_second_does_not_delay_another(self):
        alone = self.latencies_s(100)
        stop = threading.Event()
        sent = []

        def drip():
            frame = bytes([0, 1, 0, 0, 0, 6, 1, 4, 0, 0, 0, 1])
            while not stop.is_set():
                with socket.create_connection(("127.0.0.1", self.port)) as slow:
                    for byte in frame:
                        try:
                            slow.send(bytes([byte]))
                        except OSError:
                            break
                        sent.append(byte)
                        if stop.wait(1.0):
                            return

        dripper = threading.Thread(target=drip)
        dripper.start()
        wait_until(lambda: sent, "the first byte")
        beside = self.latencies_s(200)
        stop.set()
        dripper.join()
        print(f"\nread of 124 registers, median/max ms: alone {1e3 * statistics.median(alone):.2f}/{1e3 * max(alone):.2f}, "
              f"beside a slow client {1e3 * statistics.median(beside):.2f}/{1e3 * max(beside):.2f} ({len(sent)} bytes dripped)")
        self.assertGreaterEqual(len(sent), 3)
        self.assertLess(statistics.median(beside) - statistics.median(alone), SLOWEST_ANSWER_S)
        # A machine that is busy with other work may delay any single answer; one of 200 is let pass.
        self.assertLess(sorted(beside)[-2], SLOWEST_ANSWER_S + max(alone))

    def test_sigterm_stops_cleanly_and_the_history_is_whole(self):
        self.write_signals()
        self.wait_for_state(1)
        wait_until(lambda: self.read(9, 1)[0] >= 10, "ten cycles")
        self.daemon.send_signal(signal.SIGTERM)
        self.assertEqual(self.daemon.wait(10), 0)
        self.assertFalse(can_connect(self.port))
        self.log.seek(0)
        self.assertRegex(self.log.read().strip().splitlines()[-1], r"stopped by SIGTERM$")
        rows = (self.folder / "history.csv").read_text().splitlines()
        columns = rows[0].split(",")
        self.assertGreaterEqual(len(rows), 10)
        self.assertTrue(all(row.count(",") + 1 == len(columns) for row in rows))
        self.assertEqual(float(rows[-1].split(",")[columns.index("measured.sleeve_inner_degC")]), 28.5)

    def test_a_checkpoint_survives_a_kill_and_the_next_start_goes_on_from_it(self):
        self.write_signals()
        self.wait_for_state(1)
        self.assertFalse(self.client.write_register(1005, 1, slave=1).isError())
        wait_until(lambda: self.read(28, 1)[0] == 1, "the tare")
        checkpoint = self.folder / "twin.checkpoint"
        first = wait_until(lambda: checkpoint.exists() and checkpoint.stat().st_mtime_ns, "a checkpoint")
        wait_until(lambda: checkpoint.stat().st_mtime_ns > first, "the next checkpoint")
        tare_um = float32(*self.read(26, 2))
        self.assertNotEqual(tare_um, 0.0)
        self.daemon.kill()
        self.daemon.wait()
        self.start_again()
        self.write_signals()
        self.wait_for_state(1)
        self.assertEqual(float32(*self.read(26, 2)), tare_um)
        self.log.seek(0)
        self.assertRegex(self.log.read(), r"twin\.checkpoint: goes on from \d+ s ago, with what the estimator knew")

    def test_a_checkpoint_that_does_not_fit_is_said_and_left_alone(self):
        self.write_signals()
        self.wait_for_state(1)
        self.daemon.send_signal(signal.SIGTERM)
        self.assertEqual(self.daemon.wait(10), 0)
        checkpoint = self.folder / "twin.checkpoint"
        data = bytearray(checkpoint.read_bytes())
        data[-1] ^= 1
        checkpoint.write_bytes(data)
        self.start_again()
        self.wait_for_state(2)
        self.log.seek(0)
        self.assertRegex(self.log.read(), r"twin\.checkpoint: no checkpoint of this version, or damaged; not used, a cold start")

    def test_the_parameters_table_stands_posterior_against_prior(self):
        self.write_signals()
        self.wait_for_state(1)
        table = self.folder / "parameters.csv"
        wait_until(table.exists, "the table of parameters")
        rows = [row.split(",") for row in table.read_text().splitlines()]
        self.assertEqual(rows[0], ["parameter", "value", "deviation", "prior", "prior_deviation", "determined"])
        self.assertIn("heat bearing", [row[0] for row in rows])
        self.assertEqual(len(rows) - 1, self.read(924, 1)[0])
        self.daemon.send_signal(signal.SIGTERM)
        self.assertEqual(self.daemon.wait(10), 0)
        self.log.seek(0)
        self.assertRegex(self.log.read(), r"after \d+ s the sensors determine ")

    def test_a_second_instance_is_one_clear_error(self):
        second = run_daemon(self.config)
        self.assertEqual(second.returncode, 1)
        self.assertEqual(second.stderr,
                         f"spindle-twind: {self.folder}/twin.checkpoint.orders: another spindle-twind already writes this file\n")

    def test_a_busy_port_is_one_clear_error(self):
        other = self.folder / "other.toml"
        text = self.config.read_text().replace("parameters.csv", "others.csv")
        other.write_text(text.replace("history.csv", "other.csv").replace("twin.checkpoint", "other.checkpoint"))
        second = run_daemon(other)
        self.assertEqual(second.returncode, 1)
        self.assertEqual(second.stderr.splitlines()[-1:], [
            f"spindle-twind: serve: cannot listen on 127.0.0.1 port {self.port}: Address already in use"])

    def test_a_device_that_goes_away_shows_in_state_and_quality(self):
        self.write_signals()
        self.wait_for_state(1)
        self.device.kill()
        self.wait_for_state(2)
        wait_until(lambda: self.read(11, 1)[0] & 0x102 == 0x102, "the bits device_offline and sensor_stale")


class BadInput(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.network = self.folder / "small.rom"
        subprocess.run([PROGRAMS["make_network"], self.network], check=True)
        self.config = self.folder / "twin.toml"
        self.good = CONFIG.format(port=free_port(), device=free_port())
        self.config.write_text(self.good)

    def error_of(self, *arguments):
        result = run_daemon(*arguments)
        self.assertNotEqual(result.returncode, 0)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        return result.stderr.strip()

    def test_check_accepts_a_good_configuration(self):
        result = run_daemon("--check", self.config)
        first, second = result.stdout.splitlines()
        self.assertEqual((result.returncode, first), (0, f"{self.config}: ok, small with 5 nodes, certified, not signed"))
        self.assertRegex(second, r"^expected after an hour at 6000 rpm from a cold start: nose \d+\.\d um, standard deviation "
                                 r"\d+\.\d um without sensors, \d+\.\d um with 3; the sensors determine \d+ of 12 parameters "
                                 r"\(.*\) and say nothing of the others \(.*\)$")
        self.config.write_text(self.good.replace('"estimator"', '"paper"'))
        result = run_daemon("--check", self.config)
        self.assertEqual((result.returncode, len(result.stdout.splitlines())), (0, 1))

    def test_check_warns_of_a_constant_in_another_unit_and_refuses_it_when_strict(self):
        signals = [line for line in self.good.splitlines() if line.startswith("coolant = ")]
        self.assertEqual(len(signals), 1, self.good)
        self.config.write_text(self.good.replace(signals[0], 'coolant = { source = "constant", value = 295.0 }'))
        line = 1 + self.good.splitlines().index(signals[0])
        said = f"{self.config}:{line}: signals.coolant: 295 is not plausible; believed is "
        result = run_daemon("--check", self.config)
        self.assertEqual(result.returncode, 0)
        self.assertIn("warning: " + said, result.stderr)
        self.assertIn("spindle-twind: " + said, self.error_of("--check", "--strict", self.config))
        self.config.write_text(self.good)
        self.assertEqual(run_daemon("--check", "--strict", self.config).stderr, "")

    def test_a_missing_configuration(self):
        self.assertEqual(self.error_of(self.folder / "none.toml"),
                         f"spindle-twind: {self.folder}/none.toml: cannot be read as a file")

    def test_a_wrong_value_names_file_line_and_field(self):
        self.config.write_text(self.good.replace("clock_rate = 10.0", "clock_rate = 0"))
        line = 1 + self.good.splitlines().index("clock_rate = 10.0")
        for arguments in ([self.config], ["--check", self.config]):
            self.assertEqual(self.error_of(*arguments), f"spindle-twind: {self.config}:{line}: cycle.clock_rate: "
                                                        "must be a number from 0.1 to 1000, is 0")

    def test_an_unknown_sensor_lists_the_key_points(self):
        self.config.write_text(self.good.replace("sleeve_middle", "sleeve_center"))
        self.assertIn('the network has no key point "sleeve_center"; it has sleeve_inner, sleeve_middle, sleeve_outer',
                      self.error_of("--check", self.config))

    def test_a_missing_or_broken_network(self):
        data = bytearray(self.network.read_bytes())
        data[len(data) // 2] ^= 1
        self.network.write_bytes(data)
        self.assertIn(f"spindle-twind: {self.network}: ", self.error_of(self.config))
        self.network.unlink()
        self.assertIn(f'{self.config}:2: network: there is no file "{self.network}"', self.error_of(self.config))


if __name__ == "__main__":
    main()
