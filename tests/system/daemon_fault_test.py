"""What a daemon must stand that runs unattended for years: kills, a log that nobody reads, clients that do not go,
orders that come at once, files in its place.

daemon_fault_test.py DAEMON MAKE_SMALL_NETWORK [unittest options]
"""
import os
import pathlib
import resource
import signal
import socket
import struct
import threading
import time

from ports import can_connect, free_port, wait_until
from running_daemon import PROGRAMS, RunningDaemon, float32, main, run_daemon

DONE, UNKNOWN = 2, 5
CORRECTION, TARE, ACKNOWLEDGE = 1004, 1005, 1027
ORDER_ID = 1028
ORDERS_LOST, ORDERS_NOT_KEPT = 16, 32


class Orders(RunningDaemon):
    def setUp(self):
        super().setUp()
        # So rarely that none of these tests sees a second checkpoint.
        self.config.write_text(self.config.read_text().replace("interval_s = 5.0", "interval_s = 86400.0"))
        self.restart(signal.SIGKILL)

    def restart(self, by):
        self.daemon.send_signal(by)
        self.daemon.wait(20)
        self.start_again()

    def order(self, register, code, number):
        self.assertFalse(self.client.write_register(ORDER_ID, number, slave=1).isError())
        self.assertFalse(self.client.write_register(register, code, slave=1).isError())

    def results(self):
        block = self.read(1400, 36)
        return dict(zip(block[4:12], block[20:28]))

    def wait_for_result(self, number, wanted=DONE):
        wait_until(lambda: self.results().get(number) == wanted, f"result {wanted} of order {number}")

    def tare_um(self):
        return float32(*self.read(26, 2))

    def take_tare(self, number=1):
        self.write_signals()
        self.wait_for_state(1)
        self.order(TARE, 1, number)
        self.wait_for_result(number)
        self.assertNotEqual(self.tare_um(), 0.0)
        return self.tare_um()

    def test_a_tare_that_was_acknowledged_outlives_a_kill_right_after_it(self):
        taken_um = self.take_tare()
        self.restart(signal.SIGKILL)
        self.wait_for_state(2)
        self.assertEqual(self.tare_um(), taken_um)
        self.assertEqual(self.read(12, 1)[0] & ORDERS_LOST, 0)

    def test_a_tare_is_older_than_any_age_limit(self):
        taken_um = self.take_tare()
        self.config.write_text(self.config.read_text() + "max_age_h = 0.0\n")
        self.restart(signal.SIGTERM)
        self.wait_for_state(2)
        self.assert_logged("checkpoint.max_age_h")
        self.assertEqual(self.tare_um(), taken_um)

    def test_the_correction_stays_off_over_a_restart_until_it_is_switched_on(self):
        self.write_signals()
        self.wait_for_state(1)
        self.order(CORRECTION, 0, 7)
        self.wait_for_result(7)
        self.assertEqual(self.read(114, 1), [0])
        for by in (signal.SIGKILL, signal.SIGTERM):
            self.restart(by)
            self.write_signals()
            self.wait_for_state(1)
            self.assertEqual(self.read(114, 1), [0])
            self.assertEqual(self.read(CORRECTION, 1, holding=True), [0])
        self.order(CORRECTION, 1, 8)
        self.wait_for_result(8)
        wait_until(lambda: self.read(114, 1) == [1], "the correction")

    def test_orders_of_one_cycle_get_a_result_each(self):
        self.write_signals()
        self.wait_for_state(1)
        for number, code in ((21, 1), (22, 2), (23, 9), (24, 1), (25, 2)):
            self.order(TARE, code, number)
        for number, wanted in ((21, DONE), (22, DONE), (23, UNKNOWN), (24, DONE), (25, DONE)):
            self.wait_for_result(number, wanted)
        self.assertEqual(self.read(28, 1), [4])
        self.assertEqual(self.tare_um(), 0.0)

    def test_a_damaged_orders_file_is_a_fault_until_it_is_acknowledged(self):
        self.take_tare()
        self.daemon.kill()
        self.daemon.wait()
        orders = self.folder / "twin.checkpoint.orders"
        orders.write_bytes(orders.read_bytes()[:-3])
        for _ in range(2):
            self.start_again()
            self.wait_for_state(2)
            self.assertEqual(self.read(12, 1)[0] & ORDERS_LOST, ORDERS_LOST)
            self.daemon.kill()
            self.daemon.wait()
        self.assertRegex(self.log_text(), r"error orders \S+: lost, ")
        self.start_again()
        self.order(ACKNOWLEDGE, 1, 31)
        self.wait_for_result(31)
        self.assertEqual(self.read(12, 1)[0] & ORDERS_LOST, 0)
        self.restart(signal.SIGKILL)
        self.wait_for_state(2)
        self.assertEqual(self.read(12, 1)[0] & ORDERS_LOST, 0)

    def test_an_order_that_cannot_be_written_is_not_acknowledged(self):
        self.write_signals()
        self.wait_for_state(1)
        orders = self.folder / "twin.checkpoint.orders"
        orders.unlink(missing_ok=True)
        orders.mkdir()
        self.order(TARE, 1, 41)
        self.wait_for_result(41, 3)
        wait_until(lambda: self.read(12, 1)[0] & ORDERS_NOT_KEPT, "the fault")
        orders.rmdir()
        self.wait_for_result(41)
        wait_until(lambda: self.read(12, 1)[0] == 0, "the fault to clear")


