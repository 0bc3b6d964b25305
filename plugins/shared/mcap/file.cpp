// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/mcap/file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

#include "plugins/shared/compression/lz4_frame.hpp"
#include "plugins/shared/compression/zstd_frame.hpp"
#include "waymark/base/error.hpp"

namespace waymark::mcap {
namespace {

constexpr std::uint64_t kPrefix = sizeof(std::uint8_t) + sizeof(std::uint64_t);  // opcode and length
constexpr std::uint64_t kLargestChunk = std::uint64_t{1} << 28;
constexpr std::uint64_t kLargestRecord = std::uint64_t{1} << 26;  // of those that are read as a whole
constexpr std::uint64_t kLongRun = std::uint64_t{1} << 20;        // of messages that lie in no chunk
constexpr std::uint64_t kChunkHeader = 1 << 10;                   // longer than what is in front of a chunk's bytes
constexpr std::uint64_t kMessageHeader = 22;
constexpr std::size_t kPiece = std::size_t{1} << 20;

std::string printable(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c < ' ' || c > '~'; }, '.');
  return text;
}

bool is_magic(Bytes bytes) { return std::ranges::equal(bytes, kMagic); }

struct Prefix {
  Op op;
  std::uint64_t length;
};

Prefix prefix_of(Bytes bytes) {
  ros::WireReader in(bytes);
  const auto op = static_cast<Op>(in.value<std::uint8_t>());
  return {op, in.value<std::uint64_t>()};
}

}  // namespace

Time to_time(std::uint64_t nanoseconds) { return Time{Duration{static_cast<std::int64_t>(nanoseconds)}}; }

std::string read_chunk(Bytes chunk, const ChunkVisitor& visitor) {
  std::size_t offset = 0;
  try {
    while (offset < chunk.size()) {
      if (chunk.size() - offset < kPrefix) throw Unusable("ends early");
      const auto [op, length] = prefix_of(chunk.subspan(offset, kPrefix));
      if (length > chunk.size() - offset - kPrefix) throw Unusable("ends early");
      const Bytes content = chunk.subspan(offset + kPrefix, static_cast<std::size_t>(length));
      if (op == Op::message) {
        if (visitor.message) visitor.message({offset, parse_as<Message>(content)});
      } else if (op == Op::schema) {
        if (visitor.schema) visitor.schema(parse_as<Schema>(content));
      } else if (op == Op::channel) {
        if (visitor.channel) visitor.channel(parse_as<Channel>(content));
      }
      offset += kPrefix + static_cast<std::size_t>(length);
    }
  } catch (const Unusable& unusable) {
    return fmt::format("the record at {} of {} uncompressed bytes: {}", offset, chunk.size(), unusable.what());
  }
  return {};
}

McapFile::McapFile(const std::filesystem::path& file) : McapFile(std::make_unique<FileBytes>(file), file.string()) {}

McapFile::McapFile(std::unique_ptr<ByteSource> bytes, std::string name)
    : bytes_(std::move(bytes)), name_(std::move(name)) {
  const std::uint64_t magic = std::min<std::uint64_t>(bytes_->size(), std::size(kMagic));
  const std::vector<std::uint8_t> start = bytes_->read(0, static_cast<std::size_t>(magic));
  if (!is_magic(start)) {
    throw DataError(fmt::format(R"({}: begins with "{}", but an MCAP file begins with 0x89 and "MCAP0")", place(0),
                                printable({start.begin(), start.end()})));
  }
  walk();
  look_into_where_needed();
}

std::string McapFile::place(std::uint64_t offset) const { return fmt::format("{}:byte {}", name_, offset); }

/// Nothing where the file ends.
std::optional<RecordPlace> McapFile::record_at(std::uint64_t offset) {
  const std::uint64_t left = bytes_->size() - offset;
  if (left == 0) return std::nullopt;
  if (left < kPrefix) return RecordPlace{{}, offset, offset, left, false};
  const auto [op, length] = prefix_of(bytes_->read(offset, kPrefix));
  const std::uint64_t there = std::min(length, left - kPrefix);
  return RecordPlace{op, offset, offset + kPrefix, there, there == length};
}

void McapFile::walk() {
  std::uint64_t offset = std::size(kMagic);
  try {
    while (const auto record = record_at(offset)) {
      if (record->op == Op{}) throw Unusable("its kind is 0");
      if (record->whole || record->op == Op::chunk) take(*record);
      if (!record->whole) {
        broken_at_ = offset;
        broken_because_ = "the file ends early, within the record that begins here";
        return;
      }
      offset = record->content + record->length;
      if (record->op != Op::footer) continue;
      const std::uint64_t left = bytes_->size() - offset;
      if (left != std::size(kMagic) || !is_magic(bytes_->read(offset, std::size(kMagic)))) {
        broken_at_ = offset;
        broken_because_ = "behind the footer the file should end with 0x89 and \"MCAP0\"";
      }
      return;
    }
  } catch (const Unusable& unusable) {
    broken_at_ = offset;
    broken_because_ = fmt::format("here a record is expected, but: {}", unusable.what());
  }
}

