"""What the daemon publishes to a plant: a real mosquitto between, all messages decoded by a library that knows nothing of
us (npm's sparkplug-payload).

plant_test.py DAEMON MAKE_SMALL_NETWORK [unittest options]
"""
import pathlib
import signal
import socket
import subprocess
import sys
import time
import urllib.request

from plant_host import Broker, Host
from ports import can_connect, free_port, wait_until
from running_daemon import RunningDaemon, main, run_daemon

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "host_tools" / "fleet"))
from sparkplug import Payload, signed  # noqa: E402

PLANT = """
[plant]
host = "127.0.0.1"
port = {port}
group = "hall 3"
node = "mill_7"
period_s = {period_s}
queue = {queue}
"""
TLS = """[plant.tls]
ca = "ca.pem"
certificate = "{name}.pem"
key = "{name}.key"
"""
GOOD, STALE, BAD = 192, 500, 0
REBIRTH = bytes.fromhex("1218" "0a14" + "Node Control/Rebirth".encode().hex() + "7001")  # metrics, name, boolean_value


class Plant(RunningDaemon):
    period_s, queue, tls_name = 0.2, 360, None
    broker_lines = "allow_anonymous true"
    host_tls = None

    def setUp(self):
        super().setUp()
        self.broker_port, self.http_port = free_port(), free_port()
        self.prepare_plant()
        self.broker = Broker(self, self.folder, self.broker_port, self.broker_lines.format(folder=self.folder))
        self.host = Host(self.broker_port, self.host_tls and {key: str(self.folder / name)
                                                              for key, name in self.host_tls.items()})
        self.addCleanup(self.host.close)
        text = self.config.read_text() + f"[http]\nport = {self.http_port}\n" + PLANT.format(
            port=self.broker_port, period_s=self.period_s, queue=self.queue)
        self.config.write_text(text + (TLS.format(name=self.tls_name) if self.tls_name else ""))
        self.daemon.terminate()
        self.daemon.wait(20)
        self.start_again()
        self.write_signals()
        self.wait_for_state(1)

    def prepare_plant(self):
        pass

    def start_again(self):
        super().start_again()
        wait_until(lambda: can_connect(self.http_port), "the HTTP port")

    def with_plant(self, text):
        self.daemon.terminate()
        self.daemon.wait(20)
        self.config.write_text(text)
        self.start_again()

    def count(self, name):
        with urllib.request.urlopen(f"http://127.0.0.1:{self.http_port}/metrics", timeout=20) as reply:
            for line in reply.read().decode().splitlines():
                if line.startswith(f"spindle_twin_plant_{name} "):
                    return float(line.split()[-1])
        raise AssertionError(f"no count {name}")

    def names(self, birth):
        return {metric["alias"]: metric["name"] for metric in birth.metrics if "alias" in metric}

    def assert_in_sequence(self, messages):
        """Since each birth of the node numbers go up by one and wrap."""
        expected = None
        for message in messages:
            if message.kind == "NDEATH":
                expected = None
                continue
            if message.kind == "NBIRTH":
                expected = 0
            if expected is None:
                continue
            self.assertEqual(message.seq, expected, message)
            expected = (expected + 1) % 256


