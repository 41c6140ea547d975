"""Our Modbus master against python3-pymodbus's server, over TCP on loopback and RTU on a pair of pseudo-terminals."""

import asyncio
import logging
import os
import subprocess
import sys
import threading
import tty
import warnings

warnings.filterwarnings("ignore")
from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext  # noqa: E402
from pymodbus.framer.rtu_framer import ModbusRtuFramer  # noqa: E402
from pymodbus.server.async_io import ModbusSerialServer, ModbusTcpServer  # noqa: E402

logging.disable(logging.CRITICAL)  # it reports the exceptions that we ask for, and its own end, as errors
PEER = sys.argv[1]
EXPECTED = [
    "fc03 1010 1011 1012 1013 1014",
    "fc06",
    "fc16",
    "fc23 1039 7 8 1042",
    "beyond exception 2, no such register",
    "after 1 2 65535",
]


def context():
    """256 holding registers; register n holds 1000 + n."""
    block = ModbusSequentialDataBlock(0, [1000 + n for n in range(256)])
    return ModbusServerContext(slaves=ModbusSlaveContext(hr=block, zero_mode=True), single=True)


async def ask(transport, where):
    peer = await asyncio.create_subprocess_exec(PEER, "ask", transport, where, stdout=subprocess.PIPE)
    out, _ = await asyncio.wait_for(peer.communicate(), 60)
    assert peer.returncode == 0, (transport, peer.returncode)
    return out.decode().splitlines()


def check(transport, lines, data):
    assert lines == EXPECTED, (transport, lines)
    registers = data[0].getValues(3, 0, 256)
    changed = {n: value for n, value in enumerate(registers) if value != 1000 + n}
    assert changed == {20: 0xABCD, 30: 1, 31: 2, 32: 0xFFFF, 40: 7, 41: 8}, (transport, changed)


async def over_tcp():
    data = context()
    server = ModbusTcpServer(data, address=("127.0.0.1", 0))
    task = asyncio.create_task(server.serve_forever())
    await asyncio.wait_for(server.serving, 30)
    port = server.server.sockets[0].getsockname()[1]
    check("tcp", await ask("tcp", str(port)), data)
    task.cancel()


def copy(source, target):
    try:
        while chunk := os.read(source, 512):
            os.write(target, chunk)
    except OSError:
        pass


async def over_rtu():
    ours, our_end = os.openpty()
    theirs, their_end = os.openpty()
    for end in (our_end, their_end):
        tty.setraw(end)
    for pair in ((ours, theirs), (theirs, ours)):
        threading.Thread(target=copy, args=pair, daemon=True).start()
    data = context()
    server = ModbusSerialServer(data, framer=ModbusRtuFramer, port=os.ttyname(their_end), baudrate=115200, parity="N")
    await server.start()
    check("rtu", await ask("rtu", os.ttyname(our_end)), data)
    await server.shutdown()


async def main():
    await over_tcp()
    await over_rtu()
    print("pymodbus: registers agree over TCP and RTU")


asyncio.run(main())
sys.stdout.flush()
os._exit(0)  # the copying threads wait for ever
