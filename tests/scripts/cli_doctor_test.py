#!/usr/bin/python3
"""annulus doctor: everything simulated, nothing connected, and devices that are not as configured."""

import socket

import annulus_cli
from annulus_cli import ProgramTest


class Doctor(ProgramTest):
    def report(self, toml, status):
        """The report on a configuration; the exit code is 0 exactly if it is healthy."""
        self.write("booth.toml", toml)
        done = self.run_program("doctor", "--config", "booth.toml", "--json", "report.json")
        self.assertEqual(done.returncode, status, done.stderr)
        report = self.read_json("report.json")
        self.assertEqual(report["healthy"], status == 0)
        for item in report["items"]:
            self.assertIn(item["verdict"], ("ok", "none", "problem"))
            self.assertTrue(item["seen"], item)
            self.assertEqual(bool(item["advice"]), item["verdict"] == "problem", item)
        return report

    def problems(self, toml):
        """The problems' texts by "group name"."""
        items = self.report(toml, 1)["items"]
        return {f"{i['group']} {i['name']}": f"{i['seen']}: {i['advice']}" for i in items if i["verdict"] == "problem"}

    def test_the_simulated_booth_is_healthy_with_nothing_connected(self):
        report = self.report("", 0)
        boards = [i for i in report["items"] if i["group"] == "ring" and i["name"].startswith("board ")]
        self.assertEqual([b["name"] for b in boards], [f"board {serial}" for serial in range(1001, 1013)])
        for k, board in enumerate(boards):
            self.assertIn(f"sensors {15 * k}-{15 * k + 14}", board["seen"])
            self.assertIn("firmware 1.2.0", board["seen"])
        groups = {i["group"] for i in report["items"]}
        self.assertEqual(groups, {"host", "buses", "ring", "axis", "interlock"})
        chain = next(i for i in report["items"] if i["group"] == "interlock" and i["name"] == "chain")
        self.assertEqual(chain["seen"], "closed")
        for group in ("ring", "axis", "interlock"):
            self.assertIn(("simulated", "none"),
                          [(i["name"], i["verdict"]) for i in report["items"] if i["group"] == group])
        state = next(i for i in report["items"] if i["name"] == "state")
        self.assertEqual(state["seen"], "at rest, without power")

    def test_an_open_chain_and_channels_that_disagree_are_problems(self):
        problems = self.problems('[interlock]\nchip = "sim"\nestop_a = { line = "estop_a", active_low = true }\n')
        self.assertIn("interlock chain", problems)
        items = self.read_json("report.json")["items"]
        texts = [i["seen"] for i in items if i["group"] == "interlock" and i["verdict"] == "problem"]
        self.assertTrue(any("open at estop_a" in t for t in texts), texts)
        self.assertTrue(len(texts) >= 2, f"the disagreement is named too: {texts}")
        problems = self.problems('[interlock]\nchip = "sim"\ndoor = { line = "door", active_low = true }\n')
        self.assertIn("open at door", problems["interlock chain"])

    def test_the_watchdog_relay_is_measured_when_asked_for(self):
        report = self.succeeds_json("doctor", "--test-watchdog")
        relay = next(i for i in report["items"] if i["name"] == "watchdog relay")
        self.assertEqual(relay["verdict"], "ok")
        drop_ms = int(relay["seen"].split()[1])
        # The relay's window of 200 ms and its drop-out of 15 ms, less at most one beat of 20 ms since the last edge.
        self.assertTrue(150 <= drop_ms <= 250, relay)

    def test_the_report_is_text_without_json(self):
        text = self.succeeds("doctor")
        for words in ("host", "buses", "ring", "axis", "interlock", "no problem found (simulated: ring, axis, interlock)", "board 1012"):
            self.assertIn(words, text)

    def test_boards_that_are_not_those_of_the_configuration_are_a_problem(self):
        problems = self.problems("[ring]\nboards = { 1001 = 15, 1002 = 0 }\n")
        self.assertIn("ring ring", problems)

    def test_a_ring_on_can_that_is_not_there_is_a_problem_that_says_what_to_do(self):
        problems = self.problems('[ring]\nbus = "can"\ncan = ["can7"]\n')
        self.assertIn("buses CAN can7", problems)
        self.assertIn("ring ring", problems)

    def test_a_ring_on_usb_that_is_not_there_is_a_problem(self):
        problems = self.problems('[ring]\nbus = "usb"\n')
        self.assertIn("buses USB", problems)
        self.assertIn("ring ring", problems)

    def test_a_drive_that_does_not_listen_is_a_problem(self):
        with socket.socket() as unused:
            unused.bind(("127.0.0.1", 0))
            port = unused.getsockname()[1]
            problems = self.problems(f'[axis]\nlink = "tcp:127.0.0.1:{port}"\n')
        self.assertEqual(list(problems), ["axis drive"])

    def test_a_serial_port_that_is_not_there_is_a_problem(self):
        problems = self.problems('[axis]\nlink = "/dev/serial/by-id/usb-nobody"\n')
        self.assertIn("/dev/serial/by-id/usb-nobody", problems["buses serial"])
        self.assertIn("axis drive", problems)

    def test_an_interlock_without_its_chip_is_a_problem(self):
        problems = self.problems('[interlock]\nchip = "booth-io"\n')
        self.assertIn("interlock lines", problems)

    def test_a_wrong_order_of_words_is_found_before_anything_moves(self):
        problems = self.problems('[axis.register_map]\nword_order = "low_first"\n')
        self.assertIn("check word_order and units_per", problems["axis drive"])

    def test_bad_links_and_lines_are_named_with_their_line(self):
        for toml, naming in (
            ('[axis]\nlink = "tcp:host"\n', ["line 2", "axis.link"]),
            ('[axis]\nlink = "tcp:127.0.0.1:99999"\n', ["line 2", "axis.link"]),
            ('[axis]\nlink = "tcp:localhost:502"\n', ["line 2", "address in digits"]),
            ('[axis]\nlink = "/dev/tty0"\nbaud = 12345\n', ["line 3", "axis.baud"]),
            ('[axis]\nlink = "/dev/tty0"\nunit = 0\n', ["axis.unit"]),
            ("[ring]\ncan = []\n", ["line 2", "at least one"]),
            ('[ring]\ncan = ["can0", "can0"]\n', ["line 2", "without repetition"]),
            ('[axis]\nlink = "ttyUSB0"\n', ["line 2", "axis.link"]),
            ('[axis]\nlink = "/dev/tty0"\nparity = "maybe"\n', ["axis.parity"]),
            ("[axis]\nunit = 300\n", ["line 2", "axis.unit"]),
            ('[interlock]\nestop_c = "X"\n', ["line 2", "estop_c"]),
            ('[interlock]\nestop_a = { line = "X", bias = "up" }\n', ["line 2", "bias"]),
            ('[ring]\ncan = "can0"\n', ["line 2", "ring.can"]),
        ):
            with self.subTest(toml):
                self.write("booth.toml", toml)
                self.fails("doctor", "--config", "booth.toml", naming=naming)


if __name__ == "__main__":
    annulus_cli.main()
