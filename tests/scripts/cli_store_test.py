#!/usr/bin/python3
"""annulus store: every subcommand on a station's store; what it refuses; killed, without room, locked, damaged."""

import json
import os
import random
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import time
import unittest

import annulus_cli
from annulus_cli import SLOW_BUILD, TIME_FACTOR
from cli_bad_input_test import limit_file_size
from console_station import StationTest


class StoreTest(StationTest):
    """One station is filled by the console; each test has a copy of it, which no program serves."""

    template = None

    @staticmethod
    def fill(test):
        """Two customers, one of them with a scan that is fitted, and a design; ids in `known.json`."""
        console, browser = test.start()
        browser.log_in("operator")
        first = test.customer(browser, "Ada Example", contact="ada@example.org", note="likes round glasses")
        scan = test.import_scan(browser, first, test.cylinder())
        second = test.customer(browser, "Grace Example")
        style = test.gives(browser.get("/api/glasses/catalogue"))["styles"][0]
        test.gives(browser.post(f"/api/scans/{scan}/designs", {"title": "Sunday", "design": {"style": style["id"]}}))
        test.assertEqual(console.stop()[1], 0)
        with open(test.path("known.json"), "w", encoding="utf-8") as f:
            json.dump({"first": first[0], "second": second[0], "scan": scan}, f)
        StoreTest.template = tempfile.mkdtemp(prefix="annulus_store_")
        unittest.addModuleCleanup(shutil.rmtree, StoreTest.template)
        shutil.copytree(test.folder, StoreTest.template, dirs_exist_ok=True)

    def setUp(self):
        super().setUp()
        if StoreTest.template is None:
            self.fill(self)
        else:
            shutil.copytree(StoreTest.template, self.folder, dirs_exist_ok=True)
        known = self.read_json("known.json")
        self.first, self.second, self.scan = known["first"], known["second"], known["scan"]

    def on_store(self, *arguments, **options):
        """stdout of `annulus store …`, which must succeed."""
        done = self.store(*arguments, **options)
        self.assertEqual(done.returncode, 0, f"{arguments}: {done.stderr}")
        return done.stdout

    def on_store_json(self, *arguments, **options):
        return json.loads(self.on_store(*arguments, "--json", "-", **options))

    def is_refused(self, *arguments, naming=(), status=1, **options):
        """The last line of stderr, which is the error; what is there stays readable."""
        done = self.store(*arguments, **options)
        self.assertEqual(done.returncode, status, f"{arguments}: {done.stdout!r} {done.stderr!r}")
        error = done.stderr.splitlines()[-1]
        self.assertTrue(error.startswith("annulus: "), done.stderr)
        self.assertGreaterEqual(error.count(": "), 3, error)
        for text in naming:
            self.assertIn(text, error)
        return error

    def is_sound(self, **options):
        answer = self.on_store_json("verify", **options)
        self.assertEqual((answer["sound"], answer["problems"]), (True, []))
        return answer


