"""Modbus/TCP by TLS: the README's lines for certificates, run as they stand, and all that can be wrong with a client's.

tls_test.py DAEMON MAKE_SMALL_NETWORK [unittest options]
"""
import contextlib
import os
import pathlib
import re
import shutil
import socket
import ssl
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "clients"))

from npm_client import NpmClient  # noqa: E402
from ports import can_connect, free_port, wait_until  # noqa: E402
from promises import Outcome  # noqa: E402
from running_daemon import CONFIG, HERE, RunningDaemon, main, run_daemon  # noqa: E402

README = HERE.parents[1] / "firmware" / "service" / "README.md"
TLS = """
[serve.tls]
port = {tls}
certificate = "daemon.pem"
key = "daemon.key"
clients_ca = "ca.pem"
write_roles = ["operator"]
"""
KNOWN = bytes([0, 1, 0, 0, 0, 6, 1, 4, 0, 0, 0, 1])  # reads register 0
ANSWER = bytes([0, 1, 0, 0, 0, 5, 1, 4, 2, 0x12, 0x34])
AUTHORITY = """
[ca]
default_ca = own
[own]
database = index
serial = serial
new_certs_dir = .
certificate = ca.pem
private_key = ca.key
default_md = sha256
default_days = 365
default_crl_days = 30
policy = any
[any]
commonName = supplied
"""


def recipe():
    """The lines of the README that make certificates."""
    section = README.read_text().split("## Modbus/TCP by TLS\n")[1].split("\n## ")[0]
    return [line.strip() for line in section.splitlines() if re.match(r" {4}openssl (req|x509) ", line)]


def shell(folder, line):
    subprocess.run(["sh", "-euc", line], cwd=folder, check=True, capture_output=True)


def make_certificates(folder):
    for line in recipe():
        shell(folder, line)


class Tls(RunningDaemon):
    config_text = CONFIG + TLS

    def start_devices(self):
        self.tls_port = free_port()
        make_certificates(self.folder)
        return {**super().start_devices(), "tls": self.tls_port}

    def meet_daemon(self):
        super().meet_daemon()
        self.wait_for_tls(1)

    def start_again(self):
        starts = self.log_text().count("Modbus/TCP by TLS on ")
        super().start_again()
        self.wait_for_tls(starts + 1)

    def wait_for_tls(self, starts):
        wait_until(lambda: self.log_text().count("Modbus/TCP by TLS on ") == starts, "the port of TLS")

    def context(self, who="plc"):
        context = ssl.create_default_context(cafile=self.folder / "ca.pem")
        if who:
            context.load_cert_chain(self.folder / f"{who}.pem", self.folder / f"{who}.key")
        return context

    def connect(self, context, source="127.0.0.1", unread_bytes=None):
        """unread_bytes: what the system keeps for a client that does not read; otherwise as much as it likes."""
        plain = socket.socket()
        self.addCleanup(plain.close)
        if unread_bytes:
            plain.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, unread_bytes)
        plain.settimeout(8)
        plain.bind((source, 0))
        plain.connect(("127.0.0.1", self.tls_port))
        client = context.wrap_socket(plain, server_hostname="edge-7")
        self.addCleanup(client.close)
        return client

    def ask(self, client):
        client.sendall(KNOWN)
        return client.recv(300)

    def refused(self, context, reason):
        """The handshake fails, or the first answer does (TLS 1.3); the log says why; others are answered."""
        with self.assertRaises(OSError, msg=reason):
            if self.ask(self.connect(context)) == b"":
                raise ConnectionResetError
        wait_until(lambda: reason in self.log_text(), reason, 10)
        self.assertEqual(self.ask(self.connect(self.context(), "127.0.0.2")), ANSWER)

    def sign(self, name, days=365, authority="ca"):
        shell(self.folder, f"openssl req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN={name} "
                           f"-keyout {name}.key -out {name}.csr && openssl x509 -req -in {name}.csr -CA {authority}.pem "
                           f"-CAkey {authority}.key -days {days} -copy_extensions copy -out {name}.pem")


