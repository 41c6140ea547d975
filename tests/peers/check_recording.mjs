// node check_recording.mjs WRITER FOLDER: lets our writer write recordings, reads them with the official packages, and
// compares with what the writer printed (its numbers come from printf, not from the recording's code).
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
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
assert.deepEqual(channels.map((channel) => channel.topic).sort(), ["/axis/track", "/events", "/ring/levels"]);
for (const channel of channels) {
  assert.equal(channel.messageEncoding, "json");
  const schema = schemas.find((candidate) => candidate.id === channel.schemaId);
  assert.equal(schema.encoding, "jsonschema");
  const { properties, required } = JSON.parse(schema.data);
  for (const message of dataOf(channel.topic)) {
    assert.deepEqual(Object.keys(message).sort(), Object.keys(properties).sort());
    assert.deepEqual([...required].sort(), Object.keys(properties).sort());
  }
}

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
assert.equal(statistics.chunkCount, messages.length);
assert.equal(statistics.metadataCount, metadata.length);
assert.equal(statistics.schemaCount, 3);

// Front to back: the whole file, and one that was never finished.
const whole = await readStream(expected.finished);
assert.equal(whole.done, true);
assert.equal(whole.records.filter((record) => record.type === "Message").length, messages.length);
const torn = await readStream(expected.unfinished);
assert.equal(torn.done, false);
assert.equal(torn.records.filter((record) => record.type === "Message").length, expected.levels.length);

process.stdout.write(`${messages.length} messages in ${statistics.chunkCount} chunks read by @mcap/core\n`);