class Messages(Plant):
    def test_birth_data_and_rebirth_are_read_by_an_independent_library(self):
        self.host.wait_for("DDATA", 3)
        self.assertEqual([message.kind for message in self.host.messages()[:3]], ["NBIRTH", "DBIRTH", "DDATA"])
        node_birth, birth = self.host.messages("NBIRTH")[0], self.host.messages("DBIRTH")[0]
        self.assertEqual((node_birth.group, node_birth.node, node_birth.device), ("hall 3", "mill_7", None))
        self.assertEqual((birth.node, birth.device), ("mill_7", "spindle"))
        self.assertEqual(node_birth.named()["bdSeq"]["value"], 0)
        self.assertEqual(node_birth.named()["bdSeq"]["type"], "Int64")
        self.assertIs(node_birth.named()["Node Control/Rebirth"]["value"], False)
        born = birth.named()
        self.assertEqual(born["Properties/spindle"]["value"], "small")
        self.assertEqual(born["nose"]["properties"]["engUnit"]["value"], "um")
        self.assertEqual(born["nose"]["type"], "Float")
        for name, metric in born.items():
            self.assertIn("timestamp", metric, name)
            quality = metric.get("properties", {}).get("Quality", {}).get("value", GOOD)
            self.assertEqual(quality == BAD, metric["value"] is None, f"{name}: {metric}")
        for message in self.host.messages():
            self.assertEqual((message.qos, message.retained), (0, False))

        names = self.names(birth)
        data = self.host.messages("DDATA")[-1]
        read = {names[metric["alias"]]: metric["value"] for metric in data.metrics}
        self.assertEqual(set(read), set(names.values()))
        self.assertLess(abs(time.time() * 1000 - data.time), 5000)
        self.assertEqual(read["state"], 1)
        self.assertEqual(read["speed"], 6000)
        self.assertAlmostEqual(read["load"], 100.0, places=3)
        self.assertIs(read["fault/orders_lost"], False)
        self.assertIsNone(read["motor_current"])

        self.assertRegex(self.broker.text(), r" 1 spBv1\.0/hall 3/NCMD/mill_7\n", "subscribed with the quality 1")
        self.assertNotIn("refuses", self.log_text())
        before = len(self.host.messages("NBIRTH"))
        self.host.client.publish("spBv1.0/hall 3/NCMD/mill_7", REBIRTH)
        again = self.host.wait_for("NBIRTH", before + 1)[-1]
        self.host.wait_for("DBIRTH", 2)
        self.assertEqual(again.named()["bdSeq"]["value"], 0, "the connection is the same")
        self.host.client.publish("spBv1.0/hall 3/NCMD/mill_7", b"\xff\x00 no payload")
        self.host.wait_for("DDATA", len(self.host.messages("DDATA")) + 60)
        self.assertEqual(len(self.host.messages("NBIRTH")), before + 1)
        self.assert_in_sequence(self.host.messages())
        self.assertGreater(self.count("published_total"), 60)
        self.assertEqual(self.count("dropped_total"), 0)
        self.assertEqual(self.count("connected"), 1)

    def test_the_bridge_of_a_fleet_reads_the_same(self):
        self.host.wait_for("DDATA", 3)
        types = {"Int32": 3, "Int64": 4, "UInt16": 6, "Float": 9, "Boolean": 11, "String": 12}
        kinds = {metric["alias"]: types[metric["type"]] for metric in self.host.messages("DBIRTH")[0].metrics
                 if "alias" in metric}
        for message in self.host.messages():
            read = Payload(message.payload)
            self.assertEqual((read.seq, read.time, len(read.metrics)), (message.seq, message.time, len(message.metrics)))
            for ours, other in zip(read.metrics, message.metrics):
                value = signed(ours.value, kinds.get(ours.alias))
                self.assertEqual((ours.name, ours.alias, value), (other.get("name"), other.get("alias"), other["value"]))
                properties = other.get("properties", {})
                self.assertEqual(ours.unit, properties.get("engUnit", {}).get("value", ""))
                self.assertEqual(ours.quality, properties.get("Quality", {}).get("value"))

    def test_the_broker_says_the_death_of_a_killed_daemon_and_of_one_that_was_stopped(self):
        for number, how in enumerate((signal.SIGKILL, signal.SIGTERM)):
            births = len(self.host.messages("NBIRTH"))
            self.host.wait_for("NBIRTH", births or 1)
            self.daemon.send_signal(how)
            self.daemon.wait(20)
            death = self.host.wait_for("NDEATH", number + 1)[-1]
            self.assertEqual(death.qos, 1)
            self.assertIsNone(death.seq)
            self.assertEqual(death.named()["bdSeq"]["value"],
                             self.host.messages("NBIRTH")[-1].named()["bdSeq"]["value"])
            self.start_again()
            self.host.wait_for("NBIRTH", births + 1)

    def test_a_broker_that_starts_anew_is_found_again_and_nothing_is_lost(self):
        self.host.wait_for("DDATA", 5)
        cycles = lambda: {metric["value"] for message in self.host.messages("DBIRTH", "DDATA")  # noqa: E731
                          for metric in message.metrics if self.alias_of_sequence == metric.get("alias")}
        self.alias_of_sequence = self.host.messages("DBIRTH")[0].named()["sequence"]["alias"]
        self.broker.stop()
        self.assert_logged("plant: connection lost to 127.0.0.1")
        time.sleep(3.0)
        self.host.listening.clear()
        self.broker.start()
        self.assertTrue(self.host.listening.wait(20))
        deadline = time.monotonic() + 60
        self.host.wait_for("NBIRTH", 2)
        self.assertEqual(self.host.messages("NBIRTH")[-1].named()["bdSeq"]["value"] > 0, True)
        wait_until(lambda: self.count("waiting") == 0, "an empty queue")
        self.assertLess(time.monotonic(), deadline)
        self.assertEqual(self.count("dropped_total"), 0)
        wait_until(lambda: any(metric.get("isHistorical") for message in self.host.messages("DDATA")
                               for metric in message.metrics), "what was said while the broker was away")
        published = wait_until(lambda: self.count("waiting") == 0 and self.count("published_total"), "all published")
        wait_until(lambda: len(cycles()) >= published, f"{published} samples (heard: {len(cycles())})", 10)
        self.assertEqual(self.log_text().count("plant: connection lost"), 1)
        self.assertEqual(self.log_text().count("plant: connected"), 2)


