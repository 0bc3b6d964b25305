// SPDX-License-Identifier: Apache-2.0
// read_mcap.mjs FILE: reads an MCAP file with @mcap/core, by its index and as a stream with all checksums, and decodes every ROS 2
// message by its own definition. Prints one line of JSON: counts by topic, attachments, and the last message of each topic.
import { open, readFile } from "node:fs/promises";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";

const path = process.argv[2];
const decompressHandlers = await loadDecompressHandlers();

const handle = await open(path);
const readable = {
  size: async () => BigInt((await handle.stat()).size),
  read: async (offset, size) => {
    const buffer = new Uint8Array(Number(size));
    await handle.read(buffer, 0, buffer.length, Number(offset));
    return buffer;
  },
};
const indexed = await McapIndexedReader.Initialize({ readable, decompressHandlers });
const readers = new Map();
for (const [id, schema] of indexed.schemasById) {
  if (schema.encoding !== "ros2msg") continue;
  readers.set(id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
}
const topics = {};
const last = {};
for await (const message of indexed.readMessages()) {
  const channel = indexed.channelsById.get(message.channelId);
  topics[channel.topic] = (topics[channel.topic] ?? 0) + 1;
  const reader = readers.get(channel.schemaId);
  if (channel.messageEncoding === "cdr") last[channel.topic] = reader.readMessage(message.data);
}
const attachments = [];
for await (const attachment of indexed.readAttachments()) attachments.push(attachment.name);
await handle.close();

const stream = new McapStreamReader({ validateCrcs: true, decompressHandlers });
stream.append(await readFile(path));
const streamed = {};
const channels = new Map();
for (let record = stream.nextRecord(); record; record = stream.nextRecord()) {
  if (record.type === "Channel") channels.set(record.id, record.topic);
  if (record.type !== "Message") continue;
  const topic = channels.get(record.channelId);
  streamed[topic] = (streamed[topic] ?? 0) + 1;
}
if (!stream.done()) throw new Error("the stream does not end with the closing magic");

const plain = (_, value) => {
  if (typeof value === "bigint") return value.toString();
  return ArrayBuffer.isView(value) ? Array.from(value).slice(0, 8) : value;
};
console.log(JSON.stringify({ topics, streamed, attachments, last }, plain));
