#!/usr/bin/python3
"""annulus sim-devices: another process finds the simulated drive on TCP and on a pseudo-terminal, as a real one."""

import json
import os
import signal
import subprocess

import annulus_cli
from annulus_cli import ProgramTest


class SimDevices(ProgramTest):
    def serve(self, *arguments):
        """The running program, once its devices are served, and its endpoints by transport."""
        process = subprocess.Popen(
            [self.program, "sim-devices", "--json", "-", *map(str, arguments)], cwd=self.folder,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.end, process)
        text = ""
        while True:
            line = process.stdout.readline()
            self.assertTrue(line, f"ended early: {process.poll()}")
            text += line
            try:
                document = json.loads(text)
                break
            except json.JSONDecodeError:
                continue
        return process, {e["transport"]: e for e in document["endpoints"]}

    def end(self, process):
        if process.poll() is None:
            process.kill()
        process.wait()
        process.stdout.close()
        process.stderr.close()

    def axis_items(self, toml, status=0):
        self.write("booth.toml", toml)
        done = self.run_program("doctor", "--config", "booth.toml", "--json", "report.json")
        self.assertEqual(done.returncode, status, done.stderr)
        items = [i for i in self.read_json("report.json")["items"] if i["group"] == "axis"]
        return {i["name"]: i for i in items}

    def check_drive(self, toml):
        items = self.axis_items(toml)
        self.assertEqual(items["drive"]["verdict"], "ok")
        self.assertIn("serial 4711", items["drive"]["seen"])
        self.assertIn("-60.0 to 2250.0 mm", items["limits"]["seen"])
        self.assertIn("not homed", items["position"]["seen"])

    def test_the_doctor_finds_the_drive_on_tcp_again_and_again(self):
        _, endpoints = self.serve("--tcp", 0)
        self.assertEqual(list(endpoints), ["modbus-tcp"])
        for _ in range(3):
            self.check_drive(f'[axis]\nlink = "{endpoints["modbus-tcp"]["address"]}"\n')

    def test_the_doctor_finds_the_drive_on_a_terminal_of_a_chosen_name(self):
        link = self.path("drive")
        process, endpoints = self.serve("--pty", link)
        self.assertEqual(endpoints["modbus-rtu"]["address"], link)
        self.check_drive(f'[axis]\nlink = "{link}"\nparity = "none"\n')
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(timeout=30), 0)
        self.assertFalse(os.path.lexists(link), "the name is gone with the program")

    def test_without_an_option_both_are_served_and_a_killed_one_is_a_problem(self):
        process, endpoints = self.serve()
        self.assertEqual(set(endpoints), {"modbus-tcp", "modbus-rtu"})
        toml = f'[axis]\nlink = "{endpoints["modbus-tcp"]["address"]}"\n'
        self.check_drive(toml)
        process.kill()
        process.wait()
        self.assertEqual(self.axis_items(toml, status=1)["drive"]["verdict"], "problem")

    def test_a_port_that_is_taken_and_an_interface_that_is_not_there_are_named(self):
        _, endpoints = self.serve("--tcp", 0)
        port = endpoints["modbus-tcp"]["address"].rsplit(":", 1)[1]
        self.fails("sim-devices", "--tcp", port, naming=["in use"])
        self.fails("sim-devices", "--can", "can77", naming=["can77"])


if __name__ == "__main__":
    annulus_cli.main()
