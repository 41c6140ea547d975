"""A drive whose process is stopped while an order to move is on its way does not move when it goes on (fault matrix, M7).

Stopped for longer than the heartbeat, and for less: then only the start window stands between the order and the motor.
"""

import re
import subprocess
import sys

PEER = sys.argv[1]


def attempt(transport, milliseconds):
    """(what the master says, motions and late starts in the drive's log)"""
    with subprocess.Popen([PEER, "serve", transport], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server:
        name = server.stdout.readline().strip()
        try:
            master = subprocess.run([PEER, "freeze", transport, name, str(server.pid), str(milliseconds)],
                                    capture_output=True, text=True, timeout=60)
        finally:
            server.stdin.close()
        log = server.stdout.read()
        server.wait(60)
    motions, late = re.search(r"motions (\d+), late starts (\d+)", log).groups()
    return master.stdout.strip() or master.stderr.strip(), int(motions), int(late)


for transport in ("tcp", "rtu"):
    for milliseconds in (80, 1000):
        for chance in range(5):  # a busy host may break the heartbeat before the order is given
            said, motions, late = attempt(transport, milliseconds)
            if said.startswith("moved"):
                break
        print(f"{transport}, {milliseconds} ms: {said}; motions {motions}, late starts {late}")
        assert said == "moved 0, stopped 0, travelled 0.000", said
        assert motions == 1  # homing
print("frozen drive: no motion by an order that failed")
