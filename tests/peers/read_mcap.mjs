// Reads an MCAP file with the format's official packages. As a program: node read_mcap.mjs FILE prints the counts as JSON.
import { open, readFile } from "node:fs/promises";
import { pathToFileURL } from "node:url";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { FileHandleReadable } from "@mcap/nodejs";
import { loadDecompressHandlers } from "@mcap/support";

const text = new TextDecoder();

/// Through the index at the end of the file, as a viewer does: CRCs of chunks are checked.
export async function readIndexed(path) {
  const handle = await open(path, "r");
  try {
    const reader = await McapIndexedReader.Initialize({
      readable: new FileHandleReadable(handle),
      decompressHandlers: await loadDecompressHandlers(),
    });
    const messages = [];
    for await (const message of reader.readMessages({ validateCrcs: true })) {
      const topic = reader.channelsById.get(message.channelId).topic;
      const { sequence, logTime, data } = message;
      messages.push({ topic, sequence, logTime, data: text.decode(data), bytes: Buffer.from(data) });
    }
    const metadata = [];
    for await (const record of reader.readMetadata()) metadata.push(record);
    return {
      messages,
      metadata,
      statistics: reader.statistics,
      channels: [...reader.channelsById.values()],
      schemas: [...reader.schemasById.values()].map((s) => ({ ...s, data: text.decode(s.data) })),
    };
  } finally {
    await handle.close();
  }
}

/// From front to back, as after a crash: no index, no footer needed.
export async function readStream(path) {
  const reader = new McapStreamReader({
    validateCrcs: true,
    decompressHandlers: await loadDecompressHandlers(),
  });
  reader.append(await readFile(path));
  const records = [];
  for (let record = reader.nextRecord(); record; record = reader.nextRecord()) records.push(record);
  return { records, done: reader.done() };
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const { messages, metadata, statistics, channels, schemas } = await readIndexed(process.argv[2]);
  const counts = {
    messages: messages.length,
    statistics_messages: Number(statistics.messageCount),
    chunks: statistics.chunkCount,
    schemas: schemas.map((schema) => schema.name),
    metadata: metadata.map((record) => record.name),
    topics: Object.fromEntries(
      channels.map((c) => [c.topic, messages.filter((message) => message.topic === c.topic).length]),
    ),
  };
  process.stdout.write(JSON.stringify(counts, null, 2) + "\n");
}
