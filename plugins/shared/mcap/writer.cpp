// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/mcap/writer.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "plugins/shared/compression/lz4_frame.hpp"
#include "plugins/shared/compression/zstd_frame.hpp"

namespace waymark::mcap {

Writer::Writer(WriterOptions options) : options_(std::move(options)) {
  out_.assign(std::begin(kMagic), std::end(kMagic));
  put(Header{options_.profile, options_.library});
}

void Writer::put(const Record& record) { append(out_, record); }

void Writer::put_in_chunk(const Record& record) {
  if (!options_.chunks) return put(record);
  append(chunk_, record);
}

void Writer::add(const Schema& schema) {
  put_in_chunk(schema);
  schemas_.push_back(schema);
  ++statistics_.schema_count;
}

void Writer::add(const Channel& channel) {
  put_in_chunk(channel);
  channels_.push_back(channel);
  ++statistics_.channel_count;
}

void Writer::add(const Message& message) {
  const std::uint64_t time = message.log_time;
  if (options_.chunks) {
    chunk_start_ = index_.empty() ? time : std::min(chunk_start_, time);
    chunk_end_ = index_.empty() ? time : std::max(chunk_end_, time);
    MessageIndex& index = index_[message.channel_id];
    index.channel_id = message.channel_id;
    index.entries.emplace_back(time, chunk_.size());
  }
  put_in_chunk(message);
  const bool first = statistics_.message_count++ == 0;
  statistics_.message_start_time = first ? time : std::min(statistics_.message_start_time, time);
  statistics_.message_end_time = first ? time : std::max(statistics_.message_end_time, time);
  ++counts_[message.channel_id];
  if (chunk_.size() >= options_.chunk_size) finish_chunk();
}

void Writer::add(const Attachment& attachment) {
  const std::uint64_t start = offset();
  put(attachment);
  attachments_.push_back({start, offset() - start, attachment.log_time, attachment.create_time, attachment.data.size(),
                          attachment.name, attachment.media_type});
  ++statistics_.attachment_count;
}

void Writer::add(const Metadata& metadata) {
  const std::uint64_t start = offset();
  put(metadata);
  metadata_.push_back({start, offset() - start, metadata.name});
  ++statistics_.metadata_count;
}

void Writer::finish_chunk() {
  if (chunk_.empty()) return;
  using Compression = WriterOptions::Compression;
  std::vector<std::uint8_t> compressed;
  Chunk chunk{chunk_start_, chunk_end_, chunk_.size(), crc32(chunk_), "", chunk_};
  if (options_.compression == Compression::lz4) {
    chunk.compression = "lz4";
    chunk.records = compressed = compression::compress_lz4(chunk_);
  } else if (options_.compression == Compression::zstd) {
    chunk.compression = "zstd";
    chunk.records = compressed = compression::compress_zstd(chunk_, options_.zstd_level);
  }
  ChunkIndex entry{chunk.message_start_time, chunk.message_end_time, offset(), 0, {}, 0, chunk.compression,
                   chunk.records.size(),     chunk.uncompressed_size};
  put(chunk);
  const std::uint64_t indices = offset();
  entry.chunk_length = indices - entry.chunk_start_offset;
  if (options_.message_index) {
    for (const auto& [channel, index] : index_) {
      entry.message_index_offsets.emplace_back(channel, offset());
      put(index);
    }
  }
  entry.message_index_length = offset() - indices;
  chunks_.push_back(std::move(entry));
  ++statistics_.chunk_count;
  chunk_.clear();
  index_.clear();
  chunk_start_ = chunk_end_ = 0;
}

void Writer::put_summary() {
  const std::uint64_t start = offset();
  std::vector<SummaryOffset> groups;
  const auto group = [&](bool wanted, Op op, const auto& records) {
    const std::uint64_t group_start = offset();
    if (!wanted || records.empty()) return;
    for (const auto& record : records) put(record);
    groups.push_back({op, group_start, offset() - group_start});
  };
  statistics_.channel_message_counts.assign(counts_.begin(), counts_.end());
  group(options_.repeat_schemas, Op::schema, schemas_);
  group(options_.repeat_channels, Op::channel, channels_);
  group(options_.statistics, Op::statistics, std::vector{statistics_});
  group(options_.chunk_index, Op::chunk_index, chunks_);
  group(options_.attachment_index, Op::attachment_index, attachments_);
  group(options_.metadata_index, Op::metadata_index, metadata_);

  Footer footer;
  if (offset() != start) footer.summary_start = start;
  if (options_.summary_offsets && !groups.empty()) {
    footer.summary_offset_start = offset();
    for (const SummaryOffset& one : groups) put(one);
  }
  const std::size_t summary = static_cast<std::size_t>(start - taken_);
  put(footer);
  // The checksum covers all of the summary and the footer but itself, which comes last.
  const std::size_t crc_at = out_.size() - sizeof footer.summary_crc;
  const std::uint32_t crc = crc32(Bytes(out_).subspan(summary, crc_at - summary));
  for (std::size_t i = 0; i < sizeof crc; ++i) out_[crc_at + i] = static_cast<std::uint8_t>(crc >> (8 * i));
}

void Writer::finish() {
  finish_chunk();
  data_crc_ = crc32(Bytes(out_).subspan(checked_), data_crc_);
  put(DataEnd{data_crc_});
  put_summary();
  out_.insert(out_.end(), std::begin(kMagic), std::end(kMagic));
  checked_ = out_.size();
}

std::vector<std::uint8_t> Writer::take() {
  data_crc_ = crc32(Bytes(out_).subspan(checked_), data_crc_);
  taken_ += out_.size();
  checked_ = 0;
  return std::exchange(out_, {});
}

}  // namespace waymark::mcap