class Subcommands(StoreTest):
    def test_list_names_nobody_unless_asked(self):
        text = self.on_store("list")
        self.assertIn(self.first, text)
        self.assertNotIn("Ada", text)
        self.assertIn("Ada Example", self.on_store("list", "--names"))
        answer = self.on_store_json("list")
        self.assertEqual([one["id"] for one in answer["customers"]], [self.second, self.first])  # newest first
        self.assertEqual([one["scans"] for one in answer["customers"]], [0, 1])
        found = self.on_store_json("list", "--search", "aDA", "--names")["customers"]
        self.assertEqual([(one["id"], one["name"]) for one in found], [(self.first, "Ada Example")])
        self.assertEqual(len(self.on_store_json("list", "--limit", "1")["customers"]), 1)
        self.assertEqual(self.on_store("list", "--search", "nobody of this name"), "no customers\n")

    def test_verify_counts_what_is_there(self):
        answer = self.is_sound()
        self.assertEqual((answer["customers"], answer["scans"], answer["recordings"]), (2, 1, 1))
        self.assertGreaterEqual(answer["artefacts"], 4)  # model, fit report, landmarks, design
        self.assertRegex(answer["last_hash"], "^[0-9a-f]{64}$")
        self.assertIn("all sound", self.on_store("verify"))

    def test_verify_names_what_is_damaged_and_fails(self):
        self.damage(self.recording_of(self.scan))
        done = self.store("verify")
        self.assertEqual(done.returncode, 1)
        self.assertIn(self.scan, done.stdout)
        self.assertIn("damaged", done.stdout)
        answer = json.loads(self.store("verify", "--json", "-").stdout)
        self.assertEqual((answer["sound"], len(answer["problems"]), answer["recordings"]), (False, 1, 0))

    def test_verify_finds_a_line_of_the_audit_that_was_changed(self):
        connection = self.database()
        connection.execute("DROP TRIGGER audit_is_not_changed")
        connection.execute("UPDATE audit SET user = 'mallory' WHERE number = 2")
        connection.close()
        done = self.store("verify")
        self.assertEqual(done.returncode, 1)
        self.assertIn("line 2", done.stdout)
        answer = json.loads(self.store("audit", "--json", "-").stdout)
        self.assertFalse(answer["verified"])

    def test_backup_and_restore_bring_all_back(self):
        before = self.is_sound()
        made = self.on_store_json("backup", "--out", self.path("usb"))
        self.assertEqual(made["keys"], made["backup"] + "-keys")
        self.assertEqual(sorted(os.listdir(self.path("usb"))),
                         sorted(os.path.basename(path) for path in (made["backup"], made["keys"])))
        shutil.move(self.path("station"), self.path("lost"))
        answer = self.on_store_json("restore", made["backup"] + "/", "--key-file", "lost/station.key")  # as a shell completes it
        self.assertEqual(answer["left_out"], [])
        shutil.copy(self.path("lost/station.key"), self.path("station/station.key"))
        after = self.is_sound()
        for what in ("customers", "scans", "recordings", "artefacts"):
            self.assertEqual(after[what], before[what])
        lines = self.on_store_json("audit", "--limit", "1")["lines"]
        self.assertEqual([line["action"] for line in lines], ["restore"])

    def test_restore_into_a_folder_with_a_slash(self):
        backup = self.on_store_json("backup")["backup"]
        self.succeeds("store", "restore", backup, "--store", "again/", "--key-file", "station/station.key")
        self.assertIn("all sound", self.succeeds("store", "verify", "--store", "again/", "--key-file", "station/station.key"))

    def test_the_store_s_own_folder_takes_backups_too(self):
        first, second = self.on_store_json("backup"), self.on_store_json("backup")
        self.assertNotEqual(first["backup"], second["backup"])
        self.assertTrue(first["backup"].startswith(self.path("station/backups/")), first)

    def test_erase_asks_whether_it_is_meant_and_then_leaves_nothing(self):
        self.is_refused("erase", self.first, naming=(self.first, "--yes"))
        backup = self.on_store_json("backup")["backup"]
        proof = self.on_store_json("erase", self.first, "--yes")
        self.assertEqual((proof["customer_id"], proof["key_destroyed"], proof["marker_hits"]), (self.first, True, 0))
        self.assertGreaterEqual(proof["files"], 4)
        self.assertEqual([one["id"] for one in self.on_store_json("list")["customers"]], [self.second])
        self.assertEqual(self.on_store_json("erase", self.first, "--yes"), proof, "asked for again: the same proof")
        answer = json.loads(self.succeeds("store", "restore", backup, "--store", "again", "--key-file",
                                          "station/station.key", "--json", "-"))
        self.assertEqual(answer["left_out"], [self.first])
        self.is_sound()

    def test_expire_shows_whose_time_is_over_and_erases_them_only_then(self):
        self.assertEqual(self.on_store_json("expire"), {"expired": [], "erased": []})
        connection = self.database()
        connection.execute("UPDATE customers SET keep_until_ms = 1 WHERE id = ?", (self.second,))
        connection.close()
        shown = self.on_store_json("expire")
        self.assertEqual(([one["id"] for one in shown["expired"]], shown["erased"]), ([self.second], []))
        self.assertIn("--yes", self.on_store("expire"))
        self.assertEqual(len(self.on_store_json("list")["customers"]), 2)
        erased = self.on_store_json("expire", "--yes")["erased"]
        self.assertEqual([(one["customer_id"], one["key_destroyed"]) for one in erased], [(self.second, True)])
        self.assertEqual([one["id"] for one in self.on_store_json("list")["customers"]], [self.first])

    def test_audit_shows_the_newest_unless_told_otherwise(self):
        whole = self.on_store_json("audit", "--from", "1", "--limit", "1000")
        self.assertTrue(whole["verified"])
        numbers = [line["number"] for line in whole["lines"]]
        self.assertEqual(numbers, list(range(1, len(numbers) + 1)))
        newest = self.on_store_json("audit", "--limit", "2")["lines"]
        self.assertEqual([line["number"] for line in newest], numbers[-2:])
        self.assertEqual(newest[-1]["hash"], whole["last_hash"])
        self.assertIn("the chain is whole", self.on_store("audit"))
        said = json.dumps(whole)
        for text in ("Ada", "ada@example.org", "round glasses", "Sunday"):
            self.assertNotIn(text, said, "ids only")

    def test_users_are_listed_switched_off_and_removed_but_not_the_last_admin(self):
        users = {one["name"]: one for one in self.on_store_json("users")["users"]}
        self.assertEqual({name: one["role"] for name, one in users.items()},
                         {"operator": "operator", "technician": "technician", "admin": "admin"})
        off = {one["name"]: one["enabled"] for one in self.on_store_json("users", "disable", "operator")["users"]}
        self.assertEqual(off, {"operator": False, "technician": True, "admin": True})
        self.on_store("users", "enable", "operator")
        self.on_store("users", "remove", "technician")
        self.assertEqual([one["name"] for one in self.on_store_json("users")["users"]], ["admin", "operator"])
        for what in ("remove", "disable"):
            self.is_refused("users", what, "admin", naming=("the last admin",))
        self.assertTrue({one["name"]: one["enabled"] for one in self.on_store_json("users")["users"]}["admin"])
        actions = [line["action"] for line in self.on_store_json("audit", "--limit", "3")["lines"]]
        self.assertEqual(actions, ["user remove", "user remove", "user disable"])

    def test_a_user_who_is_not_there(self):
        for what in ("remove", "disable", "enable"):
            self.is_refused("users", what, "nobody", naming=("nobody",))


