// node check_recording.mjs WRITER FOLDER: lets our writer write recordings, reads them with the official packages, and
// compares with what the writer printed (its numbers come from printf, not from the recording's code).
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import Ajv from "ajv";
import foxglove from "@foxglove/schemas/jsonschema.js";
import { readIndexed, readStream } from "./read_mcap.mjs";

const [writer, folder] = process.argv.slice(2);
const expected = JSON.parse(execFileSync(writer, [folder], { encoding: "utf8" }));
const { messages, metadata, statistics, channels, schemas } = await readIndexed(expected.finished);

// Every number of every level, to the last bit.
const levels = messages.filter((message) => message.topic === "/ring/levels");
assert.deepEqual(levels.map((message) => message.sequence), expected.levels.map((_, i) => i));
assert.deepEqual(levels.map((message) => JSON.parse(message.data)), expected.levels);
assert.deepEqual(levels.map((message) => Number(message.logTime)), expected.levels.map((level) => level.time_ns));

const dataOf = (topic) => messages.filter((m) => m.topic === topic).map((m) => JSON.parse(m.data));
assert.deepEqual(dataOf("/axis/track"), expected.axis);
assert.deepEqual(dataOf("/events"), expected.events);

// Channels and their schemas.
const raw = ["/bus/calls", "/bus/can", "/bus/modbus", "/bus/usb"];
const described = ["/axis/track", "/events", "/points", "/ring/levels", "/safety/lines"];
assert.deepEqual(channels.map((channel) => channel.topic).sort(), [...raw, ...described].sort());
for (const channel of channels.filter(({ topic }) => described.includes(topic))) {
  assert.equal(channel.messageEncoding, "json");
  const schema = schemas.find((candidate) => candidate.id === channel.schemaId);
  assert.equal(schema.encoding, "jsonschema");
  const { properties, required } = JSON.parse(schema.data);
  for (const message of dataOf(channel.topic)) {
    assert.deepEqual(Object.keys(message).sort(), Object.keys(properties).sort());
    assert.deepEqual([...required].sort(), Object.keys(properties).sort());
  }
}

// Raw bytes: no schema, an encoding of our own.
for (const channel of channels.filter(({ topic }) => raw.includes(topic))) {
  assert.equal(channel.messageEncoding, "annulus.bus");
  assert.equal(channel.schemaId, 0);
}
const passed = messages.filter(({ topic }) => raw.includes(topic)).map(({ topic, logTime, bytes }) => [topic, Number(logTime), bytes.toString("hex")]);
assert.deepEqual(passed, [["/bus/usb", 8, "f0f0"], ["/bus/can", 9, "f1f1"], ["/bus/modbus", 10, "f2f2"], ["/bus/calls", 11, "f3f3"]]);
const lines = (length, set) => Array.from({ length }, (_, i) => i === set);
assert.deepEqual(dataOf("/safety/lines"), [{ time_ns: 7, input: lines(12, 1), output: lines(7, 2) }]);

// Points as Foxglove's own schema has them, one per return that lies before the axis; where they lie follows from the header.
const isPointCloud = new Ajv({ strict: false }).compile(foxglove.PointCloud);
const clouds = messages.filter(({ topic }) => topic === "/points").map(({ data }) => JSON.parse(data));
const { calibration } = JSON.parse(metadata.find(({ name }) => name === "annulus.scan").metadata.get("json"));
assert.equal(clouds.length, expected.levels.length);
clouds.forEach((cloud, index) => {
  assert.ok(isPointCloud(cloud), JSON.stringify(isPointCloud.errors));
  const level = expected.levels[index];
  assert.equal(1e9 * cloud.timestamp.sec + cloud.timestamp.nsec, level.time_ns);
  const data = Buffer.from(cloud.data, "base64");
  const seen = level.range_mm.flatMap((range, sensor) => (range === null ? [] : [sensor]));
  assert.equal(data.length, cloud.point_stride * seen.length);
  const offset = Object.fromEntries(cloud.fields.map((field) => [field.name, field.offset]));
  seen.forEach((sensor, point) => {
    const number = (name) => data.readFloatLE(point * cloud.point_stride + offset[name]);
    const beam = level.range_mm[sensor] * calibration.range_scale[sensor] + calibration.range_offset_mm[sensor];
    // Aims are within 5 mrad: the distance from the axis is R - beam within 1 - cos 5 mrad, and sin² of it at the side.
    assert.ok(Math.abs(1e3 * Math.hypot(number("x"), number("y")) - (calibration.radius_mm[sensor] - beam)) < 0.05);
    const z = level.z_mm[sensor] + calibration.height_mm[sensor] + beam * Math.sin(calibration.aim_vertical_rad[sensor]);
    assert.ok(Math.abs(1e3 * number("z") - z) < 0.01);
    assert.equal(number("intensity"), level.quality[sensor]);
  });
});

// The header stands twice and its hash is right; the end says count and hash.
const headers = metadata.filter((record) => record.name === "annulus.scan").map((record) => record.metadata);
assert.equal(headers.length, 2);
for (const header of headers) {
  const json = header.get("json");
  assert.equal(createHash("sha256").update(json).digest("hex"), header.get("sha256"));
  assert.equal(JSON.parse(json).calibration.theta_rad.length, expected.levels[0].range_mm.length);
}
const end = metadata.find((record) => record.name === "annulus.end").metadata;
assert.equal(end.get("levels"), String(expected.levels.length));
assert.equal(end.get("scan_hash"), expected.scan_hash);

// The statistics agree with the content.
assert.equal(Number(statistics.messageCount), messages.length);
assert.equal(statistics.chunkCount, expected.levels.length);  // what came before a level goes with it
assert.equal(statistics.metadataCount, metadata.length);
assert.equal(statistics.schemaCount, described.length);

// Front to back: the whole file, and one that was never finished.
const whole = await readStream(expected.finished);
assert.equal(whole.done, true);
assert.equal(whole.records.filter((record) => record.type === "Message").length, messages.length);
const torn = await readStream(expected.unfinished);
assert.equal(torn.done, false);
assert.equal(torn.records.filter((record) => record.type === "Message").length, 2 * expected.levels.length);

process.stdout.write(`${messages.length} messages in ${statistics.chunkCount} chunks read by @mcap/core\n`);
