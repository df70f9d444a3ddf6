"""Commands from the live page in Chromium, and what of them a program may and may not do by HTTP: refused before login,
obeyed behind it, each in the log with who.

page_commands_test.py DAEMON MAKE_SMALL_NETWORK [unittest options]
"""
import http.client
import json
import pathlib
import subprocess
import tempfile

from live_page_test import PHONE, LivePage
from ports import can_connect, wait_until
from running_daemon import PROGRAMS, main, run_daemon

PASSWORD = "correct horse"
TARE = {"command": "tare", "value": "take"}
OURS = {"X-Spindle-Twin": "command"}


def hash_line(user, password=PASSWORD):
    return subprocess.run([PROGRAMS["daemon"], "--hash-password", user], input=password + "\n", capture_output=True,
                          text=True, timeout=30)


class Commands(LivePage):
    config_text = LivePage.config_text + '[http.commands]\naccounts = "{accounts}"\n'

    def start_devices(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        accounts = pathlib.Path(folder.name) / "page.accounts"
        accounts.write_text(hash_line("anna").stdout)
        accounts.chmod(0o600)
        return super().start_devices() | {"accounts": accounts}

    def ask(self, path, body=None, method="POST", **headers):
        """Status, cookie and what was said."""
        client = http.client.HTTPConnection("127.0.0.1", self.http_port, timeout=20)
        self.addCleanup(client.close)
        text = body if isinstance(body, str) else json.dumps(body)
        client.request(method, f"/api/v1/{path}", text if method == "POST" else None, headers)
        reply = client.getresponse()
        return reply.status, reply.getheader("Set-Cookie"), json.loads(reply.read())

    def log_in(self, user="anna", password=PASSWORD):
        status, cookie, _ = self.ask("login", {"user": user, "password": password}, **OURS)
        return status, cookie and cookie.split(";")[0]

    def tares(self):
        return self.read(28, 1)[0]

    def result_of(self, order_id):
        ids, results = self.read(1404, 8), self.read(1420, 8)
        return results[ids.index(order_id)] if order_id in ids else None

    def click(self, selector):
        self.tell(evaluate=f"document.querySelector({json.dumps(selector)}).click()")

    def fill(self, **texts):
        """By id, as a person does."""
        for element, text in texts.items():
            self.enter(f"#{element.replace('_', '-')}", text)

    def enter(self, selector, text):
        self.tell(evaluate=f"{{ const field = document.querySelector({json.dumps(selector)}); field.value = {json.dumps(text)}; "
                           "field.dispatchEvent(new Event('input', { bubbles: true })); }")

    def log_in_by_page(self, password):
        self.fill(user="anna", password=password)
        self.click("#login button")

    def is_shown(self, element):
        return self.tell(evaluate=f"document.getElementById('{element}').getClientRects().length > 0")


class ByPage(Commands):
    def test_a_tare_is_refused_before_login_and_works_after_and_the_log_says_who(self):
        self.open()
        self.run_well()
        wait_until(lambda: self.is_shown("login"), "the login", 10)
        self.assertFalse(self.is_shown("orders"))
        before = self.tares()
        self.click('[data-command="tare"][data-value="take"]')  # a button that nobody sees yet
        wait_until(lambda: "log in first" in self.text("command-said"), "the refusal", 10)
        self.assertEqual(self.tares(), before)
        self.log_in_by_page("correct mule")
        wait_until(lambda: "the name or the password is wrong" in self.text("command-said"), "the refusal", 10)
        self.log_in_by_page(PASSWORD)
        wait_until(lambda: self.is_shown("orders"), "the commands", 10)
        self.assertEqual(self.text("user-name"), "anna")
        self.click('[data-command="tare"][data-value="take"]')
        wait_until(lambda: "Take as zero: done" in self.text("ordered"), "the result on the page", 10)
        self.assertEqual(self.tares(), before + 1)
        self.fill(length_um="-3.5", length_sd="2")
        self.click("#length button")
        wait_until(lambda: "-3.5 µm: done" in self.text("ordered"), "the touch-off", 10)
        for line in ("login as anna from 127.0.0.1 refused", "anna logged in from 127.0.0.1",
                     "anna at 127.0.0.1: tare take, order 60001", "anna at 127.0.0.1: length -3.5 um"):
            self.assert_logged(line)
        self.assertEqual(self.tell(judge=True), [])
        self.click("#logout")
        wait_until(lambda: self.is_shown("login"), "the login again", 10)
        seen = self.tell(seen=True)
        self.assertEqual(seen["elsewhere"], [])
        self.assertTrue(all("401" in each for each in seen["complaints"]), seen)  # Chromium's own words of a refusal

    def test_on_a_phone_in_the_dark_nothing_is_wider_and_axe_finds_nothing(self):
        self.open(colorScheme="dark", **PHONE)
        self.run_well()
        wait_until(lambda: self.is_shown("login"), "the login", 10)
        self.assertEqual(self.tell(judge=True), [])
        self.log_in_by_page(PASSWORD)
        wait_until(lambda: self.is_shown("orders"), "the commands", 10)
        wide = self.tell(evaluate="document.documentElement.scrollWidth - document.documentElement.clientWidth")
        self.assertEqual((self.tell(judge=True), wide), ([], 0))


class ByProgram(Commands):
    def test_what_is_not_from_our_page_or_not_logged_in_changes_nothing(self):
        self.write_signals()
        self.wait_for_state(1)
        status, cookie = self.log_in()
        self.assertEqual(status, 200)
        self.assertEqual(self.ask("command", TARE, **OURS)[0], 401)
        self.assertEqual(self.ask("command", TARE, Cookie=cookie)[0], 403)
        self.assertEqual(self.ask("command", TARE, Cookie=cookie, Origin="http://elsewhere.example", **OURS)[0], 403)
        self.assertEqual(self.ask("command", TARE, method="GET")[0], 405)
        for body in ("", "{", "[]", {"command": "tare"}, {"command": "tare", "value": "all"}):
            status, _, said = self.ask("command", body, Cookie=cookie, **OURS)
            self.assertEqual(status, 400, body)
            self.assertNotIn("\n", said["error"])
        self.assertEqual(self.ask("command", "x" * 2049, Cookie=cookie, **OURS)[0], 413)
        self.assertEqual(self.tares(), 0)
        status, _, said = self.ask("command", TARE, Cookie=cookie, **OURS)
        self.assertEqual(status, 202)
        wait_until(lambda: self.result_of(said["order_id"]) == 2, "the tare to be done", 10)
        self.assertEqual(self.tares(), 1)

    def test_switches_read_back_and_a_session_ends_with_the_daemon(self):
        self.write_signals()
        self.wait_for_state(1)
        _, cookie = self.log_in()
        order = {"command": "compensation", "value": "off"}
        self.assertEqual(self.ask("command", order, Cookie=cookie, **OURS)[0], 202)
        wait_until(lambda: self.read(1029, 1, holding=True) == [0], "the switch in the registers", 10)
        self.daemon.terminate()
        self.daemon.wait(20)
        self.start_again()
        wait_until(lambda: can_connect(self.http_port), "the HTTP port")
        self.assertEqual(self.log_in()[0], 200)
        self.assertEqual(self.ask("command", TARE, Cookie=cookie, **OURS)[0], 401)

    def test_passwords_are_tried_five_times_and_the_cycle_goes_on(self):
        self.write_signals()
        self.wait_for_state(1)
        self.assertEqual([self.log_in(password="guess")[0] for _ in range(7)], [401] * 5 + [429] * 2)
        self.assertEqual(self.log_in()[0], 429)
        self.assertEqual(self.read(10, 1), [1])


class Refusals(Commands):
    def test_a_hash_of_another_form_is_refused_with_file_and_line(self):
        text = self.config.read_text()
        accounts = pathlib.Path(text.split('accounts = "')[1].split('"')[0])
        accounts.write_text(accounts.read_text() + "bert:$2y$10$abcdefghijklmnopqrstuv\n")
        checked = run_daemon("--check", self.config)
        self.assertEqual((checked.returncode, checked.stderr),
                         (1, f"spindle-twind: {accounts}:2: the hash of bert: must be a hash of argon2id as "
                             "`spindle-twind --hash-password NAME` prints it\n"))

    def test_passwords_do_not_pass_a_network_without_being_told_to(self):
        self.config.write_text(self.config.read_text().replace("[http]", '[http]\naddress = "0.0.0.0"'))
        checked = run_daemon("--check", self.config)
        self.assertEqual(checked.returncode, 1)
        self.assertIn("http.commands.unencrypted: must be true", checked.stderr)

    def test_a_password_comes_by_stdin_and_its_errors_are_one_line(self):
        for user, password, wanted in (("anna", "short", "8 to 128 bytes"), ("an na", PASSWORD, "NAME must be")):
            made = hash_line(user, password)
            self.assertEqual((made.returncode, made.stdout, made.stderr.count("\n")), (1, "", 1))
            self.assertIn(wanted, made.stderr)


class Off(LivePage):
    def test_without_the_table_the_page_has_no_commands_and_posts_name_the_key(self):
        self.open()
        self.run_well()
        self.assertTrue(self.tell(evaluate="document.getElementById('commands').hidden"))
        self.assertEqual(self.text("may-change"), "Nothing can be changed here.")
        client = http.client.HTTPConnection("127.0.0.1", self.http_port, timeout=20)
        self.addCleanup(client.close)
        for path in ("login", "logout", "command"):
            client.request("POST", f"/api/v1/{path}", "{}", OURS)
            reply = client.getresponse()
            self.assertEqual((reply.status, "[http.commands]" in reply.read().decode()), (403, True), path)
        self.assertEqual(self.tell(seen=True), {"elsewhere": [], "complaints": []})



if __name__ == "__main__":
    main()