class Clients(Tls):
    def npm_client(self, who):
        client = NpmClient("jsmodbus", self.tls_port, *(self.folder / file for file in ("ca.pem", f"{who}.pem", f"{who}.key")))
        self.addCleanup(client.close)
        return client

    def test_a_client_with_the_role_reads_and_writes_one_without_reads_only(self):
        plc, viewer = self.npm_client("plc"), self.npm_client("viewer")
        for client in (plc, viewer):
            self.assertEqual(client.ask(1, [4, 0, 0, 0, 1]), Outcome("words", [0x1234]))
        self.assertEqual(plc.ask(1, [6, 1000 >> 8, 1000 & 255, 0x17, 0x70]).kind, "done")
        self.assertEqual(viewer.ask(1, [3, 1000 >> 8, 1000 & 255, 0, 1]), Outcome("words", [6000]))
        self.assertEqual(viewer.ask(1, [6, 1000 >> 8, 1000 & 255, 0, 1]), Outcome("exception", 2))
        # The plain port stays as it was.
        self.assertEqual(self.read(0, 1), [0x1234])
        self.assertFalse(self.client.write_register(1000, 5000, slave=1).isError())
        log = self.log_text()
        self.assertRegex(log, r"by TLS: CN=plc-7, role operator, may write")
        self.assertRegex(log, r"by TLS: CN=viewer, no role, reads only")
        self.assertRegex(log, r"Modbus/TCP by TLS on 127.0.0.1:\d+, certificate valid until ... .. ")

    def test_requests_in_pieces_and_several_at_once_pass_as_on_the_plain_port(self):
        client = self.connect(self.context())
        for byte in KNOWN:
            client.sendall(bytes([byte]))
            time.sleep(0.01)
        self.assertEqual(client.recv(300), ANSWER)
        client.sendall(20 * KNOWN)
        answers = b""
        while len(answers) < 20 * len(ANSWER):
            answers += client.recv(4096)
        self.assertEqual(answers, 20 * ANSWER)
        client.sendall(b"GET / HTTP/1.1\r\n\r\n")  # the gate closes
        self.assertEqual(client.recv(300), b"")

    def test_who_reads_nothing_is_ended_and_others_are_answered_meanwhile(self):
        other = self.connect(self.context(), "127.0.0.2")
        self.assertEqual(self.ask(other), ANSWER)
        open_before = self.sockets()
        deaf = self.connect(self.context(), unread_bytes=65536)
        self.assertGreater(self.sockets(), open_before)
        deaf.settimeout(0.1)
        ask_for_much = bytes([0, 1, 0, 0, 0, 6, 1, 4, 0, 0, 0, 125])
        for _ in range(400):
            with contextlib.suppress(OSError):  # nobody takes it any more, or it is ended
                deaf.sendall(50 * ask_for_much)
            self.assertEqual(self.ask(other), ANSWER)
        # At once where the server could not say more; a client that takes nothing has a second, or ten.
        wait_until(lambda: self.sockets() <= open_before, "the end of who leaves 20,000 answers unread", 30)
        self.assertEqual(self.ask(other), ANSWER)

    def sockets(self):
        """How many the daemon has open."""
        links = pathlib.Path(f"/proc/{self.daemon.pid}/fd").iterdir()
        return sum(os.path.realpath(link).split("/")[-1].startswith("socket:") for link in links)


class Refused(Tls):
    def test_what_is_wrong_with_a_certificate_is_said_and_ends_the_handshake(self):
        self.refused(self.context(None), "peer did not return a certificate")
        shell(self.folder, "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN=own "
                           "-keyout own.key -out own.pem")
        self.refused(self.context("own"), "self-signed certificate")

    def test_a_certificate_of_another_authority_or_another_time_is_refused(self):
        self.sign("late", days=-1)
        self.refused(self.context("late"), "certificate has expired")
        shell(self.folder, "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN=Other "
                           "-keyout other.key -out other.pem")
        self.sign("foreign", authority="other")
        self.refused(self.context("foreign"), "unable to get local issuer certificate")
        (self.folder / "authority.cnf").write_text(AUTHORITY)
        shell(self.folder, "touch index; echo 01 >serial; cp plc.key early.key; openssl ca -batch -config authority.cnf "
                           "-in plc.csr -out early.pem -startdate 20990101000000Z -enddate 20991231000000Z")
        self.refused(self.context("early"), "certificate is not yet valid")

    def test_old_protocols_and_bytes_that_are_no_tls_are_refused(self):
        old = self.context()
        old.set_ciphers("DEFAULT:@SECLEVEL=0")
        old.minimum_version = old.maximum_version = ssl.TLSVersion.TLSv1_1
        self.refused(old, "unsupported protocol")
        with socket.create_connection(("127.0.0.1", self.tls_port), timeout=8) as plain:
            plain.sendall(KNOWN)
            try:
                self.assertIn(plain.recv(300)[:1], (b"", b"\x15"))  # an alert, or nothing
            except ConnectionResetError:
                pass
        wait_until(lambda: "wrong version number" in self.log_text(), "the reason", 10)

    def test_a_handshake_that_does_not_end_is_ended_and_keeps_no_other_host_waiting(self):
        idle = [socket.create_connection(("127.0.0.1", self.tls_port), timeout=15) for _ in range(4)]
        begin = time.monotonic()
        self.assertEqual(self.ask(self.connect(self.context(), "127.0.0.2")), ANSWER)
        with self.assertRaises(OSError):
            self.ask(self.connect(self.context()))
        wait_until(lambda: "too many of its handshakes have begun" in self.log_text(), "the reason", 10)
        for each in idle:
            self.assertEqual(each.recv(1), b"")
            each.close()
        self.assertGreater(time.monotonic() - begin, 4.0)
        self.assertEqual(self.ask(self.connect(self.context())), ANSWER)


