"""A network is exchanged under a daemon that runs: deployed, refused, tried, accepted, taken back, through kills.

deploy_test.py DAEMON MAKE_SMALL_NETWORK SPINDLE_TWIN [unittest options]
"""
import os
import shutil
import signal
import subprocess
import time

from ports import wait_until
from running_daemon import BEGINNING, PROGRAMS, RunningDaemon, float32, main

CONFIG = BEGINNING.replace('network = "small.rom"', 'network = {{ file = "small.rom", trusted_keys = ["factory.pub"] }}') + """
clock_rate = 50.0
[signals]
# With these what the fake device reads is a steady state of the small network.
speed = {{ source = "constant", value = 1400.0 }}
load = {{ source = "constant", value = 0.0 }}
coolant = {{ source = "constant", value = 27.2 }}
ambient = {{ source = "constant", value = 27.2 }}
[exchange]
slot = "slot"
trial_min = 2.0
watch_min = 3.0
margin_K = {margin_K}
[checkpoint]
path = "twin.checkpoint"
interval_s = 60.0
[health]
enabled = false
"""
STATE, NOSE, EXCHANGE, NETWORK_ID, TARE = 10, 20, 1702, 1704, 26
TRIAL, WATCHING, KEEPING, ACCEPTED, REFUSED = 1, 2, 3, 4, 5
NO_STEP_UM = 0.5  # from cycle to cycle; the nose's tare, if it were lost, would be one of 2.2 um


def twin(*arguments, **options):
    return subprocess.run([PROGRAMS["host_tool"], *map(str, arguments)], capture_output=True, text=True, timeout=60, **options)


