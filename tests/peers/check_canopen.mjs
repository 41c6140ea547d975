// node check_canopen.mjs CAN_BOARD_PEER: a CANopen master that nobody here wrote talks to a simulated ring board.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { createRequire } from "node:module";

const require = createRequire(import.meta.url);
// node-crc is a native addon that only block transfers need; nothing here may run its build, so it is left out.
require.cache[require.resolve("node-crc")] = {
  exports: { crc: () => assert.fail("no block transfer here") },
};
const { Device, DataType, NmtState } = require("canopen");

const kNode = 5;
const kRecordBytes = 16;

const boards = spawn(process.argv[2], [], { stdio: ["pipe", "pipe", "inherit"] });
const master = new Device({ id: 0x7e });
const seen = []; // every frame of the boards
master.addListener("message", ({ id, data }) => {
  const record = Buffer.alloc(kRecordBytes);
  record.writeUInt32LE(id, 0);
  record.writeUInt8(data.length, 4);
  Buffer.from(data).copy(record, 8);
  boards.stdin.write(record);
});
let rest = Buffer.alloc(0);
boards.stdout.on("data", (chunk) => {
  rest = Buffer.concat([rest, chunk]);
  for (; rest.length >= kRecordBytes; rest = rest.subarray(kRecordBytes)) {
    const length = rest.readUInt8(4);
    const message = { id: rest.readUInt32LE(0), data: Buffer.from(rest.subarray(8, 8 + length)), len: length };
    seen.push(message);
    master.receive(message);
  }
});

async function until(what, condition) {
  const end = Date.now() + 20000;
  while (!condition()) {
    assert.ok(Date.now() < end, `nothing for 20 s: ${what}`);
    await new Promise((done) => setTimeout(done, 10));
  }
}
const upload = (index, subIndex, dataType) =>
  master.sdo.upload({ serverId: kNode, index, subIndex, dataType, timeout: 5000 });
const download = (index, subIndex, data, dataType) =>
  master.sdo.download({ serverId: kNode, index, subIndex, data, dataType, timeout: 5000 });
const refusal = async (transfer) => {
  try {
    await transfer;
  } catch (error) {
    return error.code;
  }
  return "not refused";
};

master.eds.addSdoClientParameter(kNode, 0x600 + kNode, 0x580 + kNode);
master.eds.addHeartbeatConsumer(kNode, 5000);
master.eds.addEmcyConsumer(0x80 + kNode);
const states = [];
master.nmt.addListener("heartbeat", ({ deviceId, state }) => states.push([deviceId, state]));
const emergencies = [];
master.emcy.addListener("emergency", ({ em }) => emergencies.push(em));
master.start();

try {
  await until("boot-up of all boards", () => new Set(seen.map(({ id }) => id)).size === 12);
  assert.deepEqual([...new Set(seen.map(({ id }) => id))].sort((a, b) => a - b), [...Array(12).keys()].map((i) => 0x701 + i));

  // Expedited and segmented uploads.
  assert.equal(await upload(0x1018, 4, DataType.UNSIGNED32), 1005);
  assert.equal(await upload(0x1018, 2, DataType.UNSIGNED32), 0xa180);
  assert.equal(await upload(0x1008, 0, DataType.VISIBLE_STRING), "annulus ring board");
  assert.equal(await upload(0x100a, 0, DataType.VISIBLE_STRING), "1.2.0");
  assert.equal(await upload(0x2001, 0, DataType.UNSIGNED16), 60);
  assert.equal(await upload(0x2002, 0, DataType.UNSIGNED8), 15);
  assert.equal(await upload(0x1800, 1, DataType.UNSIGNED32), 0x180 + kNode);
  const first = await upload(0x2004, 1, DataType.UNSIGNED32);
  const second = await upload(0x2004, 2, DataType.UNSIGNED32);
  assert.ok(((second - first) >>> 0) < 10e6, "the clock runs in microseconds");

  // Refusals carry the standard's abort codes.
  assert.equal(await refusal(upload(0x6000, 0, DataType.UNSIGNED32)), 0x06020000);
  assert.equal(await refusal(upload(0x1018, 9, DataType.UNSIGNED32)), 0x06090011);
  assert.equal(await refusal(download(0x1018, 4, 7, DataType.UNSIGNED32)), 0x06010002);
  assert.equal(await refusal(download(0x1017, 0, 7, DataType.UNSIGNED32)), 0x06070010);
  assert.equal(await refusal(download(0x1019, 0, 241, DataType.UNSIGNED8)), 0x06090030);

  // Heartbeat, NMT, and SYNC with its counter.
  await download(0x1017, 0, 50, DataType.UNSIGNED16);
  assert.equal(await upload(0x1017, 0, DataType.UNSIGNED16), 50);
  await until("pre-operational", () => states.some(([id, state]) => id === kNode && state === NmtState.PRE_OPERATIONAL));
  await download(0x1019, 0, 240, DataType.UNSIGNED8);
  await download(0x1006, 0, 33333, DataType.UNSIGNED32);
  await download(0x2006, 0, 1, DataType.UNSIGNED8);
  master.nmt.startNode(kNode);
  await until("operational", () => states.some(([id, state]) => id === kNode && state === NmtState.OPERATIONAL));
  await download(0x1005, 0, 0x40000080, DataType.UNSIGNED32);
  const syncs = () => seen.filter(({ id }) => id === 0x80).map(({ data }) => data[0]);
  await until("thirty levels", () => syncs().length > 30);
  assert.deepEqual(syncs().slice(0, 30), [...Array(30).keys()].map((i) => i + 1));
  // Each SYNC makes one level: six PDOs of eight bytes, of this node only.
  for (const base of [0x180, 0x200, 0x280, 0x300, 0x380, 0x480]) {
    const pdos = seen.filter(({ id }) => id === base + kNode);
    assert.ok(Math.abs(pdos.length - syncs().length) <= 1, `${pdos.length} PDOs at ${base.toString(16)}`);
    assert.ok(pdos.every(({ len }) => len === 8));
  }
  // The cylinder: 450 mm in steps of 0.04 mm, below the bit of the sequence.
  const ranges = seen.filter(({ id }) => id === 0x180 + kNode).map(({ data }) => data.readUInt16LE(0) & 0x7fff);
  assert.ok(ranges.every((range) => range === 11250));
  await download(0x1005, 0, 0x80, DataType.UNSIGNED32);

  // Another node under its id: the board says so, with its serial number.
  const boot = Buffer.alloc(kRecordBytes);
  boot.writeUInt32LE(0x700 + kNode, 0);
  boot.writeUInt8(1, 4);
  boards.stdin.write(boot);
  await until("the emergency", () => emergencies.length > 0);
  assert.equal(emergencies[0].code, 0x8150);
  assert.equal(emergencies[0].info.readUInt32LE(0), 1005);
  console.log(`canopen: ${seen.length} frames, all as the standard has them`);
} finally {
  master.stop();
  boards.stdin.end();
}
