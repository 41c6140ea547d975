#!/usr/bin/python3
"""check_can.py WRITE_CAN_CAPTURE FOLDER: tshark dissects our frames as CANopen, with the right node, function and fields.

What each frame must be is worked out here from CiA 301 and docs/wire_protocol.md, not taken from the program.
"""

import collections
import os
import struct
import subprocess
import sys

FIELDS = """can.id can.len canopen.function_code canopen.node_id canopen.nmt_ctrl.cd canopen.nmt_ctrl.node_id canopen.sync.counter
canopen.em.err_code canopen.em.err_field canopen.nmt_guard.state canopen.sdo.ccs canopen.sdo.scs canopen.sdo.main_idx
canopen.sdo.sub_idx canopen.sdo.data.bytes _ws.malformed""".split()

# The frames at the end of the capture: fields that tshark must find in them.
# (tshark shows the two bytes of 1017h with the two that carry nothing.)
KNOWN = [
    {"can.id": 0x000, "canopen.nmt_ctrl.cd": 0x01, "canopen.nmt_ctrl.node_id": 5},
    {"can.id": 0x000, "canopen.nmt_ctrl.cd": 0x82, "canopen.nmt_ctrl.node_id": 0},
    {"can.id": 0x080, "canopen.sync.counter": 17},
    {"can.id": 0x089, "canopen.node_id": 9, "canopen.em.err_code": 0x8150, "canopen.em.err_field": "f103000000"},
    {"can.id": 0x70C, "canopen.node_id": 12, "canopen.nmt_guard.state": 0x00},
    {"can.id": 0x70C, "canopen.node_id": 12, "canopen.nmt_guard.state": 0x05},
    {"can.id": 0x607, "canopen.node_id": 7, "canopen.sdo.ccs": 2, "canopen.sdo.main_idx": 0x2004, "canopen.sdo.sub_idx": 3},
    {"can.id": 0x607, "canopen.node_id": 7, "canopen.sdo.ccs": 1, "canopen.sdo.main_idx": 0x1017, "canopen.sdo.data.bytes": "64000000"},
    {"can.id": 0x587, "canopen.node_id": 7, "canopen.sdo.scs": 2, "canopen.sdo.main_idx": 0x2004, "canopen.sdo.sub_idx": 3,
     "canopen.sdo.data.bytes": "11223344"},
] + [{"can.id": base + 3, "canopen.node_id": 3, "can.len": 8} for base in (0x180, 0x200, 0x280, 0x300, 0x380, 0x480)]


def dissect(capture):
    command = ["tshark", "-n", "-r", capture, "-d", "can.subdissector,canopen", "-T", "fields", "-E", "separator=/t"]
    command += ["-E", "occurrence=f"] + [word for field in FIELDS for word in ("-e", field)]
    output = subprocess.run(command, check=True, capture_output=True, text=True, timeout=100).stdout
    return [dict(zip(FIELDS, line.split("\t"))) for line in output.splitlines()]


def number(text):
    return int(text, 0)


def same(found, expected):
    if isinstance(expected, str):
        return found.replace(":", "") == expected
    return found != "" and number(found) == expected


def recorded_ids(capture):
    """Identifiers and lengths as they stand in the file, by this script's own reading of it."""
    with open(capture, "rb") as file:
        data = file.read()
    assert struct.unpack_from("<IHHIIII", data)[6] == 227, "link type"
    at = 24
    while at < len(data):
        length = struct.unpack_from("<I", data, at + 8)[0]
        yield struct.unpack_from(">I", data, at + 16)[0], data[at + 20]
        at += 16 + length


def main(arguments):
    writer, folder = arguments[1:]
    os.makedirs(folder, exist_ok=True)
    capture = os.path.join(folder, "ring.pcap")
    subprocess.run([writer, capture], check=True, timeout=60)
    packets = dissect(capture)
    records = list(recorded_ids(capture))
    assert len(packets) == len(records), f"{len(packets)} dissected of {len(records)} frames"
    kinds = collections.Counter()
    for packet, (can_id, length) in zip(packets, records):
        assert number(packet["can.id"]) == can_id and number(packet["can.len"]) == length, packet
        assert packet["_ws.malformed"] == "", packet
        # CiA 301: the upper four bits of an identifier are the function, the lower seven the node.
        assert number(packet["canopen.function_code"]) == can_id >> 7, packet
        assert number(packet["canopen.node_id"]) == can_id & 0x7F, packet
        assert can_id & 0x7F <= 12, packet
        kinds[can_id & 0x780] += 1
    # Ten levels were taken; an eleventh may be under way.
    for base in (0x180, 0x200, 0x280, 0x300, 0x380, 0x480):
        assert 120 <= kinds[base] <= 133, f"{kinds[base]} frames at {base:03X}"
    for packet, expected in zip(packets[-len(KNOWN):], KNOWN):
        for field, value in expected.items():
            assert same(packet[field], value), f"{field} is {packet[field]!r} instead of {value!r}: {packet}"
    print(f"tshark: {len(packets)} frames dissected as CANopen, {len(KNOWN)} of known content field by field")


if __name__ == "__main__":
    main(sys.argv)
