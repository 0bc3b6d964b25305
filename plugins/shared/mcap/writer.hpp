// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "plugins/shared/mcap/records.hpp"

namespace waymark::mcap {

/// What a file contains beside the messages. The default is what readers make the most of.
struct WriterOptions {
  enum class Compression { none, lz4, zstd };

  std::string profile, library;
  bool chunks = true;  ///< messages lie in chunks, which can be compressed
  Compression compression = Compression::zstd;
  int zstd_level = 1;
  std::size_t chunk_size = std::size_t{1} << 20;  ///< a chunk of more bytes is finished
  bool message_index = true;
  bool repeat_schemas = true;
  bool repeat_channels = true;
  bool statistics = true;
  bool chunk_index = true;
  bool attachment_index = true;
  bool metadata_index = true;
  bool summary_offsets = true;
};

/// Writes an MCAP file into memory, piece by piece.
class Writer {
 public:
  /// Begins the file.
  explicit Writer(WriterOptions options);

  /// The caller numbers schemas and channels, and adds each before what refers to it.
  void add(const Schema& schema);
  void add(const Channel& channel);
  void add(const Message& message);
  void add(const Attachment& attachment);
  void add(const Metadata& metadata);

  /// Ends the current chunk, so that `take` gives all messages that were added.
  void finish_chunk();
  /// Ends the file. Nothing may be added then.
  void finish();

  /// The bytes since the last call, which are to be appended to the file.
  std::vector<std::uint8_t> take();

 private:
  void put(const Record& record);
  void put_in_chunk(const Record& record);
  void put_summary();
  std::uint64_t offset() const { return taken_ + out_.size(); }

  WriterOptions options_;
  std::vector<std::uint8_t> out_;
  std::uint64_t taken_ = 0;
  std::size_t checked_ = 0;  // of `out_`: bytes that are in the checksum
  std::uint32_t data_crc_ = 0;

  std::vector<std::uint8_t> chunk_;
  std::map<std::uint16_t, MessageIndex> index_;  // of the chunk
  std::uint64_t chunk_start_ = 0;
  std::uint64_t chunk_end_ = 0;

  std::vector<Schema> schemas_;
  std::vector<Channel> channels_;
  std::vector<ChunkIndex> chunks_;
  std::vector<AttachmentIndex> attachments_;
  std::vector<MetadataIndex> metadata_;
  Statistics statistics_;
  std::map<std::uint16_t, std::uint64_t> counts_;
};

}  // namespace waymark::mcap