class Deploy(RunningDaemon):
    config_text = CONFIG
    margin_K = 2.0

    def start_devices(self):
        self.slot = self.folder / "slot"
        self.slot.mkdir()
        for name in ("factory", "stranger"):
            self.good("keys", "new", self.folder / name)
        self.make("new.rom", 1.01)
        return {"margin_K": self.margin_K, **super().start_devices()}

    def setUp(self):
        super().setUp()
        wait_until(lambda: self.read(STATE, 1)[0] in (1, 2), "a prediction")

    def make(self, name, factor):
        subprocess.run([PROGRAMS["make_network"], self.folder / name, str(factor)], check=True)
        return self.folder / name

    def good(self, *arguments, **options):
        result = twin(*arguments, **options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def deploy(self, name="new.rom", where=None, key="factory.key", **options):
        return self.good("deploy", self.folder / name, where or self.slot, "--key", self.folder / key, **options)

    def nose(self):
        return float32(*self.read(NOSE, 2))

    def exchange(self):
        return self.read(EXCHANGE, 1)[0]

    def network_id(self):
        high, low = self.read(NETWORK_ID, 2)
        return f"{high:04x}{low:04x}"

    def id_of(self, name):
        return (self.folder / name).read_bytes()[20:24].hex()  # of the SHA-256 in the header

    def hash16(self, name):
        return (self.folder / name).read_bytes()[20:28].hex()

    def wait_exchange(self, *states, seconds=60):
        end = time.monotonic() + seconds
        while self.exchange() not in states:
            self.assertLess(time.monotonic(), end, f"exchange {states}: {self.exchange()}\n{self.log_text()}")
            time.sleep(0.02)
        return self.exchange()

    def names(self):
        return sorted(path.name for path in self.slot.iterdir() if not path.name.endswith(".lock"))

    def kill(self):
        self.daemon.send_signal(signal.SIGKILL)
        self.daemon.wait()

    def restart(self):
        self.start_again()
        wait_until(lambda: self.read(STATE, 1)[0] in (1, 2), "a prediction")

    def refused(self, put, word):
        before = len(self.log_text())
        put()
        wait_until(lambda: "refused" in self.log_text()[before:], "the refusal")
        self.assertIn(word, self.log_text()[before:])
        self.assertEqual(self.network_id(), self.id_of("small.rom"))
        self.assertEqual([name for name in self.names() if name.endswith(".rom")], [])

    def test_accepted_without_a_step_and_after_a_restart(self):
        old, new = self.id_of("small.rom"), self.id_of("new.rom")
        self.assertEqual(self.network_id(), old)
        self.assertGreater(self.nose(), 4 * NO_STEP_UM)
        self.assertFalse(self.client.write_register(1005, 1, slave=1).isError())
        wait_until(lambda: abs(self.nose()) < NO_STEP_UM, "the tare, a step of its own")
        self.deploy()
        last = None
        largest = 0.0
        end = time.monotonic() + 60
        while self.exchange() != ACCEPTED:
            self.assertLess(time.monotonic(), end, self.log_text())
            words = self.read(8, NOSE + 2 - 8)  # in one request: both of one cycle
            sequence, nose = words[0] << 16 | words[1], float32(*words[-2:])
            if last and sequence > last[0]:
                largest = max(largest, abs(nose - last[1]) / (sequence - last[0]))
            last = sequence, nose
        self.assertLess(largest, NO_STEP_UM)
        self.assertEqual(self.network_id(), new)
        wait_until(lambda: "new.rom" not in self.names(), "the slot is empty again")
        time.sleep(1.5)  # checkpoint and orders are written at once
        self.kill()
        self.restart()
        self.assertEqual(self.network_id(), new)
        self.assertNotIn("a cold start", self.log_text())
        self.assertNotIn("lost", self.log_text())

    def test_what_must_not_run_is_refused_with_one_reason_and_put_aside(self):
        signed = self.folder / "signed.rom"
        shutil.copy(self.folder / "new.rom", signed)
        self.good("sign", signed, "--key", self.folder / "factory.key")
        whole = signed.read_bytes()
        forged = bytearray(whole)
        forged[-1] ^= 1
        other = self.make("other.rom", -1.0)  # of another spindle
        self.refused(lambda: shutil.copy(self.folder / "new.rom", self.slot / "unsigned.rom"), "not signed")
        self.refused(lambda: (self.slot / "forged.rom").write_bytes(forged), "forged.rom")
        self.refused(lambda: (self.slot / "cut.rom").write_bytes(whole[:-500]), "cut.rom")
        self.refused(lambda: (self.slot / "empty.rom").write_bytes(b""), "empty.rom")
        self.refused(lambda: self.deploy(key="stranger.key"), "not among the trusted_keys")
        self.refused(lambda: self.deploy(other.name), "allowed is what the network that runs has")
        self.assertEqual(self.exchange(), REFUSED)
        self.assertEqual(len(self.names()), 6)
        self.assertIsNone(self.daemon.poll())

    def test_kills_in_each_stage_leave_one_network(self):
        old, new = self.id_of("small.rom"), self.id_of("new.rom")
        self.deploy()
        for state in (TRIAL, WATCHING):
            self.wait_exchange(state)
            self.kill()
            self.restart()
            self.assertEqual(self.network_id(), old, state)
        self.wait_exchange(ACCEPTED)
        self.kill()
        self.restart()
        self.assertEqual(self.network_id(), new)
        # The accepted file is damaged: the configured one runs, and the log says why.
        accepted = next(self.slot.glob("accepted-*.rom"))
        self.kill()
        accepted.write_bytes(accepted.read_bytes()[:-1])
        self.restart()
        self.assertEqual(self.network_id(), old)
        self.assert_logged("now the configured network runs")

    def test_a_kill_between_the_network_and_its_orders_loses_no_order(self):
        self.assertFalse(self.client.write_register(1005, 1, slave=1).isError())
        wait_until(lambda: float32(*self.read(TARE, 2)) != 0.0, "the tare")
        tare = float32(*self.read(TARE, 2))
        wait_until((self.folder / "twin.checkpoint.orders").exists, "the orders")
        self.kill()
        # As the daemon leaves it when it is killed there: the network's file is the new one, nothing else yet.
        self.deploy(where=self.folder / "slot")
        (self.slot / "new.rom").rename(self.slot / f"accepted-{self.hash16('small.rom')}.rom")
        self.restart()
        self.assertEqual(self.network_id(), self.id_of("new.rom"))
        self.assertAlmostEqual(float32(*self.read(TARE, 2)), tare, places=4)
        self.assert_logged("of the network before the exchange")
        self.assertNotIn("lost", self.log_text())

    def test_a_disk_that_takes_no_file_is_waited_for(self):
        blocked = self.slot / f"accepted-{self.hash16('small.rom')}.rom"
        blocked.mkdir()
        self.deploy()
        self.wait_exchange(KEEPING)
        wait_until(lambda: "tried again" in self.log_text(), "the complaint")
        time.sleep(2.5)
        self.assertEqual(self.log_text().count("tried again"), 1)
        self.assertEqual(self.exchange(), KEEPING)
        blocked.rmdir()
        self.wait_exchange(ACCEPTED)
        self.assertTrue(blocked.is_file())

    def test_who_takes_the_file_away_ends_the_trial(self):
        self.deploy()
        self.wait_exchange(TRIAL)
        (self.slot / "new.rom").unlink()
        self.wait_exchange(REFUSED)
        self.assertEqual(self.network_id(), self.id_of("small.rom"))

    def test_who_deploys_another_one_under_the_same_name_gets_that_one(self):
        self.deploy()
        self.wait_exchange(TRIAL)
        self.make("new.rom", 1.02)
        self.deploy()
        self.wait_exchange(ACCEPTED)
        self.assertEqual(self.network_id(), self.id_of("new.rom"))
        wait_until(lambda: len(self.names()) == 1, "nothing but the accepted file")

    def test_deploy_says_what_is_wrong_before_it_sends_anything(self):
        key = ("--key", self.folder / "factory.key")
        for arguments, words in (((self.folder / "new.rom", self.slot), ("new.rom", "signature", "--key")),
                                 ((*key, self.folder / "new.rom", self.folder / "nowhere"), ("nowhere", "folder")),
                                 ((self.folder / "twin.toml", self.slot), ("twin.toml", ".rom")),
                                 ((*key, "--", self.folder / "new.rom", "-oProxyCommand=x:slot"), ("HOST", "allowed")),
                                 ((*key, self.folder / "new.rom", "pc:slot;reboot"), ("DIR", "allowed"))):
            result = twin("deploy", *arguments)
            self.assertEqual(result.returncode, 1, result)
            self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
            for word in words:
                self.assertIn(word, result.stderr)
        self.assertEqual(self.names(), [])

    def test_to_another_computer_by_ssh(self):
        programs = self.folder / "programs"
        programs.mkdir()
        ssh = programs / "ssh"
        environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}"}
        ssh.write_text('#!/bin/sh\n[ "$1" = edge-pc ] || exit 255\nexec sh -c "$2"\n')
        ssh.chmod(0o755)
        self.deploy(where=f"edge-pc:{self.slot}", env=environment)
        self.wait_exchange(TRIAL)
        (self.slot / "new.rom").unlink()
        self.wait_exchange(REFUSED)
        # The connection is cut on the way, and the host is not there: nothing stays.
        for text, host in (('#!/bin/sh\nhead -c 100 | sh -c "$2"\n', "edge-pc"), ("#!/bin/sh\nexit 255\n", "nobody")):
            ssh.write_text(text)
            result = twin("deploy", self.folder / "new.rom", f"{host}:{self.slot}", "--key", self.folder / "factory.key",
                          env=environment)
            self.assertEqual(result.returncode, 1)
            self.assertIn("nothing has changed in the slot", result.stderr)
            self.assertEqual(self.names(), [])


