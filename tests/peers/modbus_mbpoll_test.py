"""mbpoll against our simulated drive, over TCP on loopback and RTU on a pseudo-terminal: registers as documented."""

import re
import subprocess
import sys

PEER = sys.argv[1]


def poll(where, *options):
    """{register: value} as mbpoll reads, or its complaint."""
    run = subprocess.run(["mbpoll", "-0", "-1", "-o", "3", *where[0], *options, where[1], *where[2:]],
                         capture_output=True, text=True, timeout=60)
    values = {int(register): value.strip() for register, value in re.findall(r"^\[(\d+)\]:\s+(.*)$", run.stdout, re.M)}
    return values, run.stdout + run.stderr, run.returncode


def check(where):
    # docs/wire_protocol.md, identity: version 1, firmware 1.3, serial 4711, travel -60 to 2250 mm, 300 mm/s, 1500 mm/s^2.
    values, said, code = poll(where, "-a", "1", "-t", "4", "-r", str(0x0108), "-c", "2")
    assert code == 0 and values == {0x0108: "1", 0x0109: str(0x0103)}, said
    values, said, code = poll(where, "-a", "1", "-t", "4:int", "-B", "-r", str(0x010A), "-c", "5")
    assert code == 0, said
    assert [int(value) for value in values.values()] == [4711, -60_000, 2_250_000, 300_000, 1_500_000], said
    values, said, code = poll(where, "-a", "1", "-t", "4", "-r", str(0x0114), "-c", "2")
    assert code == 0 and values == {0x0114: "200", 0x0115: "25"}, said
    # Status word: switch on disabled, voltage, remote, target reached.
    values, said, code = poll(where, "-a", "1", "-t", "4:hex", "-r", str(0x0101), "-c", "1")
    assert code == 0 and int(values[0x0101], 16) == 0x0650, said
    # A register that is written (FC06, FC16) reads back; the counter has its echo.
    for number in ("4660", "17"):
        _, said, code = poll([*where, number], "-a", "1", "-t", "4", "-r", "0")
        assert code == 0, said
        values, said, code = poll(where, "-a", "1", "-t", "4", "-r", str(0x0100), "-c", "1")
        assert code == 0 and values == {0x0100: number}, said
    _, said, code = poll([*where, "1", "2", "3", "4"], "-a", "1", "-t", "4", "-r", "3")
    assert code == 0, said
    values, said, code = poll(where, "-a", "1", "-t", "4", "-r", "3", "-c", "4")
    assert code == 0 and list(values.values()) == ["1", "2", "3", "4"], said
    # No such register; functions of input registers and coils are not there.
    for options, refused in ((("-t", "4", "-r", str(0x0118)), "Illegal data address"),
                             (("-t", "3", "-r", "0"), "Illegal function"), (("-t", "0", "-r", "0"), "Illegal function")):
        _, said, _ = poll(where, "-a", "1", *options)
        assert refused in said, (options, said)


for transport in ("tcp", "rtu"):
    with subprocess.Popen([PEER, "serve", transport], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server:
        name = server.stdout.readline().strip()
        try:
            if transport == "tcp":
                check((["-m", "tcp", "-p", name], "127.0.0.1"))
            else:
                check((["-m", "rtu", "-b", "115200", "-P", "none"], name))
        finally:
            server.stdin.close()
            server.wait(60)
print("mbpoll: registers as documented over TCP and RTU")