class Faults(RunningDaemon):
    def test_hangup_and_user_signals_change_nothing_and_quit_keeps_a_checkpoint(self):
        self.write_signals()
        self.wait_for_state(1)
        for each in (signal.SIGHUP, signal.SIGUSR1, signal.SIGUSR2):
            self.daemon.send_signal(each)
        before = self.read(7, 1)[0]
        wait_until(lambda: self.read(7, 1)[0] != before, "a heartbeat")
        self.assertIsNone(self.daemon.poll())
        checkpoint = self.folder / "twin.checkpoint"
        checkpoint.unlink(missing_ok=True)
        self.daemon.send_signal(signal.SIGQUIT)
        self.assertEqual(self.daemon.wait(10), 0)
        self.assertTrue(checkpoint.exists())
        self.assertRegex(self.log_text().splitlines()[-1], "stopped by SIGQUIT$")

    def test_a_second_configuration_that_writes_the_same_files_is_refused_and_an_edited_one_too(self):
        other = self.folder / "other.toml"
        other.write_text(self.config.read_text().replace(f"port = {self.port}", f"port = {free_port()}"))
        edited = self.folder / "edited.toml"
        edited.write_text(other.read_text())
        os.replace(edited, self.config)
        for config in (other, self.config):
            second = run_daemon(config)
            self.assertEqual(second.returncode, 1)
            self.assertIn("another spindle-twind already writes this file", second.stderr)

    def test_what_killed_checkpoints_left_is_removed(self):
        self.daemon.kill()
        self.daemon.wait()
        left = [self.folder / f"twin.checkpoint.unfinished-{name}" for name in ("aB3dE6", "xzbwtu")]
        for path in left:
            path.write_text("half")
        self.start_again()
        self.assertEqual([path for path in left if path.exists()], [])

    def test_a_pipe_in_the_place_of_the_checkpoint_is_one_clear_error(self):
        self.daemon.send_signal(signal.SIGTERM)
        self.daemon.wait(10)
        checkpoint = self.folder / "twin.checkpoint"
        checkpoint.unlink(missing_ok=True)
        os.mkfifo(checkpoint)
        refused = run_daemon(self.config)
        self.assertEqual(refused.returncode, 1)
        line = 1 + self.config.read_text().splitlines().index('path = "twin.checkpoint"')
        self.assertEqual(refused.stderr, f"spindle-twind: {self.config}:{line}: checkpoint.path: \"{checkpoint}\" "
                                         "exists and is not a regular file\n")

    def test_idle_clients_of_one_host_do_not_lock_another_out(self):
        idle = [socket.create_connection(("127.0.0.1", self.port)) for _ in range(40)]
        self.addCleanup(lambda: [client.close() for client in idle])
        time.sleep(0.5)
        for _ in range(3):
            self.assertEqual(self.read(0, 1), [0x1234])
            with socket.create_connection(("127.0.0.1", self.port), source_address=("127.0.0.2", 0)) as other:
                other.settimeout(10)
                other.sendall(bytes([0, 1, 0, 0, 0, 6, 1, 4, 0, 0, 0, 1]))
                self.assertEqual(other.recv(64)[-2:], b"\x12\x34")

    def test_without_descriptors_accepting_pauses_instead_of_spinning(self):
        if b"__ubsan_" in pathlib.Path(PROGRAMS["daemon"]).read_bytes():
            self.skipTest("the undefined-behaviour sanitizer opens a pipe to look at an object and takes the want of "
                          "a descriptor for a broken one; the release build runs this")
        limit = len(os.listdir(f"/proc/{self.daemon.pid}/fd")) + 12
        resource.prlimit(self.daemon.pid, resource.RLIMIT_NOFILE, (limit, limit))
        clients = [socket.create_connection(("127.0.0.1", self.port)) for _ in range(12)]
        self.addCleanup(lambda: [client.close() for client in clients])

        def cpu_s():
            with open(f"/proc/{self.daemon.pid}/stat") as stat:
                fields = stat.read().rsplit(")", 1)[1].split()
            return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

        before = cpu_s()
        time.sleep(2.0)
        self.assertLess(cpu_s() - before, 0.3)
        self.assertEqual(self.read(0, 1), [0x1234])
        self.write_signals()
        self.client.write_register(ORDER_ID, 9, slave=1)
        self.client.write_register(TARE, 1, slave=1)
        wait_until(lambda: self.read(1404, 1) == [9] and self.read(1420, 1) == [DONE], "a tare on the disk all the same")
        self.assert_logged("kept for orders and checkpoint")
        for client in clients:
            client.close()
        with socket.create_connection(("127.0.0.1", self.port)) as late:
            late.settimeout(10)
            late.sendall(bytes([0, 1, 0, 0, 0, 6, 1, 4, 0, 0, 0, 1]))
            self.assertEqual(late.recv(64)[-2:], b"\x12\x34")