class Refusals(StoreTest):
    def test_a_folder_without_a_store_is_not_made_one(self):
        os.mkdir(self.path("empty"))
        for action in (("list",), ("verify",), ("backup",), ("erase", "K-000001", "--yes"), ("expire",), ("audit",), ("users",)):
            with self.subTest(action):
                self.fails("store", *action, "--store", "empty", naming=("empty", "there is none"))
                self.fails("store", *action, "--store", "no/such/folder", naming=("no/such/folder", "there is none"))
        self.fails("rebuild", "--store", "empty", naming=("empty", "there is none"))

    def test_a_database_of_somebody_else(self):
        os.mkdir(self.path("other"))
        connection = sqlite3.connect(self.path("other/annulus.db"))
        connection.execute("CREATE TABLE theirs(a)")
        connection.commit()
        connection.close()
        done = self.run_program("store", "list", "--store", "other")
        self.assertEqual(done.returncode, 1)
        self.assertIn("not a store's", done.stderr)

    def test_another_key_opens_nothing(self):
        self.write("other.key", "station-1 = " + "ab" * 32 + "\n")
        os.chmod(self.path("other.key"), 0o600)
        for action in (("list",), ("verify",), ("backup",), ("erase", self.first, "--yes")):
            with self.subTest(action):
                self.is_refused(*action, "--key-file", "other.key", naming=("not the one that it was made with",))
        done = self.run_program("rebuild", "--store", "station", "--key-file", "other.key")
        self.assertEqual(done.returncode, 1)
        self.assertIn("not the one that it was made with", done.stderr)
        self.is_sound()

    def test_a_key_file_that_is_away_or_open_to_others(self):
        self.is_refused("list", "--key-file", "no.key", naming=("no.key",))
        os.chmod(self.path("station/station.key"), 0o644)
        self.is_refused("list", naming=("station.key",))

    def test_without_permission(self):
        os.chmod(self.folder, 0o755)  # else the way to the store is barred already
        os.chmod(self.path("station"), 0o700)

        def as_nobody():
            os.setgroups([])
            os.setgid(65534)
            os.setuid(65534)

        if os.geteuid() != 0:
            self.skipTest("only root can become somebody else")
        self.is_refused("list", naming=("station",), before=as_nobody)
        self.is_sound()

    def test_restore_over_something_and_of_nothing(self):
        made = self.on_store_json("backup", "--out", self.path("usb"))
        error = self.is_refused("restore", made["backup"], "--key-file", "station/station.key", naming=("already",))
        self.assertIn("station", error)
        self.fails("store", "restore", "usb/none", "--store", "again", "--key-file", "station/station.key", naming=("usb/none",))
        self.fails("store", "restore", made["backup"], "--keys", "usb/none", "--store", "again", "--key-file",
                   "station/station.key", naming=("usb/none",))
        self.fails("store", "restore", made["backup"], "--store", "again", naming=("--key-file",), status=2)
        self.write("other.key", "station-1 = " + "ab" * 32 + "\n")
        os.chmod(self.path("other.key"), 0o600)
        self.fails("store", "restore", made["backup"], "--store", "again", "--key-file", "other.key", naming=("key",))
        self.damage(self.path(f"usb/{os.path.basename(made['keys'])}"))
        self.fails("store", "restore", made["backup"], "--store", "again", "--key-file", "station/station.key", naming=("key",))

    def test_somebody_who_is_not_there(self):
        self.is_refused("erase", "K-999999", "--yes", naming=("K-999999",))
        done = self.run_program("rebuild", "--store", "station", "--scan", "S-999999")
        self.assertEqual(done.returncode, 1)
        self.assertIn("S-999999", done.stderr)

    def test_wrong_usage(self):
        for arguments in (("store",), ("store", "list"), ("store", "forget", "--store", "station"),
                          ("store", "users", "promote", "admin", "--store", "station"), ("rebuild",)):
            with self.subTest(arguments):
                self.assertEqual(self.run_program(*arguments).returncode, 2)


