// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "plugins/shared/cdr/wire_reader.hpp"

/// MCAP, a container for messages with times: https://mcap.dev/spec. Little endian.
namespace waymark::mcap {

using ros::Bytes;
using ros::Unusable;

/// At the start and at the end of a file.
inline constexpr std::uint8_t kMagic[] = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

enum class Op : std::uint8_t {
  header = 1,
  footer,
  schema,
  channel,
  message,
  chunk,
  message_index,
  chunk_index,
  attachment,
  attachment_index,
  statistics,
  metadata,
  metadata_index,
  summary_offset,
  data_end
};

using TextMap = std::vector<std::pair<std::string, std::string>>;  ///< in the order of the file

struct Header {
  std::string profile, library;
  bool operator==(const Header&) const = default;
};

/// Offsets count from the start of the file; 0: there is no such section. CRC 0: not computed.
struct Footer {
  std::uint64_t summary_start = 0;
  std::uint64_t summary_offset_start = 0;
  std::uint32_t summary_crc = 0;
  bool operator==(const Footer&) const = default;
};

struct Schema {
  std::uint16_t id = 0;  ///< not 0
  std::string name, encoding;
  std::vector<std::uint8_t> data;
  bool operator==(const Schema&) const = default;
};

struct Channel {
  std::uint16_t id = 0;
  std::uint16_t schema_id = 0;  ///< 0: none
  std::string topic, message_encoding;
  TextMap metadata;
  bool operator==(const Channel&) const = default;
};

/// Times are nanoseconds.
struct Message {
  std::uint16_t channel_id = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0;
  std::uint64_t publish_time = 0;
  Bytes data;  ///< owned by others
};

struct Chunk {
  std::uint64_t message_start_time = 0;
  std::uint64_t message_end_time = 0;
  std::uint64_t uncompressed_size = 0;
  std::uint32_t uncompressed_crc = 0;
  std::string compression;  ///< "", "lz4", "zstd"
  Bytes records;            ///< owned by others
};

struct MessageIndex {
  std::uint16_t channel_id = 0;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> entries;  ///< time, offset in the uncompressed chunk
  bool operator==(const MessageIndex&) const = default;
};

struct ChunkIndex {
  std::uint64_t message_start_time = 0;
  std::uint64_t message_end_time = 0;
  std::uint64_t chunk_start_offset = 0;
  std::uint64_t chunk_length = 0;
  std::vector<std::pair<std::uint16_t, std::uint64_t>> message_index_offsets;  ///< by channel
  std::uint64_t message_index_length = 0;
  std::string compression;
  std::uint64_t compressed_size = 0;
  std::uint64_t uncompressed_size = 0;
  bool operator==(const ChunkIndex&) const = default;
};

struct Attachment {
  std::uint64_t log_time = 0;
  std::uint64_t create_time = 0;
  std::string name, media_type;
  Bytes data;             ///< owned by others
  std::uint32_t crc = 0;  ///< of the fields before; set by `append`
};

struct AttachmentIndex {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  std::uint64_t log_time = 0;
  std::uint64_t create_time = 0;
  std::uint64_t data_size = 0;
  std::string name, media_type;
  bool operator==(const AttachmentIndex&) const = default;
};

struct Statistics {
  std::uint64_t message_count = 0;
  std::uint16_t schema_count = 0;
  std::uint32_t channel_count = 0;
  std::uint32_t attachment_count = 0;
  std::uint32_t metadata_count = 0;
  std::uint32_t chunk_count = 0;
  std::uint64_t message_start_time = 0;
  std::uint64_t message_end_time = 0;
  std::vector<std::pair<std::uint16_t, std::uint64_t>> channel_message_counts;
  bool operator==(const Statistics&) const = default;
};

struct Metadata {
  std::string name;
  TextMap metadata;
  bool operator==(const Metadata&) const = default;
};

struct MetadataIndex {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  std::string name;
  bool operator==(const MetadataIndex&) const = default;
};

struct SummaryOffset {
  Op group_opcode{};
  std::uint64_t group_start = 0;
  std::uint64_t group_length = 0;
  bool operator==(const SummaryOffset&) const = default;
};

struct DataEnd {
  std::uint32_t data_section_crc = 0;
  bool operator==(const DataEnd&) const = default;
};

/// In the order of `Op`.
using Record = std::variant<Header, Footer, Schema, Channel, Message, Chunk, MessageIndex, ChunkIndex, Attachment,
                            AttachmentIndex, Statistics, Metadata, MetadataIndex, SummaryOffset, DataEnd>;

/// CRC-32 of zlib, continued from `crc`.
std::uint32_t crc32(Bytes bytes, std::uint32_t crc = 0);

/// Appends a whole record: opcode, length, content.
void append(std::vector<std::uint8_t>& out, const Record& record);

/// Reads the content of a record; bytes behind what is known of it are skipped. Data point into `content`. Throws
/// Unusable for an opcode that is not known, and for content that ends early.
Record parse(Op op, Bytes content);

/// Reads one of a known type.
template <class R>
R parse_as(Bytes content);

}  // namespace waymark::mcap
