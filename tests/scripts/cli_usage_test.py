#!/usr/bin/python3
"""Help, exit codes of wrong usage, and the commands that do not exist yet."""

import annulus_cli
from annulus_cli import ProgramTest

COMMANDS = ("demo", "scan", "replay", "import", "export", "inspect", "recover", "fit", "eval", "measure", "section", "slab", "region", "landmarks", "distance",
            "compare", "glasses", "render", "doctor", "sim-devices", "boothd", "breath", "calibrate", "serve", "clay", "elastic", "flatten", "wrinkly")
NOT_YET = ("convert", "batch", "support-bundle")


class Usage(ProgramTest):
    def wrong_usage(self, *arguments):
        done = self.run_program(*arguments)
        self.assertEqual(done.returncode, 2, f"{arguments}: {done.stderr}")
        self.assertTrue(done.stderr.startswith("annulus: "), f"{arguments}: {done.stderr!r}")
        self.assertEqual(done.stdout, "")
        self.assertEqual(self.listing(), {})
        return done.stderr

    def test_the_help_lists_every_command(self):
        text = self.succeeds("--help")
        for command in (*COMMANDS, *NOT_YET):
            self.assertIn(command, text)

    def test_the_help_of_every_command_has_an_example(self):
        for command in COMMANDS:
            with self.subTest(command):
                text = self.succeeds(command, "--help")
                self.assertIn("example", text.lower())
                self.assertIn(f"annulus {command} ", text)

    def test_the_help_of_the_glasses_steps_has_an_example(self):
        for step in ("design", "fit", "export"):
            with self.subTest(step):
                self.assertIn(f"annulus glasses {step}", self.succeeds("glasses", step, "--help"))

    def test_the_version_is_told(self):
        self.assertRegex(self.succeeds("--version"), r"\d+\.\d+")

    def test_no_command_is_wrong_usage(self):
        self.wrong_usage()

    def test_an_unknown_command_is_wrong_usage(self):
        self.assertIn("frobnicate", self.wrong_usage("frobnicate"))

    def test_an_unknown_option_of_every_command_is_wrong_usage(self):
        for command in COMMANDS:
            with self.subTest(command):
                self.wrong_usage(command, "--frobnicate")

    def test_a_missing_required_option_is_wrong_usage(self):
        for arguments in (("import", "a.csv"), ("fit", "a.mcap"), ("section", "m.json"), ("render", "m.json", "--out", "p.png"),
                          ("slab", "m.json", "--z-min", "1"), ("eval", "m.json"), ("export", "a.mcap")):
            with self.subTest(arguments):
                self.wrong_usage(*arguments)

    def test_values_that_are_no_numbers_are_wrong_usage(self):
        for arguments in (("section", "m.json", "--z", "high"), ("demo", "--seed", "x"), ("demo", "--subject", "cat"),
                          ("render", "m.json", "--view", "front", "--size", "-3", "--out", "p.png"),
                          ("fit", "a.mcap", "--out", "m.json", "--method", "guess")):
            with self.subTest(arguments):
                self.wrong_usage(*arguments)

    def test_commands_that_do_not_exist_yet_say_so(self):
        """Those that later issues add leave this list by working; a command that works is tested elsewhere."""
        for command in ((name,) for name in NOT_YET):
            with self.subTest(command):
                done = self.run_program(*command)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn("not yet", done.stderr)


if __name__ == "__main__":
    annulus_cli.main()
