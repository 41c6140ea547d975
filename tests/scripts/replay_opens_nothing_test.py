#!/usr/bin/python3
"""R1: a replay never constructs an axis, and opens no bus: its code does not even link what would."""

import pathlib
import subprocess
import sys
import unittest

PARTS = ("acquisition/CMakeFiles/acquisition.dir/replay.cpp.o", "acquisition/CMakeFiles/acquisition.dir/replay_compare.cpp.o",
         "acquisition/CMakeFiles/acquisition.dir/recorded_buses.cpp.o",
         "acquisition/CMakeFiles/acquisition.dir/level_pipeline.cpp.o", "sim/CMakeFiles/sim.dir/replay_faults.cpp.o",
         "station/CMakeFiles/station.dir/replay_job.cpp.o", "station/CMakeFiles/station.dir/command_replay.cpp.o")
# Everything by which a device, real or simulated, comes to be.
OPENERS = ("MakeModbusScanAxis", "OpenModbusRtu", "OpenModbusTcp", "AdoptModbusDescriptor", "OpenLibusbHost",
           "OpenSocketCan", "OpenGpioLines", "MakeInterlock", "OpenAxis", "OpenRing", "BoothDevices", "BoothSession",
           "AxisDriveModel", "DriveDialogue")
build = None


class ReplayOpensNothing(unittest.TestCase):
    def undefined(self, part):
        path = pathlib.Path(build) / part
        listed = subprocess.run(["nm", "-C", "--undefined-only", path], check=True, capture_output=True, text=True)
        return listed.stdout

    def test_no_part_of_it_links_what_opens_a_device(self):
        for part in PARTS:
            symbols = self.undefined(part)
            self.assertIn("annulus::", symbols, part)  # nm does see what it links
            for opener in OPENERS:
                self.assertNotIn("annulus::" + opener, symbols, part)
                self.assertNotIn("annulus::sim::" + opener, symbols, part)

    def test_the_ring_is_linked(self):
        self.assertIn("annulus::MakeUsbRangeRing", self.undefined(PARTS[0]))


if __name__ == "__main__":
    build = sys.argv.pop(1)
    unittest.main()
