#!/usr/bin/python3
"""annulus serve: the console as a whole, over TLS, with its simulated booth; stopped, killed, started again."""

import os
import re
import socket
import ssl
import stat
import subprocess
import time
import warnings

import annulus_cli
from annulus_cli import ProgramTest, TIME_FACTOR
from console_client import Browser, Console


class Serve(ProgramTest):
    def start(self, *arguments):
        console = Console(self.program, self.folder, *arguments)
        self.addCleanup(console.close)
        return console, Browser(console.port)

    def wait_for(self, what, seconds=10):
        """Until `what()` is true."""
        end = time.monotonic() + seconds * TIME_FACTOR
        while not what():
            self.assertLess(time.monotonic(), end, "it took too long")
            time.sleep(0.05)

    def test_it_is_ready_soon_and_says_where_it_is(self):
        console, browser = self.start()
        self.assertLess(console.ready_after, 3 * TIME_FACTOR)
        self.assertRegex(console.greeting, r"SHA-256 [0-9A-F]{2}(:[0-9A-F]{2}){31}")
        status, page = browser.get("/")
        self.assertEqual(status, 200)
        self.assertIn("<html", page)
        self.assertIn("frame-ancestors 'none'", browser.headers["Content-Security-Policy"])

    def test_somebody_logs_in_and_out(self):
        _, browser = self.start()
        status, session = browser.get("/api/session")
        self.assertEqual((status, session["role"], session["simulated"]), (200, "none", True))
        self.assertEqual(browser.log_in("operator")["role"], "operator")
        cookie = browser.cookie
        self.assertEqual(browser.get("/api/customers")[0], 200)
        self.assertEqual(browser.get("/api/users")[0], 403)
        self.assertEqual(browser.post("/api/logout")[0], 200)
        browser.cookie = cookie
        self.assertEqual(browser.get("/api/customers")[0], 401)

    def test_forgeries_are_refused_and_in_the_audit(self):
        _, browser = self.start()
        browser.log_in("operator")
        body = {"name": "Forged"}
        for headers, status in (({"Host": "evil.example"}, 403), ({"Origin": "https://evil.example"}, 403),
                                ({"Origin": None}, 403), ({"X-CSRF-Token": "0" * 64}, 403), ({"X-CSRF-Token": None}, 403),
                                ({"Sec-Fetch-Site": "cross-site"}, 403), ({"Content-Type": "text/plain"}, 415)):
            with self.subTest(headers):
                self.assertEqual(browser.post("/api/customers", body, headers=headers)[0], status)
        self.assertEqual(browser.get("/api/customers")[1]["customers"], [])
        browser.log_in("admin")
        status, audit = browser.get("/api/audit?limit=100")
        self.assertEqual((status, audit["verified"]), (200, True))
        self.assertGreaterEqual(sum(line["action"] == "refused" for line in audit["lines"]), 7)

    def test_anybody_may_stop_and_the_booth_is_reached(self):
        _, browser = self.start()
        self.wait_for(lambda: browser.get("/api/session")[1]["booth_connected"], 20)
        self.assertEqual(browser.post("/api/stop", headers={"X-CSRF-Token": None})[0], 200)

    def test_only_loopback_listens(self):
        console, _ = self.start()
        ours = []
        for table in ("/proc/net/tcp", "/proc/net/tcp6"):  # what ss -ltn reads
            with open(table, encoding="utf-8") as f:
                rows = [line.split() for line in f.readlines()[1:]]
            ours += [row[1].split(":")[0] for row in rows if row[3] == "0A" and int(row[1].split(":")[1], 16) == console.port]
        self.assertTrue(ours)
        for address in ours:  # words of the host's byte order
            self.assertIn(address, ("0100007F", "00000000000000000000000001000000"))

    def test_the_certificate_is_ours_for_localhost_and_nothing_old_is_spoken(self):
        console, _ = self.start()
        authority = self.find("authority")
        context = ssl.create_default_context(cafile=authority)
        with socket.create_connection(("127.0.0.1", console.port)) as plain:
            with context.wrap_socket(plain, server_hostname="localhost") as secure:
                self.assertIn(secure.version(), ("TLSv1.2", "TLSv1.3"))
        old = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        old.check_hostname = False
        old.verify_mode = ssl.CERT_NONE
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            old.minimum_version = ssl.TLSVersion.TLSv1
            old.maximum_version = ssl.TLSVersion.TLSv1_1
        with socket.create_connection(("127.0.0.1", console.port)) as plain:
            with self.assertRaises((ssl.SSLError, ConnectionError)):
                old.wrap_socket(plain)

    def find(self, part):
        """The certificate file whose name has `part` in it."""
        for path, _, names in os.walk(self.path("station")):
            for name in names:
                if part in name and (name.endswith(".pem") or name.endswith(".crt")) and "key" not in name:
                    return os.path.join(path, name)
        self.fail(f"no {part} certificate in {os.listdir(self.path('station'))}")

    def test_files_are_for_their_owner_only(self):
        console, _ = self.start()
        console.stop()
        self.assertEqual(stat.S_IMODE(os.stat(self.path("station")).st_mode), 0o700)
        for path, _, names in os.walk(self.path("station")):
            for name in names:
                mode = os.lstat(os.path.join(path, name)).st_mode
                self.assertTrue(stat.S_ISREG(mode), name)
                self.assertEqual(stat.S_IMODE(mode) & 0o077, 0, f"{name}: {mode:o}")

    def test_a_stop_is_in_order_within_two_seconds(self):
        console, browser = self.start()
        browser.log_in("operator")
        seconds, code = console.stop()
        self.assertEqual(code, 0)
        self.assertLess(seconds, 2 * TIME_FACTOR)
        self.assertEqual(self.processes_of(self.path("station")), [], "a simulated booth was left behind")

    def processes_of(self, text):
        """Command lines of running processes that name `text`."""
        found = []
        for pid in filter(str.isdigit, os.listdir("/proc")):
            try:
                with open(f"/proc/{pid}/cmdline", "rb") as f:
                    line = f.read().replace(b"\0", b" ").decode("utf-8", "replace")
            except OSError:
                continue  # it has ended meanwhile
            if text in line:
                found.append(line)
        return found

    def test_killed_it_is_back_soon_and_has_lost_nothing_it_said_yes_to(self):
        console, browser = self.start()
        browser.log_in("operator")
        kept = []
        for i in range(20):
            status, customer = browser.post("/api/customers", {"name": f"Customer {i}"})
            self.assertEqual(status, 200, customer)
            kept.append(customer["id"])
        console.kill()
        console, browser = self.start()
        self.assertLess(console.ready_after, 3 * TIME_FACTOR)
        self.assertEqual(browser.get("/")[0], 200)
        browser.log_in("operator")
        there = [one["id"] for one in browser.get("/api/customers?limit=100")[1]["customers"]]
        self.assertEqual(sorted(there), sorted(kept))

    def test_the_process_has_given_up_what_it_does_not_need(self):
        console, _ = self.start()
        with open(f"/proc/{console.process.pid}/status", encoding="utf-8") as f:
            status = f.read()
        self.assertRegex(status, r"NoNewPrivs:\s+1")
        self.assertRegex(status, r"Seccomp:\s+2")
        for task in os.listdir(f"/proc/{console.process.pid}/task"):
            with open(f"/proc/{console.process.pid}/task/{task}/status", encoding="utf-8") as f:
                self.assertRegex(f.read(), r"Seccomp:\s+2", "every thread")

    def test_two_consoles_do_not_share_a_folder(self):
        self.start()
        done = self.run_program("serve", "--simulated", "--port", "0", "--folder", "station")
        self.assertEqual(done.returncode, 1)
        self.assertIn("another console serves this folder", done.stderr)

    def test_passwords_are_told_once_and_again_only_when_they_are_made_anew(self):
        def greeting(*arguments):
            with subprocess.Popen([self.program, "serve", "--simulated", "--port", "0", "--folder", self.path("own"), *arguments],
                                  stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True) as process:
                text = ""
                while "Ctrl-C" not in text:
                    line = process.stdout.readline()
                    self.assertTrue(line, text)
                    text += line
                process.terminate()
                return re.findall(r"^ +(operator|technician|admin) +(\S+)$", text, re.MULTILINE)

        first = dict(greeting())
        self.assertEqual(set(first), {"operator", "technician", "admin"})
        self.assertEqual(greeting(), [])
        again = dict(greeting("--reset-passwords"))
        self.assertEqual(set(again), set(first))
        self.assertNotEqual(again, first)
        for path, _, names in os.walk(self.path("own")):
            for name in names:
                with open(os.path.join(path, name), "rb") as f:
                    self.assertNotIn(again["admin"].encode(), f.read(), name)

    def test_a_real_station_needs_its_store_and_no_root(self):
        self.write("booth.toml", "[station]\nid = \"booth-1\"\n")
        self.assertIn("--simulated", self.fails("serve", status=2))
        if os.geteuid() == 0:
            self.assertIn("root", self.fails("serve", "--config", "booth.toml", status=2))
        self.assertIn("[store]", self.fails("serve", "--config", "booth.toml", "--allow-root", status=2))

    def test_from_afar_only_with_an_admin(self):
        self.write("booth.toml", f"[store]\nfolder = \"{self.path('real')}\"\n[console]\naddresses = [\"127.0.0.3\"]\n")
        done = self.run_program("serve", "--config", "booth.toml", "--allow-root", "--port", "0")
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("no admin", done.stderr)


if __name__ == "__main__":
    annulus_cli.main()