class Interrupted(StoreTest):
    KILLS = 4 if SLOW_BUILD else 12

    def seconds_of(self, *arguments):
        start = time.monotonic()
        self.succeeds(*arguments)
        return time.monotonic() - start

    def is_killed(self, seed, whole, *arguments):
        """Runs the program and kills it at a random time within `whole` seconds; False if it had ended before."""
        process = subprocess.Popen([self.program, *arguments], cwd=self.folder, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            process.wait(timeout=random.Random(seed).uniform(0.0, whole))
        except subprocess.TimeoutExpired:
            process.kill()
        return process.wait() == -signal.SIGKILL

    def again(self):
        """The store as it was."""
        shutil.rmtree(self.path("station"))
        shutil.copytree(StoreTest.template + "/station", self.path("station"))

    def test_a_backup_that_was_killed_leaves_nothing_for_good(self):
        arguments = ("store", "backup", "--store", "station", "--out", self.path("usb"))
        whole = self.seconds_of(*arguments)
        killed = 0
        for seed in range(self.KILLS):
            killed += self.is_killed(seed, whole, *arguments)
            made = self.on_store_json("backup", "--out", self.path("usb"))
            self.assertEqual([name for name in os.listdir(self.path("usb")) if name.endswith(".part")], [])
            for name in os.listdir(self.path("usb")):
                if name.endswith("-keys"):
                    self.assertTrue(os.path.isdir(self.path("usb/" + name[:-len("-keys")])), f"{name}: keys of nothing")
            self.is_sound()
        self.assertGreater(killed, 0)
        self.succeeds("store", "restore", made["backup"], "--store", "again", "--key-file", "station/station.key")

    def test_an_erasure_that_was_killed_is_finished(self):
        arguments = ("store", "erase", self.first, "--yes", "--store", "station")
        whole = self.seconds_of(*arguments)
        self.again()
        killed = 0
        for seed in range(self.KILLS):
            killed += self.is_killed(seed, whole, *arguments)
            self.is_sound()
            left = [one["id"] for one in self.on_store_json("list")["customers"]]
            has_key = os.path.exists(self.path(f"station/keys/{self.first}"))
            self.assertEqual(self.first in left, has_key, "all of a customer, or nothing")
            proof = self.on_store_json("erase", self.first, "--yes")
            self.assertEqual((proof["key_destroyed"], proof["marker_hits"]), (True, 0))
            self.assertFalse(os.path.exists(self.path(f"station/keys/{self.first}")))
            self.is_sound()
            self.again()
        self.assertGreater(killed, 0)

    def test_a_restore_that_was_killed_can_be_repeated(self):
        made = self.on_store_json("backup", "--out", self.path("usb"))
        arguments = ("store", "restore", made["backup"], "--store", "again", "--key-file", "station/station.key")
        whole = self.seconds_of(*arguments)
        shutil.rmtree(self.path("again"))
        killed = 0
        for seed in range(self.KILLS):
            killed += self.is_killed(seed, whole, *arguments)
            if not os.path.exists(self.path("again")):
                self.succeeds(*arguments)
            self.assertFalse(os.path.exists(self.path("again.restoring")))
            answer = json.loads(self.succeeds("store", "verify", "--store", "again", "--key-file", "station/station.key",
                                              "--json", "-"))
            self.assertEqual((answer["sound"], answer["customers"]), (True, 2))
            shutil.rmtree(self.path("again"))
        self.assertGreater(killed, 0)


class NoRoom(StoreTest):
    def full_disk(self, size):
        os.mkdir(self.path("disk"))
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", self.path("disk")],
                                 capture_output=True, check=False)
        if mounted.returncode != 0:
            self.skipTest("mounting needs rights that this user has not")
        self.addCleanup(subprocess.run, ["umount", self.path("disk")], check=True)

    def test_a_backup_that_has_no_room_leaves_nothing(self):
        self.full_disk("256k")
        self.is_refused("backup", "--out", "disk", naming=("disk",))
        self.assertEqual(os.listdir(self.path("disk")), [])
        self.is_sound()
        lines = self.on_store_json("audit", "--limit", "1")["lines"]
        self.assertEqual(lines[0]["action"], "backup")
        self.assertNotEqual(lines[0]["result"], "ok")

    def test_a_restore_that_has_no_room_leaves_nothing(self):
        made = self.on_store_json("backup", "--out", self.path("usb"))
        self.full_disk("256k")
        done = self.run_program("store", "restore", made["backup"], "--store", "disk/again", "--key-file", "station/station.key")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertEqual(os.listdir(self.path("disk")), [])
        self.assertTrue(os.path.isdir(made["backup"]))

    def test_files_that_may_not_grow(self):
        """As a quota, for users who may not mount."""
        self.is_refused("backup", "--out", "usb", before=limit_file_size(4096))
        self.assertFalse(os.path.exists(self.path("usb")) and os.listdir(self.path("usb")))
        self.is_sound()