class WrongDevice(RunningDaemon):
    """In the place of the device one that answers something else."""

    def serve(self, change):
        self.device.kill()
        self.device.wait()

        def listen():
            try:
                return socket.create_server(("127.0.0.1", self.device_port))
            except OSError:
                return None

        listener = wait_until(listen, "the device's port")
        self.addCleanup(listener.close)

        def answer():
            while True:
                try:
                    client, _ = listener.accept()
                except OSError:
                    return
                with client:
                    while len(request := client.recv(12)) == 12:
                        data = struct.pack(">4f", 60.0, 60.0, 60.0, 60.0)[:2 * request[11]]
                        client.sendall(change(bytearray(request[:5] + bytes([3 + len(data)]) + request[6:8] +
                                                        bytes([len(data)]) + data)))

        threading.Thread(target=answer, daemon=True).start()

    def test_answers_of_another_unit_protocol_or_length_are_not_taken(self):
        def other(at, value):
            def change(frame):
                frame[at] = value
                return frame
            return change

        self.write_signals()
        self.wait_for_state(1)
        self.serve(other(6, 9))
        wait_until(lambda: self.read(11, 1)[0] & 0x100, "the bit device_offline")
        end = time.monotonic() + 3.0
        while time.monotonic() < end:
            self.assertTrue(self.read(11, 1)[0] & 0x100)
            self.assertEqual(self.read(40, 1), [2850])
        self.assert_logged("its answer is of another request, unit, protocol or length")


class Log(RunningDaemon):
    def start_with_pipe(self):
        self.daemon.send_signal(signal.SIGTERM)
        self.daemon.wait(10)
        self.client.close()
        allow = self.config.read_text().replace("[device]", 'allow = ["127.0.0.1"]\n[device]', 1)
        self.config.write_text(allow.replace("\n", '\nlog_level = "debug"\n', 1))
        reading, writing = os.pipe()
        self.daemon = self.start([PROGRAMS["daemon"], self.config], stderr=writing)
        os.close(writing)
        wait_until(lambda: can_connect(self.port), "the daemon's port")
        self.assertTrue(self.client.connect())
        return reading

    def knock(self, times):
        """Clients that are refused, each of them worth a line."""
        for _ in range(times):
            stranger = socket.socket()
            stranger.settimeout(5)
            stranger.bind(("127.0.0.3", 0))
            try:
                stranger.connect(("127.0.0.1", self.port))
                stranger.recv(1)
            except OSError:
                pass
            stranger.close()

    def test_a_log_that_nobody_reads_holds_nobody_up_and_the_daemon_stops_in_time(self):
        reading = self.start_with_pipe()
        self.addCleanup(os.close, reading)
        self.knock(1200)
        self.assertEqual(self.read(0, 1), [0x1234])
        self.daemon.send_signal(signal.SIGTERM)
        self.assertEqual(self.daemon.wait(10), 0)

    def test_a_log_whose_reader_has_gone_does_not_end_the_daemon(self):
        os.close(self.start_with_pipe())
        self.knock(3)
        self.write_signals()
        self.wait_for_state(1)
        self.assertEqual(self.read(0, 1), [0x1234])
        self.daemon.send_signal(signal.SIGTERM)
        self.assertEqual(self.daemon.wait(10), 0)




if __name__ == "__main__":
    main()
