"""The daemon under a service manager: when it is ready, who feeds the watchdog, what the journal gets, how it ends.

service_test.py DAEMON MAKE_SMALL_NETWORK [unittest options]
"""
import os
import pathlib
import re
import resource
import shutil
import signal
import socket
import subprocess
import time
import unittest

from ports import can_connect, free_port, wait_until
from running_daemon import PROGRAMS, RunningDaemon, main

UNIT = pathlib.Path(__file__).parents[2] / "firmware" / "service" / "spindle-twind.service"


class Notified(RunningDaemon):
    """Listens where the service manager would."""

    def setUp(self):
        self.manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.manager.close)
        self.told = []
        super().setUp()
        self.daemon.terminate()
        self.daemon.wait(20)
        (self.folder / "twin.checkpoint").unlink(missing_ok=True)  # or it would predict from the first cycle on

    def start_watched(self, watchdog_s=2.0):
        path = self.folder / "notify"
        self.manager.bind(str(path))
        self.manager.settimeout(0.1)
        environment = {**os.environ, "NOTIFY_SOCKET": str(path),
                       "WATCHDOG_USEC": str(int(1e6 * watchdog_s))}
        self.daemon = self.start([PROGRAMS["daemon"], self.config], stderr=self.log, env=environment)

    def listen(self, for_s):
        end = time.monotonic() + for_s
        while time.monotonic() < end:
            try:
                self.told.append((time.monotonic(), self.manager.recv(4096).decode()))
            except TimeoutError:
                pass
        return [text for _, text in self.told]

    def heard(self, text):
        return any(text in each for each in self.listen(0.2))

    def test_it_is_ready_with_the_first_prediction_and_cycles_feed_the_watchdog(self):
        self.start_watched()
        wait_until(lambda: self.heard("READY=1"), "READY")
        self.assertTrue(any("STATUS=predicts" in text for _, text in self.told))
        self.told.clear()
        self.listen(2.0)
        self.assertTrue([text for _, text in self.told if text == "WATCHDOG=1"])
        self.daemon.send_signal(signal.SIGTERM)
        wait_until(lambda: self.heard("STOPPING=1"), "STOPPING")
        self.assertEqual(self.daemon.wait(20), 0)

    def test_without_a_reading_it_is_not_ready_but_extends_the_start(self):
        self.config.write_text(self.config.read_text().replace(f"port = {self.device_port}", f"port = {free_port()}"))
        self.start_watched()
        wait_until(lambda: self.heard("EXTEND_TIMEOUT_USEC="), "more time to start")
        self.assertFalse(any("READY=1" in text for _, text in self.told))

    def test_a_frozen_process_feeds_no_watchdog(self):
        self.start_watched()
        wait_until(lambda: self.heard("WATCHDOG=1"), "the watchdog is fed")
        self.daemon.send_signal(signal.SIGSTOP)
        self.addCleanup(self.daemon.send_signal, signal.SIGCONT)
        self.listen(0.5)
        self.told.clear()
        self.assertEqual(self.listen(2.0), [])


    def locked_kB(self, limit):
        def set_limit():
            resource.setrlimit(resource.RLIMIT_MEMLOCK, (limit, limit))
        try:
            self.daemon = self.start([PROGRAMS["daemon"], self.config], stderr=self.log, preexec_fn=set_limit)
        except subprocess.SubprocessError:
            self.skipTest("the limit of locked memory may not be raised here")
        wait_until(lambda: can_connect(self.port), "the daemon's port")
        status = pathlib.Path(f"/proc/{self.daemon.pid}/status").read_text()
        return int(re.search(r"^VmLck:\s+(\d+) kB", status, re.MULTILINE)[1])

    def test_memory_is_locked_where_the_limit_is_infinite(self):
        self.assertGreater(self.locked_kB(resource.RLIM_INFINITY), 1000)
        self.assert_logged("memory locked")

    def test_memory_is_left_alone_under_a_limit(self):
        self.assertEqual(self.locked_kB(8 << 20), 0)
        self.assertNotIn("memory", self.log_text())


class Unit(unittest.TestCase):
    @unittest.skipUnless(shutil.which("systemd-analyze"), "systemd is not installed")
    def test_exposure_is_at_most_two(self):
        done = subprocess.run(["systemd-analyze", "security", "--offline=yes", "--threshold=20", "--no-pager", str(UNIT)],
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout[-300:] + done.stderr)
        print(done.stdout.strip().splitlines()[-1])


if __name__ == "__main__":
    main()