class Troubles(Plant):
    def sequence(self):
        return self.read(8, 2)

    def assert_goes_on_and_ends(self):
        """The cycle runs, and the daemon ends, however the broker is."""
        before = self.sequence()
        wait_until(lambda: self.sequence() != before, "another cycle", 10)
        self.daemon.terminate()
        self.assertEqual(self.daemon.wait(10), 0)

    def at(self, port):
        return self.config.read_text().replace(f"port = {self.broker_port}\n", f"port = {port}\n")

    def test_who_asks_for_births_again_and_again_gets_one_a_second(self):
        self.host.wait_for("DDATA", 3)
        end = time.monotonic() + 3.0
        while time.monotonic() < end:
            self.host.client.publish("spBv1.0/hall 3/NCMD/mill_7", REBIRTH)
            time.sleep(0.01)
        self.host.wait_for("NBIRTH", 3)
        time.sleep(1.5)
        self.assertLessEqual(len(self.host.messages("NBIRTH")), 6)
        self.assert_in_sequence(self.host.messages())

    def test_a_broker_that_stands_still_and_goes_on_costs_nothing(self):
        self.host.wait_for("DDATA", 3)
        self.broker.process.send_signal(signal.SIGSTOP)
        wait_until(lambda: self.count("waiting") >= 20, "a queue that grows")
        self.broker.process.send_signal(signal.SIGCONT)
        wait_until(lambda: self.count("waiting") <= 2, "an empty queue")
        self.assertEqual(self.count("dropped_total"), 0)
        self.assertEqual(len(self.host.messages("NBIRTH")), 1)
        self.assert_in_sequence(self.host.messages())

    def test_a_broker_that_takes_connections_and_says_nothing_holds_up_nobody(self):
        with socket.create_server(("127.0.0.1", 0)) as silent:
            self.with_plant(self.at(silent.getsockname()[1]))
            connection, _ = silent.accept()
            with connection:
                self.assertIn(b"MQTT", connection.recv(100))
                self.assert_goes_on_and_ends()

    def test_a_broker_that_answers_with_noise_is_left(self):
        with socket.create_server(("127.0.0.1", 0)) as noisy:
            self.with_plant(self.at(noisy.getsockname()[1]))
            for _ in range(3):
                connection, _ = noisy.accept()
                with connection:
                    connection.recv(1000)
                    connection.sendall(bytes(range(256)) * 4)
            self.assert_goes_on_and_ends()

    def test_a_way_that_swallows_everything_holds_up_nobody(self):
        with socket.socket() as full:
            full.bind(("127.0.0.1", 0))
            full.listen(0)
            clients = [socket.socket() for _ in range(4)]
            for client in clients:  # beyond what the kernel holds for a server that does not accept, it answers nothing
                client.setblocking(False)
                client.connect_ex(full.getsockname())
            self.with_plant(self.at(full.getsockname()[1]))
            wait_until(lambda: self.count("waiting") > 5, "a queue that grows")
            self.assertEqual(self.count("connected"), 0)
            self.assert_goes_on_and_ends()
            for client in clients:
                client.close()