std::vector<std::uint8_t> McapFile::content_of(const RecordPlace& place) {
  if (place.length > kLargestRecord) throw Unusable(fmt::format("it would have {} bytes", place.length));
  return bytes_->read(place.content, static_cast<std::size_t>(place.length));
}

void McapFile::take(const RecordPlace& place) {
  if (place.op != Op::message) after_loose_ = false;
  switch (place.op) {
    case Op::header:
      header_ = parse_as<Header>(content_of(place));
      break;
    case Op::schema:
      in_summary_ ? summary_schemas_.push_back(parse_as<Schema>(content_of(place)))
                  : take_schema(parse_as<Schema>(content_of(place)));
      break;
    case Op::channel:
      in_summary_ ? summary_channels_.push_back(parse_as<Channel>(content_of(place)))
                  : take_channel(parse_as<Channel>(content_of(place)));
      break;
    case Op::message:
      take_loose(place);
      break;
    case Op::chunk:
      take_chunk(place);
      break;
    case Op::message_index:
      take_index(content_of(place));
      break;
    case Op::attachment: {
      // The name stands in front of the data.
      const std::uint64_t front = std::min<std::uint64_t>(place.length, kLargestRecord >> 10);
      const std::vector<std::uint8_t> bytes = bytes_->read(place.content, static_cast<std::size_t>(front));
      ros::WireReader in(bytes);
      in.take(2 * sizeof(std::uint64_t));
      attachments_.emplace_back(in.text(), place);
      break;
    }
    case Op::metadata:
      metadata_.push_back(parse_as<Metadata>(content_of(place)));
      break;
    case Op::statistics:
      statistics_ = parse_as<Statistics>(content_of(place));
      break;
    case Op::data_end:
      in_summary_ = true;
      break;
    case Op::footer:
      take_summary(place);
      break;
    default:
      break;
  }
}

void McapFile::take_schema(const Schema& schema) {
  const auto [known, added] = schemas_.try_emplace(schema.id, schema);
  if (!added && known->second != schema)
    throw DataError(fmt::format("{}: the schema {} is defined twice, in different ways", name_, schema.id));
}

void McapFile::take_channel(const Channel& channel) {
  const auto [known, added] = channels_.try_emplace(channel.id, channel);
  if (!added && known->second != channel)
    throw DataError(fmt::format("{}: the channel {} is defined twice, in different ways", name_, channel.id));
}

void McapFile::take_chunk(const RecordPlace& place) {
  const std::uint64_t front = std::min(place.length, kChunkHeader);
  const std::vector<std::uint8_t> bytes = bytes_->read(place.content, static_cast<std::size_t>(front));
  StoredChunk stored;
  stored.offset = place.offset;
  ros::WireReader in(bytes);
  std::uint64_t claimed = 0;
  try {
    stored.first = to_time(in.value<std::uint64_t>());
    in.take(sizeof(std::uint64_t));  // the last message
    stored.size = in.value<std::uint64_t>();
    stored.crc = in.value<std::uint32_t>();
    stored.compression = in.text();
    claimed = in.value<std::uint64_t>();
  } catch (const Unusable&) {
    if (!place.whole) return;  // the file ends in front of the bytes
    throw;
  }
  if (!stored.compression.empty() && stored.compression != "lz4" && stored.compression != "zstd") {
    throw DataError(fmt::format(R"({}: the compression "{}" is not known; "", "lz4" or "zstd" is expected)",
                                this->place(place.offset), printable(stored.compression.substr(0, 40))));
  }
  stored.data = place.content + (front - in.left());
  const std::uint64_t there = place.length - (front - in.left());
  if (claimed > there && place.whole) throw Unusable("a chunk has more bytes than its record");
  stored.stored = std::min(claimed, there);
  stored.whole = stored.stored == claimed;
  if (std::max(stored.size, stored.stored) > kLargestChunk)
    throw Unusable(fmt::format("a chunk would have {} bytes", std::max(stored.size, stored.stored)));
  chunks_.push_back(std::move(stored));
}