class Worse(Deploy):
    """Half the conductances, and no margin that would let it pass."""
    margin_K = 0.0

    def test_a_network_that_does_worse_in_its_trial_is_refused(self):
        self.make("bad.rom", 0.5)
        self.deploy("bad.rom")
        self.assertEqual(self.wait_exchange(REFUSED, ACCEPTED, seconds=90), REFUSED)
        wait_until(lambda: "bad.rom.refused" in self.names(), "the file is put aside")


class BesideAnother(Deploy):
    """Two spindles of the same network in one daemon; a new one is deployed for the left."""
    config_text = "[serve]\nport = {port}\n" + "".join(
        f'[[spindle]]\nname = "{name}"\nunit = {unit}\nconfig = "{name}/twin.toml"\n'
        for name, unit in (("left", 1), ("right", 2)))

    def start_devices(self):
        places = super().start_devices()
        own = CONFIG.replace("[serve]\nport = {port}\n", "").format(**places)
        for file in ("small.rom", "factory.pub", "slot"):
            own = own.replace(f'"{file}"', f'"../{file}"')
        for name, text in (("left", own), ("right", own[:own.index("[exchange]")] + own[own.index("[checkpoint]"):])):
            (self.folder / name).mkdir()
            (self.folder / name / "twin.toml").write_text(text)
        return {}

    def right(self, first, count):
        reply = self.client.read_input_registers(first, count, slave=2)
        self.assertFalse(reply.isError(), reply)
        return reply.registers

    def test_one_gets_a_new_network_and_the_other_notices_nothing(self):
        wait_until(lambda: self.right(STATE, 1)[0] in (1, 2), "a prediction of the other")
        begin = self.right(8, 2)
        own_id = self.right(NETWORK_ID, 2)
        self.deploy()
        self.wait_exchange(ACCEPTED)
        self.assertEqual(self.network_id(), self.id_of("new.rom"))
        self.assertEqual((self.right(NETWORK_ID, 2), self.right(EXCHANGE, 1)), (own_id, [0]))
        self.assertGreater(self.right(8, 2), begin)
        self.assertIn(self.right(STATE, 1)[0], (1, 2))
        time.sleep(1.5)  # checkpoint and orders are written at once
        self.kill()
        self.restart()
        self.assertEqual(self.network_id(), self.id_of("new.rom"))
        wait_until(lambda: self.right(STATE, 1)[0] in (1, 2), "a prediction of the other")
        self.assertEqual(self.right(NETWORK_ID, 2), own_id)
        self.assertNotIn("lost", self.log_text())


for inherited in [name for name in dir(Deploy) if name.startswith("test_")]:
    for child in (Worse, BesideAnother):
        setattr(child, inherited, None)

if __name__ == "__main__":
    main("host_tool")