class LockedOrDamaged(StoreTest):
    def test_another_program_holds_the_database(self):
        """D8: what changes something waits 2 s and then says why; what only looks is answered."""
        holder = self.database()
        holder.execute("BEGIN IMMEDIATE")
        start = time.monotonic()
        self.is_refused("erase", self.first, "--yes", naming=("another program has held its lock for 2 s",))
        waited = time.monotonic() - start
        self.assertGreaterEqual(waited, 2.0)
        self.assertLess(waited, 30 * TIME_FACTOR)
        self.is_refused("backup", naming=("another program has held its lock for 2 s",))
        self.assertEqual(len(self.on_store_json("list")["customers"]), 2)
        holder.execute("ROLLBACK")
        holder.close()
        self.is_sound()
        self.assertEqual(self.on_store_json("erase", self.first, "--yes")["marker_hits"], 0)

    def damage_page_of(self, table):
        connection = sqlite3.connect(self.path("station/annulus.db"))
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        size, = connection.execute("PRAGMA page_size").fetchone()
        page, = connection.execute("SELECT rootpage FROM sqlite_schema WHERE name = ?", (table,)).fetchone()
        connection.close()
        with open(self.path("station/annulus.db"), "r+b") as f:
            f.seek((page - 1) * size)
            f.write(b"\xff" * size)

    def test_a_damaged_database_is_read_as_far_as_it_goes_and_never_written(self):
        """D9."""
        made = self.on_store_json("backup", "--out", self.path("usb"))
        self.damage_page_of("scans")
        done = self.store("verify")
        self.assertEqual(done.returncode, 1)
        self.assertIn("damaged", done.stdout)
        self.assertEqual(len(self.on_store_json("users")["users"]), 3)
        before = self.read("station/annulus.db")
        self.is_refused("erase", self.first, "--yes", naming=("it can only be read", "annulus store restore"))
        self.is_refused("users", "remove", "operator", naming=("it can only be read",))
        self.assertEqual(self.read("station/annulus.db"), before)
        self.succeeds("store", "restore", made["backup"], "--store", "again", "--key-file", "station/station.key")
        self.assertIn("all sound", self.succeeds("store", "verify", "--store", "again", "--key-file", "station/station.key"))


if __name__ == "__main__":
    annulus_cli.main()
