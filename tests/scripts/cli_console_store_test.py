#!/usr/bin/python3
"""The console's store through its own interface: imports, users, retention, backup, erasure with its proof, and a store
that is locked, damaged or lacks a file while the console serves it (fault rows D8, D9, D10)."""

import base64
import json
import os
import shutil
import sqlite3
import time
import urllib.parse

import annulus_cli
from annulus_cli import TIME_FACTOR
from console_client import PASSWORDS, Browser
from console_station import StationTest

IMPORT_LIMIT = 64 << 20  # docs/console_api.md, section 1
DAY_MS = 24 * 3600 * 1000


def now_ms():
    return int(time.time() * 1000)


class Imports(StationTest):
    def setUp(self):
        super().setUp()
        self.console, self.browser = self.start()
        self.browser.log_in("operator")
        self.who = self.customer(self.browser, "Ada Example")

    def imported(self, data):
        return self.job(self.browser, self.upload(self.browser, self.who, data))["result"]["scan"]

    def refused(self, data, *naming):
        """A job that fails, saying why, and leaves no scan."""
        before = self.gives(self.browser.get("/api/scans"))["scans"]
        error = self.job(self.browser, self.upload(self.browser, self.who, data), "failed")["error"]
        for text in naming:
            self.assertIn(text, " ".join(error.values()))
        self.assertNotIn("/dev/shm", " ".join(error.values()), "where a job works is no matter of the page's")
        self.assertEqual(self.gives(self.browser.get("/api/scans"))["scans"], before)

    def head(self, *arguments):
        self.succeeds("scan", "--profile", "breath", "--out", "scan.mcap", *arguments, timeout=300)
        return self.read("scan.mcap")

    def test_a_recording_of_our_own_program(self):
        recording = self.head()
        scan = self.imported(recording)
        self.assertEqual((scan["customer_id"], scan["consent_id"], scan["profile"]), (*self.who, "breath"))
        self.assertIn(scan["verdict"], ("good", "usable", "repeat"))
        self.assertFalse(scan["recording_missing"])
        inspected = self.succeeds_json("inspect", "scan.mcap")
        self.assertEqual(scan["summary"]["levels"], inspected["levels"])
        self.assertEqual(scan["summary"]["recording_bytes"], len(recording))
        technician = self.logged_in(self.console, "technician")
        document = self.gives(technician.get(f"/api/scans/{scan['id']}/document?kind=recording", raw=True))
        self.assertEqual(document, recording, "the same bytes come back")

    def test_the_same_recording_twice_is_one_scan(self):
        recording = self.head()
        first, second = self.imported(recording), self.imported(recording)
        self.assertEqual(first["id"], second["id"])
        self.assertEqual(len(self.gives(self.browser.get("/api/scans"))["scans"]), 1)
        other = self.customer(self.browser, "Grace Example")
        third = self.job(self.browser, self.upload(self.browser, other, recording))["result"]["scan"]
        self.assertNotEqual(third["id"], first["id"], "of another customer it is another scan")

    def test_a_range_table_becomes_a_model_by_itself(self):
        scan = self.import_scan(self.browser, self.who, self.cylinder())
        self.assertEqual(self.gives(self.browser.get(f"/api/scans/{scan}"))["summary"]["levels"], 21)
        section = self.gives(self.browser.post(f"/api/scans/{scan}/section", {"z_mm": 100}))
        self.assertAlmostEqual(section["area_mm2"], annulus_cli.EllipticCylinder().area, delta=0.01 * annulus_cli.EllipticCylinder().area)

    def test_a_cut_recording_is_taken_as_far_as_it_goes_and_is_to_be_repeated(self):
        recording = self.head()
        scan = self.imported(recording[:len(recording) // 2])
        self.write("half.mcap", recording[:len(recording) // 2])
        self.assertEqual(scan["summary"]["levels"], self.succeeds_json("inspect", "half.mcap")["levels"])
        self.assertLess(scan["summary"]["levels"], scan["summary"]["planned_levels"])
        self.assertEqual(scan["verdict"], "repeat")

    def test_what_is_no_recording(self):
        recording = self.head()
        self.refused(recording[:100], "recording")
        self.refused(b"Dear customer,\nthis is a letter.\n", "line 1")
        self.refused(b"\x1f\x8b but no gzip")
        self.refused(os.urandom(10_000))
        self.refused(b"level,z_mm,sensor,theta_deg,range_mm\n0,0,0,0,nan\n")
        self.assertEqual(self.upload(self.browser, self.who, b"")[0], 400)

    def test_a_sealed_recording_is_refused_and_its_key_named(self):
        self.write("other.key", "elsewhere-7 = " + "5c" * 32 + "\n")
        os.chmod(self.path("other.key"), 0o600)
        sealed = self.head("--key-file", "other.key")
        self.refuses(self.upload(self.browser, self.who, sealed), 400, "elsewhere-7", "--key-file", field="body")
        shutil.copy(self.path("station/station.key"), self.path("own.key"))
        own = self.head("--key-file", "own.key", "--force")
        self.refuses(self.upload(self.browser, self.who, own), 400, "sealed", field="body")
        self.assertEqual(self.gives(self.browser.get("/api/scans"))["scans"], [])
        self.succeeds("export", "scan.mcap", "--key-file", "own.key", "--out", "open.mcap")
        self.imported(self.read("open.mcap"))

    def test_too_much(self):
        path = f"/api/scans/import?customer_id={self.who[0]}&consent_id={self.who[1]}"
        headers = {"Content-Type": "application/octet-stream", "Content-Length": str(IMPORT_LIMIT + 1)}
        self.assertEqual(self.browser.post(path, b"", headers=headers)[0], 413)
        self.assertEqual(self.browser.get("/api/customers")[0], 200)

    def test_for_whom_it_is_must_be_right(self):
        other = self.customer(self.browser, "Grace Example")
        table = self.cylinder()
        self.refuses(self.upload(self.browser, ("K-999999", self.who[1]), table), 400, field="customer_id")
        self.refuses(self.upload(self.browser, (self.who[0], other[1]), table), 400, field="consent_id")
        self.gives(self.browser.post(f"/api/consents/{self.who[1]}/withdraw", {}))
        self.refuses(self.upload(self.browser, self.who, table), 400, "withdrawn", field="consent_id")
        self.assertEqual(self.upload(self.logged_in(self.console, "technician"), other, table)[0], 403)
        self.assertEqual(self.upload(Browser(self.console.port), other, table)[0], 401)


class Users(StationTest):
    def setUp(self):
        super().setUp()
        self.console, self.admin = self.start()
        self.admin.log_in("admin")

    def add(self, name, role, password="seven green bottles 4"):
        return self.gives(self.admin.post("/api/users", {"name": name, "role": role, "password": password}))

    def log_in(self, name, password="seven green bottles 4"):
        browser = Browser(self.console.port)
        browser.get("/api/session")
        return browser, browser.post("/api/login", {"user": name, "password": password})

    def test_a_user_is_made_and_may_do_what_the_role_says(self):
        made = self.add("sato", "operator")
        self.assertEqual((made["role"], made["enabled"], made["has_pin"], made["has_totp"], made["last_login_ms"]),
                         ("operator", True, False, False, None))
        browser, answer = self.log_in("sato")
        self.assertEqual(self.gives(answer)["role"], "operator")
        self.assertEqual(browser.get("/api/customers")[0], 200)
        self.assertEqual(browser.get("/api/users")[0], 403)
        listed = {one["name"]: one for one in self.gives(self.admin.get("/api/users"))["users"]}
        self.assertEqual(set(listed), {"sato", *PASSWORDS})
        self.assertLess(abs(listed["sato"]["last_login_ms"] - now_ms()), DAY_MS)

    def test_what_makes_no_user(self):
        good = {"name": "sato", "role": "operator", "password": "seven green bottles 4"}
        for change, field in (({"name": "sa to"}, "name"), ({"name": ""}, "name"), ({"role": "none"}, "role"),
                              ({"role": "boss"}, "role"), ({"password": "short"}, "password"),
                              ({"password": "password1234"}, "password"), ({"name": "operator"}, "name")):
            with self.subTest(change):
                self.refuses(self.admin.post("/api/users", {**good, **change}), 409 if change == {"name": "operator"} else 400,
                             field=field)
        self.assertEqual(self.admin.post("/api/users", {**good, "colour": "red"})[0], 400)
        for user in ("operator", "technician"):
            self.assertEqual(self.logged_in(self.console, user).post("/api/users", good)[0], 403)
        self.assertEqual(len(self.gives(self.admin.get("/api/users"))["users"]), 3)

    def test_a_change_of_role_or_account_ends_the_sessions(self):
        self.add("sato", "operator")
        for change in ({"role": "technician"}, {"enabled": False}, {"enabled": True, "password": "nine blue kettles 88"}):
            password = "seven green bottles 4"
            browser, answer = self.log_in("sato", password)
            changed = self.gives(self.admin.post("/api/users/sato", change))
            if answer[0] == 200:
                self.assertEqual(browser.get("/api/jobs")[0], 401, change)
            for key in set(change) - {"password"}:
                self.assertEqual(changed[key], change[key])
        self.assertEqual(self.log_in("sato")[1][0], 401)
        self.assertEqual(self.gives(self.log_in("sato", "nine blue kettles 88")[1])["role"], "technician")

    def test_a_changed_password_ends_the_other_sessions_and_not_this_one(self):
        self.add("sato", "operator")
        here, there = self.log_in("sato")[0], self.log_in("sato")[0]
        wrong = here.post("/api/password", {"old": "not this one 1234", "new": "nine blue kettles 88"})
        self.refuses(wrong, 400, field="old")
        self.refuses(here.post("/api/password", {"old": "seven green bottles 4", "new": "short"}), 400, field="new")
        self.assertEqual(there.get("/api/customers")[0], 200)
        self.gives(here.post("/api/password", {"old": "seven green bottles 4", "new": "nine blue kettles 88"}))
        self.assertEqual(there.get("/api/customers")[0], 401)
        self.assertEqual(here.get("/api/customers")[0], 200)
        self.assertEqual(self.log_in("sato")[1][0], 401)
        self.assertEqual(self.log_in("sato", "nine blue kettles 88")[1][0], 200)

    def test_the_last_admin_stays(self):
        self.refuses(self.admin.post("/api/users/admin/remove", {}), 409, "last admin")
        self.refuses(self.admin.post("/api/users/admin", {"role": "operator"}), 409, "last admin")
        self.refuses(self.admin.post("/api/users/admin", {"enabled": False}), 409, "last admin")
        self.assertEqual(self.admin.get("/api/users")[0], 200, "and is still logged in")
        self.add("second", "admin")
        second, _ = self.log_in("second")
        self.gives(second.post("/api/users/admin/remove", {}))
        self.assertEqual(self.admin.get("/api/users")[0], 401)
        self.refuses(second.post("/api/users/second/remove", {}), 409, "last admin")

    def test_a_second_factor_is_shown_once(self):
        changed = self.gives(self.admin.post("/api/users/technician", {"totp": "new"}))
        self.assertTrue(changed["has_totp"])
        uri = urllib.parse.urlparse(changed["totp_uri"])
        self.assertEqual((uri.scheme, uri.netloc), ("otpauth", "totp"))
        secret = urllib.parse.parse_qs(uri.query)["secret"][0]
        self.assertGreaterEqual(len(base64.b32decode(secret + "=" * (-len(secret) % 8))), 16, "RFC 4226, section 4: 128 bits")
        listed = json.dumps(self.gives(self.admin.get("/api/users")))
        self.assertNotIn(secret, listed)
        again = self.gives(self.admin.post("/api/users/technician", {"totp": "new"}))
        self.assertNotIn(secret, again["totp_uri"])
        self.assertFalse(self.gives(self.admin.post("/api/users/technician", {"totp": "off"}))["has_totp"])
        self.refuses(self.admin.post("/api/users/technician", {"totp": "old"}), 400, field="totp")
        self.assertEqual(self.logged_in(self.console, "technician").get("/api/technician/drift")[0], 200,
                         "at the booth's own screen the password is enough")

    def test_a_pin_is_for_operators(self):
        self.assertTrue(self.gives(self.admin.post("/api/users/operator", {"pin": "402817"}))["has_pin"])
        browser = Browser(self.console.port)
        browser.get("/api/session")
        self.assertEqual(self.gives(browser.post("/api/login", {"user": "operator", "pin": "402817"}))["role"], "operator")
        self.refuses(self.admin.post("/api/users/technician", {"pin": "402817"}), 400, field="pin")
        self.refuses(self.admin.post("/api/users/operator", {"pin": "1"}), 400, field="pin")

    def test_all_of_it_is_in_the_audit_without_a_secret(self):
        self.add("sato", "operator")
        self.gives(self.admin.post("/api/users/sato", {"role": "technician"}))
        self.gives(self.admin.post("/api/users/sato/remove", {}))
        audit = self.gives(self.admin.get("/api/audit?limit=1000"))
        done = [(line["user"], line["action"], line["subject"]) for line in audit["lines"]]
        for action in ("add user", "change user", "remove user"):
            self.assertIn(("admin", action, "sato"), done)
        self.assertNotIn("seven green bottles", json.dumps(audit))


class Administration(StationTest):
    def setUp(self):
        super().setUp()
        self.console, self.operator = self.start()
        self.operator.log_in("operator")
        self.admin = self.logged_in(self.console, "admin")

    def restart(self):
        self.assertEqual(self.console.stop()[1], 0)
        self.console, self.operator = self.start()
        self.operator.log_in("operator")
        self.admin = self.logged_in(self.console, "admin")

    def change_store(self, sql, *values):
        """While no console has it open."""
        connection = sqlite3.connect(self.path("station/annulus.db"))
        with connection:
            connection.execute(sql, values)
        connection.close()

    def ids(self):
        return {one["id"] for one in self.gives(self.operator.get("/api/customers?limit=500"))["customers"]}

    def audit(self):
        return self.gives(self.admin.get("/api/audit?limit=1000"))["lines"]

    def test_what_the_store_says_of_itself(self):
        self.customer(self.operator, "Ada Example")
        for browser in (self.admin, self.logged_in(self.console, "technician")):
            said = self.gives(browser.get("/api/store"))
            self.assertEqual((said["state"], said["problem"], said["customers"], said["scans"], said["schema"]),
                             ("ready", "", 1, 0, 1))
            self.assertGreater(said["bytes"], 0)
        self.assertEqual(self.operator.get("/api/store")[0], 403)

    def test_the_audit_begins_with_the_newest_and_has_an_anchor(self):
        for _ in range(5):
            self.gives(self.admin.post("/api/retention", {"days": 90}))
        whole = self.gives(self.admin.get("/api/audit?from=1&limit=1000"))["lines"]
        self.assertEqual([line["number"] for line in whole], list(range(1, len(whole) + 1)))
        newest = self.gives(self.admin.get("/api/audit?limit=3"))["lines"]
        self.assertEqual(newest, whole[-3:])
        anchor = self.gives(self.admin.get("/api/audit/anchor"))
        self.assertEqual((anchor["number"], anchor["hash"]), (whole[-1]["number"], whole[-1]["hash"]))
        self.assertEqual(self.admin.get("/api/audit?limit=1001")[0], 400)

    def test_the_days_that_are_set_count_for_who_comes_then(self):
        before, _ = self.customer(self.operator, "before")
        self.assertEqual(self.gives(self.admin.post("/api/retention", {"days": 7}))["days"], 7)
        after, _ = self.customer(self.operator, "after")
        kept = {one["id"]: one["keep_until_ms"] - one["created_ms"]
                for one in self.gives(self.operator.get("/api/customers"))["customers"]}
        self.assertLess(abs(kept[before] - 90 * DAY_MS), DAY_MS)
        self.assertLess(abs(kept[after] - 7 * DAY_MS), DAY_MS)
        text = self.gives(self.operator.get("/api/consent-text?language=en"))
        self.assertIn("7 days", " ".join(text["paragraphs"]), "and the customer is told so")
        for days in (0, 1.5, -1, 4000, "90", None):
            self.refuses(self.admin.post("/api/retention", {"days": days}), 400, field="days")
        self.assertEqual(self.operator.post("/api/retention", {"days": 7})[0], 403)

    def test_an_admin_sees_whose_time_is_over_and_applies_it(self):
        old, _ = self.customer(self.operator, "old")
        new, _ = self.customer(self.operator, "new")
        self.gives(self.admin.post(f"/api/customers/{old}/keep", {"until_ms": now_ms() + 500}))
        self.assertEqual(self.admin.post(f"/api/customers/{old}/keep", {"until_ms": 1})[0], 400, "not in the past")
        self.wait_for(lambda: self.gives(self.admin.get("/api/retention"))["expired"])
        dry = self.gives(self.admin.get("/api/retention"))
        self.assertEqual(([one["id"] for one in dry["expired"]], dry["held"]), ([old], False))
        self.assertEqual(self.ids(), {old, new}, "looking erases nobody")
        erased = self.gives(self.admin.post("/api/retention/apply", {}))["erased"]
        self.assertEqual([(one["customer_id"], one["key_destroyed"], one["marker_hits"]) for one in erased], [(old, True, 0)])
        self.assertEqual(self.ids(), {new})
        self.assertIn(("admin", "erase", old, "ok"),
                      [(line["user"], line["action"], line["subject"], line["result"]) for line in self.audit()])

    def test_a_start_erases_by_itself_whose_time_is_over(self):
        old, _ = self.customer(self.operator, "old")
        new, _ = self.customer(self.operator, "new")
        self.assertEqual(self.console.stop()[1], 0)
        self.change_store("UPDATE customers SET keep_until_ms = 1 WHERE id = ?", old)
        self.console, self.operator = self.start()
        self.operator.log_in("operator")
        self.admin = self.logged_in(self.console, "admin")
        self.wait_for(lambda: self.ids() == {new})
        self.assertIn(("", "program", "erase", old, "ok"),
                      [(line["user"], line["origin"], line["action"], line["subject"], line["result"]) for line in self.audit()])
        said = self.gives(self.admin.get("/api/retention"))
        self.assertEqual(said["expired"], [])
        self.assertLess(abs(said["applied_ms"] - now_ms()), DAY_MS)
        self.assertFalse(os.path.exists(self.path(f"station/keys/{old}")))

    def test_a_clock_that_has_jumped_erases_nobody(self):
        old, _ = self.customer(self.operator, "old")
        self.wait_for(lambda: self.gives(self.admin.get("/api/retention"))["applied_ms"])
        self.assertEqual(self.console.stop()[1], 0)
        self.change_store("UPDATE customers SET keep_until_ms = 1")
        self.change_store("UPDATE settings SET json = ? WHERE name = 'retention_applied_ms'", str(now_ms() - 32 * DAY_MS))
        self.console, self.operator = self.start()
        self.operator.log_in("operator")
        self.admin = self.logged_in(self.console, "admin")
        self.wait_for(lambda: any(line["action"] == "apply retention" and "held back" in line["result"] for line in self.audit()))
        self.assertEqual(self.ids(), {old})
        self.assertTrue(self.gives(self.admin.get("/api/retention"))["held"])
        self.gives(self.admin.post("/api/retention/apply", {}))
        self.assertEqual(self.ids(), set())
        self.assertFalse(self.gives(self.admin.get("/api/retention"))["held"])

    def test_a_backup_is_made_and_brings_everything_back(self):
        kept, _ = self.customer(self.operator, "Ada Example", contact="ada@example.org")
        made = self.job(self.admin, self.admin.post("/api/backup", {}))["result"]
        self.assertEqual(made["keys"], made["backup"] + "-keys")
        self.assertTrue(os.path.isdir(made["backup"]) and os.path.isfile(made["keys"]))
        self.assertGreater(made["bytes"], 0)
        self.assertEqual(os.stat(made["keys"]).st_mode & 0o077, 0)
        later, _ = self.customer(self.operator, "Grace Example")
        self.assertEqual(self.console.stop()[1], 0)
        shutil.move(self.path("station"), self.path("lost"))
        backup = made["backup"].replace(self.path("station"), self.path("lost"))
        self.succeeds("store", "restore", backup, "--store", "station", "--key-file", "lost/station.key")
        shutil.copy(self.path("lost/station.key"), self.path("station/station.key"))
        self.console, self.operator = self.start()
        self.operator.log_in("operator")
        self.assertEqual(self.ids(), {kept})
        customer = self.gives(self.operator.get(f"/api/customers/{kept}"))
        self.assertEqual((customer["name"], customer["contact"]), ("Ada Example", "ada@example.org"))
        self.assertEqual(self.operator.get(f"/api/customers/{later}")[0], 404)
        self.assertEqual(self.operator.post("/api/backup", {})[0], 403)


class Erasure(StationTest):
    MARKERS = ("Wilhelmina Quastenflosse", "prefers-the-violet-hinge-4711", "Sunday at the Oyster Bar")

    def files_with(self, text, *folders):
        """Files below the folders that hold the text, as it is or in small letters."""
        found = []
        for folder in folders:
            for path, _, names in os.walk(folder):
                for name in names:
                    if not os.path.isfile(os.path.join(path, name)):
                        continue  # boothd's socket, or a temporary file that has gone meanwhile
                    try:
                        with open(os.path.join(path, name), "rb") as f:
                            content = f.read()
                    except FileNotFoundError:
                        continue
                    if text.encode() in content or text.lower().encode() in content.lower():
                        found.append(os.path.join(path, name))
        return found

    def opened_files(self):
        """Folders in memory of consoles and their jobs."""
        return [os.path.join("/dev/shm", name) for name in os.listdir("/dev/shm") if name.startswith("annulus-scratch-")]

    def test_after_an_erasure_no_byte_tells_of_the_customer(self):
        name, note, title = self.MARKERS
        console, browser = self.start()
        browser.log_in("operator")
        admin = self.logged_in(console, "admin")
        who = self.customer(browser, name, note=note, contact="w@example.org")
        scan = self.import_scan(browser, who, self.cylinder())
        style = self.gives(browser.get("/api/glasses/catalogue"))["styles"][0]["id"]
        self.gives(browser.post(f"/api/scans/{scan}/designs", {"title": title, "design": {"style": style}}))
        other = self.customer(browser, "somebody else")
        kept = self.import_scan(browser, other, self.cylinder(seed=2))
        self.assertEqual(len(self.gives(browser.get(f"/api/customers?search={name[:8]}"))["customers"]), 1)
        backups = [self.job(admin, admin.post("/api/backup", {}))["result"]]
        self.succeeds("store", "backup", "--store", "station", "--out", self.path("usb"))
        recording = self.recording_of(scan)
        sealed = self.read(recording)[200:264]
        wrapped = self.read(f"station/keys/{who[0]}").split()[-1]
        self.write("usb/proof-that-the-search-finds", f"… {note.upper()} …")
        self.assertEqual(len(self.files_with(note, self.folder)), 1)
        os.remove(self.path("usb/proof-that-the-search-finds"))

        self.refuses(browser.post(f"/api/customers/{who[0]}/erase", {"confirm": "K-000099"}), 400, field="confirm")
        proof = self.gives(browser.post(f"/api/customers/{who[0]}/erase", {"confirm": who[0]}))
        self.assertEqual((proof["customer_id"], proof["key_destroyed"], proof["marker_hits"]), (who[0], True, 0))
        self.assertGreater(proof["bytes_searched"], 0)

        for moment in ("while it is served", "after a stop"):
            with self.subTest(moment):
                for marker in self.MARKERS:
                    self.assertEqual(self.files_with(marker, self.path("station"), self.path("usb"), *self.opened_files()), [], marker)
                for _, path in self.all_files("station", "usb"):
                    with open(path, "rb") as f:
                        self.assertNotIn(wrapped, f.read(), f"{path}: the wrapped key")
                for _, path in self.all_files("station/files"):
                    with open(path, "rb") as f:
                        self.assertNotIn(sealed, f.read(), f"{path}: the sealed recording")
                self.assertFalse(os.path.exists(recording))
            if moment.startswith("while"):
                self.assertEqual(browser.get(f"/api/customers/{who[0]}")[0], 404)
                self.assertEqual(browser.get(f"/api/scans/{scan}")[0], 404)
                self.assertEqual(self.gives(browser.get(f"/api/customers?search={name[:8]}"))["customers"], [])
                self.assertEqual(self.gives(browser.get(f"/api/scans/{kept}"))["customer_id"], other[0])
                self.assertEqual(console.stop()[1], 0)

        backups.append({"backup": self.path("usb/" + next(one for one in os.listdir(self.path("usb")) if not one.endswith("-keys")))})
        for index, backup in enumerate(backups):
            answer = json.loads(self.succeeds("store", "restore", backup["backup"], "--store", f"again{index}", "--key-file",
                                              "station/station.key", "--json", "-"))
            self.assertEqual(answer["left_out"], [who[0]], "the old backup does not open for this customer")
            listed = self.succeeds("store", "list", "--names", "--store", f"again{index}", "--key-file", "station/station.key")
            self.assertIn(other[0], listed)
            self.assertNotIn(who[0], listed)
            self.assertEqual(self.files_with(name, self.path(f"again{index}")), [])

    def all_files(self, *folders):
        for folder in folders:
            for path, _, names in os.walk(self.path(folder)):
                for name in names:
                    if os.path.isfile(os.path.join(path, name)):
                        yield name, os.path.join(path, name)


class Faults(StationTest):
    def setUp(self):
        super().setUp()
        self.console, self.operator = self.start()
        self.operator.log_in("operator")

    def test_another_program_holds_the_database(self):
        """D8: a bounded wait of 2 s, then a clear error; what only looks, and STOP, are answered; nothing is lost."""
        kept, _ = self.customer(self.operator, "before")
        self.wait_for(lambda: self.gives(self.operator.get("/api/session"))["booth_connected"])
        holder = self.database()
        holder.execute("BEGIN IMMEDIATE")
        start = time.monotonic()
        self.refuses(self.operator.post("/api/customers", {"name": "meanwhile"}), 503, "another program has held its lock for 2 s")
        waited = time.monotonic() - start
        self.assertGreaterEqual(waited, 2.0)
        self.assertLess(waited, 20 * TIME_FACTOR)
        self.assertEqual(self.gives(self.operator.get(f"/api/customers/{kept}"))["name"], "before")
        self.assertEqual(self.operator.post("/api/stop")[0], 200)
        holder.execute("ROLLBACK")
        holder.close()
        self.customer(self.operator, "after")
        names = [one["name"] for one in self.gives(self.operator.get("/api/customers"))["customers"]]
        self.assertEqual(names, ["after", "before"])
        self.assertTrue(self.gives(self.logged_in(self.console, "admin").get("/api/audit"))["verified"])
        self.assertEqual(self.gives(self.operator.get("/api/session"))["store"], {"state": "ready", "problem": ""})

    def damage_page_of(self, table):
        connection = sqlite3.connect(self.path("station/annulus.db"))
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        size, = connection.execute("PRAGMA page_size").fetchone()
        page, = connection.execute("SELECT rootpage FROM sqlite_schema WHERE name = ?", (table,)).fetchone()
        connection.close()
        with open(self.path("station/annulus.db"), "r+b") as f:
            f.seek((page - 1) * size)
            f.write(b"\xff" * size)

    def test_a_damaged_database_stops_the_station_but_does_not_blind_it(self):
        """D9: read-only with the reason, the booth stays in reach, the last backup brings all back."""
        kept, _ = self.customer(self.operator, "Ada Example")
        admin = self.logged_in(self.console, "admin")
        backup = self.job(admin, admin.post("/api/backup", {}))["result"]["backup"]
        self.assertEqual(self.console.stop()[1], 0)
        self.damage_page_of("consents")
        before = self.read("station/annulus.db")

        console, browser = self.start()
        self.assertIn("damaged", console.greeting)
        session = browser.log_in("operator")
        self.assertEqual(session["store"]["state"], "read_only")
        self.assertIn("damaged", session["store"]["problem"])
        said = self.gives(self.logged_in(console, "admin").get("/api/store"))
        self.assertEqual((said["state"], said["customers"]), ("read_only", 1))
        self.assertEqual(self.gives(browser.get("/api/customers"))["customers"][0]["id"], kept)
        self.refuses(browser.post("/api/customers", {"name": "new"}), 503, "can only be read", "annulus store restore")
        self.wait_for(lambda: self.gives(browser.get("/api/session"))["booth_connected"])
        booth = self.wait_for(lambda: self.gives(browser.get("/api/booth"))["status"])
        self.assertIn("state", booth)
        self.assertEqual(browser.post("/api/stop")[0], 200)
        self.assertEqual(console.stop()[1], 0)
        self.assertEqual(self.read("station/annulus.db"), before, "not a byte of it was changed")

        shutil.move(self.path("station"), self.path("broken"))
        self.succeeds("store", "restore", backup.replace(self.path("station"), self.path("broken")), "--store", "station",
                      "--key-file", "broken/station.key")
        shutil.copy(self.path("broken/station.key"), self.path("station/station.key"))
        console, browser = self.start()
        self.assertEqual(browser.log_in("operator")["store"]["state"], "ready")
        self.assertEqual([one["id"] for one in self.gives(browser.get("/api/customers"))["customers"]], [kept])
        self.customer(browser, "again somebody")

    def test_a_recording_that_is_missing(self):
        """D10: its row says so, and all else works."""
        who = self.customer(self.operator, "Ada Example")
        lost = self.import_scan(self.operator, who, self.cylinder())
        kept = self.import_scan(self.operator, who, self.cylinder(seed=2))
        os.remove(self.recording_of(lost))
        technician = self.logged_in(self.console, "technician")
        scan = self.gives(self.operator.get(f"/api/scans/{lost}"))
        self.assertTrue(scan["recording_missing"])
        listed = {one["id"]: one["recording_missing"] for one in self.gives(self.operator.get("/api/scans"))["scans"]}
        self.assertEqual(listed, {lost: True, kept: False})
        states = {one["scan_id"]: one["state"] for one in self.gives(technician.get("/api/technician/recordings"))["recordings"]}
        self.assertEqual(states, {lost: "missing", kept: "kept"})
        self.assertEqual(self.operator.get(f"/api/scans/{lost}/measurements?language=en")[0],
                         self.operator.get(f"/api/scans/{kept}/measurements?language=en")[0], "what was derived is there")
        self.refuses(technician.get(f"/api/scans/{lost}/document?kind=recording"), 404, "not there")
        for action in ("inspect", "recover"):
            self.refuses(technician.post(f"/api/technician/recordings/{lost}/{action}", {}), 409, "not there")
        answer = self.operator.post(f"/api/scans/{lost}/fit", {})
        self.assertIn(answer[0], (404, 409, 503))
        self.refuses(answer, answer[0], "not there")
        replay = technician.post("/api/replay/open", {"scan": lost})
        self.assertIn(replay[0], (404, 409, 503))
        self.assertEqual(self.gives(self.operator.get(f"/api/scans/{kept}"))["id"], kept)
        done = self.store("verify")
        self.assertEqual(done.returncode, 1)
        self.assertIn(lost, done.stdout)
        zipped = self.operator.get(f"/api/customers/{who[0]}/export", raw=True)
        self.assertEqual(zipped[0], 200)
        proof = self.gives(self.operator.post(f"/api/customers/{who[0]}/erase", {"confirm": who[0]}))
        self.assertEqual((proof["key_destroyed"], proof["marker_hits"]), (True, 0))


if __name__ == "__main__":
    annulus_cli.main()