/// Adds a message that lies in no chunk to the run before it.
void McapFile::take_loose(const RecordPlace& place) {
  if (place.length < kMessageHeader) throw Unusable("a message ends early");
  if (place.length > kLargestChunk) throw Unusable(fmt::format("a message would have {} bytes", place.length));
  const std::vector<std::uint8_t> bytes = bytes_->read(place.content, kMessageHeader);
  const auto message = parse_as<Message>(bytes);
  if (!after_loose_ || chunks_.back().stored >= kLongRun) {
    StoredChunk run;
    run.offset = run.data = place.offset;
    chunks_.push_back(std::move(run));
  }
  after_loose_ = true;
  StoredChunk& run = chunks_.back();
  run.first = std::min(run.first, to_time(message.log_time));
  ++run.count[message.channel_id];
  run.size = run.stored = place.content + place.length - run.offset;
}

void McapFile::take_index(Bytes content) {
  const auto index = parse_as<MessageIndex>(content);
  if (chunks_.empty() || index.entries.empty()) return;
  chunks_.back().count[index.channel_id] += index.entries.size();
}

bool McapFile::is_intact(const Footer& footer, const RecordPlace& place) {
  if (footer.summary_start < std::size(kMagic) || footer.summary_start > place.offset) return false;
  if (footer.summary_crc == 0) return true;
  const std::uint64_t end = place.content + 2 * sizeof(std::uint64_t);
  std::uint32_t crc = 0;
  for (std::uint64_t at = footer.summary_start; at < end; at += kPiece)
    crc = crc32(bytes_->read(at, static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, end - at))), crc);
  return crc == footer.summary_crc;
}

void McapFile::take_summary(const RecordPlace& footer) {
  if (!is_intact(parse_as<Footer>(content_of(footer)), footer)) return;
  for (const Schema& schema : summary_schemas_) take_schema(schema);
  for (const Channel& channel : summary_channels_) take_channel(channel);
}

void McapFile::look_into(StoredChunk& chunk) {
  const ChunkContent content = load(chunk);
  chunk.count.clear();
  chunk.first = Time::max();
  read_chunk(content.bytes, {[&](const StoredMessage& stored) {
                               chunk.first = std::min(chunk.first, to_time(stored.message.log_time));
                               ++chunk.count[stored.message.channel_id];
                             },
                             [this](const Schema& schema) { take_schema(schema); },
                             [this](const Channel& channel) { take_channel(channel); }});
}

void McapFile::look_into_where_needed() {
  for (StoredChunk& chunk : chunks_) {
    // Of the last chunk of a file that ends early, part of the index may be missing.
    const bool last = &chunk == &chunks_.back();
    const bool unknown =
        std::ranges::any_of(chunk.count, [this](const auto& entry) { return !channels_.contains(entry.first); });
    if (chunk.count.empty() || unknown || (last && !broken_because_.empty())) look_into(chunk);
  }
}

std::uint64_t McapFile::messages(std::uint16_t channel) const {
  std::uint64_t sum = 0;
  for (const StoredChunk& chunk : chunks_) {
    const auto found = chunk.count.find(channel);
    if (found != chunk.count.end()) sum += found->second;
  }
  return sum;
}

ChunkContent McapFile::load(const StoredChunk& chunk) {
  std::vector<std::uint8_t> stored = bytes_->read(chunk.data, static_cast<std::size_t>(chunk.stored));
  const auto size = static_cast<std::size_t>(chunk.size);
  compression::Decompressed result = chunk.compression == "lz4"    ? compression::decompress_lz4(stored, size)
                                     : chunk.compression == "zstd" ? compression::decompress_zstd(stored, size)
                                                                   : compression::Decompressed{std::move(stored), {}};
  ChunkContent content{std::move(result.bytes), std::move(result.problem)};
  if (content.problem.empty() && content.bytes.size() != size) {
    content.problem = fmt::format("{} uncompressed bytes, {} are expected", content.bytes.size(), size);
  } else if (content.problem.empty() && chunk.crc != 0 && crc32(content.bytes) != chunk.crc) {
    content = {{}, "its checksum is another one"};
  }
  if (content.bytes.size() > size) content.bytes.resize(size);
  return content;
}

std::vector<std::string> McapFile::attachment_names() const {
  std::vector<std::string> names;
  names.reserve(attachments_.size());
  for (const auto& [name, where] : attachments_) names.push_back(name);
  return names;
}

std::optional<std::vector<std::uint8_t>> McapFile::attachment(std::string_view name) {
  const auto found =
      std::ranges::find(attachments_, name, [](const auto& one) -> std::string_view { return one.first; });
  if (found == attachments_.end()) return std::nullopt;
  try {
    const std::vector<std::uint8_t> content = content_of(found->second);
    const auto attachment = parse_as<Attachment>(content);
    return std::vector<std::uint8_t>(attachment.data.begin(), attachment.data.end());
  } catch (const Unusable& unusable) {
    throw DataError(fmt::format("{}: the attachment \"{}\": {}", place(found->second.offset), name, unusable.what()));
  }
}

}  // namespace waymark::mcap