class Renewed(Tls):
    def certificate(self):
        return self.connect(self.context()).getpeercert()["serialNumber"]

    def test_replaced_files_count_from_the_next_client_on_and_useless_ones_do_not(self):
        first = self.certificate()
        stays = self.connect(self.context())
        self.assertEqual(self.ask(stays), ANSWER)
        for line in recipe():
            if "daemon" in line:
                shell(self.folder, line)
        second = self.certificate()
        self.assertNotEqual(first, second)
        self.assertEqual(self.ask(stays), ANSWER)
        (self.folder / "daemon.key").write_text("no key")
        self.assertEqual(self.certificate(), second)
        self.assertRegex(self.log_text(), r"serve\.tls\.key: .*daemon\.key: cannot be read as .*still counts")

    def test_a_revoked_certificate_counts_no_more(self):
        shell(self.folder, "touch index; echo 01 >serial")
        (self.folder / "authority.cnf").write_text(AUTHORITY)
        revoke = "openssl ca -config authority.cnf -gencrl -out revoked.pem"
        shell(self.folder, revoke)
        self.daemon.terminate()
        self.assertEqual(self.daemon.wait(20), 0)
        self.config.write_text(self.config.read_text().replace("write_roles", 'revoked = "revoked.pem"\nwrite_roles'))
        self.start_again()
        self.assertEqual(self.ask(self.connect(self.context("viewer"))), ANSWER)
        shell(self.folder, f"openssl ca -config authority.cnf -revoke viewer.pem && {revoke}")
        self.refused(self.context("viewer"), "certificate revoked")


class ByTlsOnly(Tls):
    config_text = CONFIG.replace("[serve]", "[serve]\nplain = false") + TLS

    def meet_daemon(self):
        self.wait_for_tls(1)

    def test_nobody_is_served_without_a_certificate(self):
        self.assertFalse(can_connect(self.port))
        self.assertEqual(self.ask(self.connect(self.context())), ANSWER)


class Configured(unittest.TestCase):
    """Bad files are one line with file, line and field, before anything runs."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        make_certificates(self.folder)

    def check(self, tls=TLS, text=CONFIG):
        config = self.folder / "twin.toml"
        config.write_text((text + tls).format(port=1502, device=1503, tls=8802))
        said = run_daemon("--check", config)
        self.assertEqual(said.returncode, 1)
        self.assertEqual(len(said.stderr.splitlines()), 1, said.stderr)
        return said.stderr, config.read_text().splitlines()

    def test_each_file_that_cannot_be_used_is_named(self):
        key = self.folder / "daemon.key"
        whole = key.read_bytes()
        for spoil, field, words in (
                (lambda: key.unlink(), "key", "No such file"),
                (lambda: key.write_bytes(whole) and key.chmod(0o644), "key", "every user may read"),
                (lambda: (key.chmod(0o600), key.write_text("no key")), "key", "cannot be read as the certificate's private key"),
                (lambda: shutil.copy(self.folder / "plc.key", key), "key", "key values mismatch"),
                (lambda: shell(self.folder, "openssl ec -in plc.key -aes128 -passout pass:x -out daemon.key; chmod 600 daemon.key"),
                 "key", "without a passphrase"),
                (lambda: (key.write_bytes(whole), (self.folder / "ca.pem").write_text("")), "clients_ca", "certificates in PEM"),
                (lambda: (self.folder / "daemon.pem").write_text("x"), "certificate", "a certificate in PEM"),
                (lambda: ((self.folder / "daemon.pem").unlink(), (self.folder / "daemon.pem").mkdir()), "certificate",
                 "must be a file of at most 1 MiB")):
            spoil()
            with self.subTest(field, words=words):
                message, lines = self.check()
                found = re.search(r"twin\.toml:(\d+): serve\.tls\.(\w+): ", message)
                self.assertTrue(found, message)
                self.assertEqual(found[2], field)
                self.assertTrue(lines[int(found[1]) - 1].startswith(f"{field} = "), message)
                self.assertIn(words, message)

    def test_a_daemon_that_nobody_could_ask_and_a_port_taken_twice_are_refused(self):
        message, _ = self.check("", CONFIG.replace("[serve]", "[serve]\nplain = false"))
        self.assertRegex(message, r"serve\.plain: .*\[serve\.tls\]")
        message, _ = self.check(TLS.replace("{tls}", "{port}"))
        self.assertRegex(message, r"serve\.tls\.port: ")


if __name__ == "__main__":
    main()