class SmallQueue(Plant):
    period_s, queue = 0.1, 10

    def test_beyond_the_queue_the_oldest_samples_go_and_are_counted(self):
        self.host.wait_for("DDATA", 5)
        before = 0
        for outages in (1, 2):
            self.broker.stop()
            wait_until(lambda: self.count("dropped_total") >= before + 10, "ten dropped samples")
            self.assertEqual(self.count("waiting"), 10)
            self.assertEqual(self.count("connected"), 0)
            self.broker.start()
            wait_until(lambda: self.count("connected") == 1 and self.count("waiting") == 0, "an empty queue")
            dropped = self.count("dropped_total")
            self.assert_logged(f"plant: {dropped - before:.0f} samples were dropped in all")
            self.assertEqual(self.log_text().count("the queue is full"), outages)
            before = dropped

    def test_a_daemon_without_its_broker_runs_and_ends_as_always(self):
        self.broker.stop()
        self.write_signals()
        self.wait_for_state(1)
        self.daemon.terminate()
        self.assertEqual(self.daemon.wait(10), 0)


def make_certificates(folder):
    commands = ["openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 30 -subj /CN=Plant "
                "-keyout ca.key -out ca.pem"]
    for name, more in (("broker", "subjectAltName=IP:127.0.0.1"), ("daemon", "keyUsage=digitalSignature"),
                       ("host", "keyUsage=digitalSignature")):
        commands += [f"openssl req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN={name} -keyout {name}.key "
                     f"-out {name}.csr", f"echo {more} >{name}.ext",
                     f"openssl x509 -req -in {name}.csr -CA ca.pem -CAkey ca.key -days 30 -extfile {name}.ext "
                     f"-out {name}.pem"]
    commands += ["openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 30 -subj /CN=stranger "
                 "-keyout stranger.key -out stranger.pem", "chmod o= *.key"]
    for command in commands:
        subprocess.run(command, shell=True, cwd=folder, check=True, capture_output=True)


class ByTls(Plant):
    tls_name = "daemon"
    broker_lines = ("cafile {folder}/ca.pem\ncertfile {folder}/broker.pem\nkeyfile {folder}/broker.key\n"
                    "require_certificate true\nuse_identity_as_username true")
    host_tls = {"ca_certs": "ca.pem", "certfile": "host.pem", "keyfile": "host.key"}

    def prepare_plant(self):
        make_certificates(self.folder)

    def test_a_certificate_on_both_sides_is_needed(self):
        self.host.wait_for("DDATA", 3)
        births, text = len(self.host.messages("NBIRTH")), self.config.read_text()
        self.with_plant(text.replace("daemon.pem", "stranger.pem").replace("daemon.key", "stranger.key"))
        self.assert_logged("plant: no connection to 127.0.0.1")
        self.with_plant(text[:text.index("[plant.tls]")])
        time.sleep(3.0)
        self.assertEqual(self.count("connected"), 0)
        self.assertEqual(len(self.host.messages("NBIRTH")), births)
        self.with_plant(text)
        self.host.wait_for("NBIRTH", births + 1)

    def test_a_broker_of_another_name_or_authority_is_refused(self):
        self.host.wait_for("DDATA", 1)
        births, text = len(self.host.messages("NBIRTH")), self.config.read_text()
        self.with_plant(text.replace('host = "127.0.0.1"', 'host = "localhost"'))
        self.assert_logged("plant: no connection to localhost")
        self.with_plant(text.replace("ca.pem", "stranger.pem"))
        self.assert_logged("certificate verify failed")
        self.assertEqual(len(self.host.messages("NBIRTH")), births)

    def test_files_that_cannot_be_used_are_found_by_check(self):
        text = self.config.read_text()
        line = 1 + text[:text.index("[plant.tls]")].count("\n")
        (self.folder / "open.toml").write_text(text.replace("daemon.key", "host.key"))
        said = run_daemon("--check", self.folder / "open.toml").stderr
        self.assertIn(f"open.toml:{line + 3}: plant.tls.key: ", said)
        self.assertEqual(run_daemon("--check", self.config).returncode, 0)


if __name__ == "__main__":
    main()
