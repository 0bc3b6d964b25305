// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "plugins/shared/mcap/byte_source.hpp"
#include "plugins/shared/mcap/records.hpp"
#include "waymark/base/time.hpp"

namespace waymark::mcap {

/// Where a record lies.
struct RecordPlace {
  Op op{};
  std::uint64_t offset = 0;   ///< of the record
  std::uint64_t content = 0;  ///< of what is behind its length
  std::uint64_t length = 0;   ///< of the content; of a record that the file ends in: what there is of it
  bool whole = true;
};

/// A chunk, or messages that lie in no chunk.
struct StoredChunk {
  std::uint64_t offset = 0;  ///< of its record in the file, or of the first message
  std::uint64_t data = 0;    ///< of its compressed bytes
  std::uint64_t stored = 0;  ///< how many of them there are
  std::uint64_t size = 0;    ///< uncompressed
  std::uint32_t crc = 0;     ///< of the uncompressed bytes; 0: unknown
  std::string compression;
  bool whole = true;                             ///< false: the file ends within it
  Time first = Time::max();                      ///< of the recording of its messages
  std::map<std::uint16_t, std::uint64_t> count;  ///< messages of each channel; empty: unknown
};

/// A chunk in memory.
struct ChunkContent {
  std::vector<std::uint8_t> bytes;
  std::string problem;  ///< why bytes are missing at the end; empty: none are
};

/// A message of a chunk.
struct StoredMessage {
  std::uint64_t offset = 0;  ///< of its record in the chunk
  Message message;           ///< its data point into the chunk
};

/// What `read_chunk` passes on; each may be empty.
struct ChunkVisitor {
  std::function<void(const StoredMessage&)> message;
  std::function<void(const Schema&)> schema;
  std::function<void(const Channel&)> channel;
};

/// Goes through the uncompressed bytes of a chunk. Returns why it stopped before the end, or an empty text.
std::string read_chunk(Bytes chunk, const ChunkVisitor& visitor);

/// Time of a record, of its 64 bits: those before 1970, which a flight record may have, come back as they were.
Time to_time(std::uint64_t nanoseconds);

/// An MCAP file. Its records are walked through once, without reading the chunks, so that a file that was never closed
/// is as good as any other; a chunk without an index is looked into.
class McapFile {
 public:
  /// `name` is for messages. Throws DataError ("file:byte n: …") if the bytes cannot be read or are not an MCAP file.
  McapFile(std::unique_ptr<ByteSource> bytes, std::string name);
  explicit McapFile(const std::filesystem::path& file);

  const Header& header() const { return header_; }
  const std::map<std::uint16_t, Schema>& schemas() const { return schemas_; }
  const std::map<std::uint16_t, Channel>& channels() const { return channels_; }
  const std::vector<StoredChunk>& chunks() const { return chunks_; }  ///< in the order of the file
  const std::vector<Metadata>& metadata() const { return metadata_; }
  const std::optional<Statistics>& statistics() const { return statistics_; }
  /// Names of the attachments, in the order of the file.
  std::vector<std::string> attachment_names() const;
  /// The content of the first attachment of this name; nothing if there is none. Throws DataError if it is damaged.
  std::optional<std::vector<std::uint8_t>> attachment(std::string_view name);

  /// Where and why the walk stopped before the end of the file; an empty reason: it did not.
  std::uint64_t broken_at() const { return broken_at_; }
  const std::string& broken_because() const { return broken_because_; }

  std::uint64_t messages(std::uint16_t channel) const;
  /// Reads and decompresses a chunk. Throws DataError if the file cannot be read.
  ChunkContent load(const StoredChunk& chunk);
  /// "file:byte n".
  std::string place(std::uint64_t offset) const;

 private:
  void walk();
  std::optional<RecordPlace> record_at(std::uint64_t offset);
  void take(const RecordPlace& place);
  void take_chunk(const RecordPlace& place);
  void take_loose(const RecordPlace& place);
  void take_index(Bytes content);
  void take_schema(const Schema& schema);
  void take_channel(const Channel& channel);
  void take_summary(const RecordPlace& footer);
  bool is_intact(const Footer& footer, const RecordPlace& place);
  void look_into(StoredChunk& chunk);
  void look_into_where_needed();
  std::vector<std::uint8_t> content_of(const RecordPlace& place);

  std::unique_ptr<ByteSource> bytes_;
  std::string name_;
  Header header_;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  std::vector<StoredChunk> chunks_;
  std::vector<std::pair<std::string, RecordPlace>> attachments_;
  std::vector<Metadata> metadata_;
  std::optional<Statistics> statistics_;
  bool in_summary_ = false;  // of which schemas and channels count only once its checksum was seen to be right
  std::vector<Schema> summary_schemas_;
  std::vector<Channel> summary_channels_;
  bool after_loose_ = false;  // the last chunk is of messages in no chunk, and may grow
  std::uint64_t broken_at_ = 0;
  std::string broken_because_;
};

}  // namespace waymark::mcap
