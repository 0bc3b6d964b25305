// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/mcap/records.hpp"

#include <zlib.h>

#include <cstring>
#include <limits>
#include <stdexcept>
#include <string_view>
#include <type_traits>

namespace waymark::mcap {
namespace {

using ros::WireReader;

constexpr std::size_t kAttachmentCrc = sizeof(std::uint32_t);

/// Appends to the bytes.
class Out {
 public:
  explicit Out(std::vector<std::uint8_t>& bytes) : bytes_(&bytes) {}

  template <class T>
  requires std::is_integral_v<T>
  void operator()(T number) { raw({reinterpret_cast<const std::uint8_t*>(&number), sizeof number}); }
  void operator()(Op op) { (*this)(static_cast<std::uint8_t>(op)); }
  void operator()(std::string_view text) { counted({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}); }
  void operator()(const std::string& text) { (*this)(std::string_view(text)); }
  void operator()(const std::vector<std::uint8_t>& bytes) { counted(bytes); }
  template <class A, class B>
  void operator()(const std::vector<std::pair<A, B>>& pairs) {
    const std::size_t start = bytes_->size();
    (*this)(std::uint32_t{0});
    for (const auto& [first, second] : pairs) {
      (*this)(first);
      (*this)(second);
    }
    const auto size = length(bytes_->size() - start - sizeof(std::uint32_t));
    std::memcpy(bytes_->data() + start, &size, sizeof size);
  }
  void raw(Bytes bytes) { bytes_->insert(bytes_->end(), bytes.begin(), bytes.end()); }

 private:
  static std::uint32_t length(std::size_t size) {
    if (size > std::numeric_limits<std::uint32_t>::max()) throw std::length_error("a field is too long for MCAP");
    return static_cast<std::uint32_t>(size);
  }
  void counted(Bytes bytes) {
    (*this)(length(bytes.size()));
    raw(bytes);
  }

  std::vector<std::uint8_t>* bytes_;
};

/// Reads from the content of a record.
class In {
 public:
  explicit In(Bytes bytes) : in_(bytes) {}

  template <class T>
  requires std::is_integral_v<T>
  void operator()(T& number) { number = in_.value<T>(); }
  void operator()(Op& op) { op = static_cast<Op>(in_.value<std::uint8_t>()); }
  void operator()(std::string& text) { text = in_.text(); }
  void operator()(std::vector<std::uint8_t>& bytes) {
    const Bytes counted = in_.counted();
    bytes.assign(counted.begin(), counted.end());
  }
  template <class A, class B>
  void operator()(std::vector<std::pair<A, B>>& pairs) {
    In in(in_.counted());
    while (in.in_.left() > 0) {
      auto& [first, second] = pairs.emplace_back();
      in(first);
      in(second);
    }
  }
  /// Bytes behind a count of 64 bits.
  void long_bytes(Bytes& bytes) {
    const auto size = in_.value<std::uint64_t>();
    if (size > in_.left()) throw Unusable("ends early");
    bytes = in_.take(static_cast<std::size_t>(size));
  }
  void rest(Bytes& bytes) { bytes = in_.take(in_.left()); }
  std::size_t left() const { return in_.left(); }

 private:
  WireReader in_;
};

/// The fields of each record in their order, for reading and writing.
template <class Self, class Visitor>
void visit(Self& r, Visitor&& field) {
  using R = std::remove_const_t<Self>;
  const auto all = [&](auto&... fields) { (field(fields), ...); };
  if constexpr (std::is_same_v<R, Header>) {
    all(r.profile, r.library);
  } else if constexpr (std::is_same_v<R, Footer>) {
    all(r.summary_start, r.summary_offset_start, r.summary_crc);
  } else if constexpr (std::is_same_v<R, Schema>) {
    all(r.id, r.name, r.encoding, r.data);
  } else if constexpr (std::is_same_v<R, Channel>) {
    all(r.id, r.schema_id, r.topic, r.message_encoding, r.metadata);
  } else if constexpr (std::is_same_v<R, Message>) {
    all(r.channel_id, r.sequence, r.log_time, r.publish_time);
  } else if constexpr (std::is_same_v<R, Chunk>) {
    all(r.message_start_time, r.message_end_time, r.uncompressed_size, r.uncompressed_crc, r.compression);
  } else if constexpr (std::is_same_v<R, MessageIndex>) {
    all(r.channel_id, r.entries);
  } else if constexpr (std::is_same_v<R, ChunkIndex>) {
    all(r.message_start_time, r.message_end_time, r.chunk_start_offset, r.chunk_length, r.message_index_offsets,
        r.message_index_length, r.compression, r.compressed_size, r.uncompressed_size);
  } else if constexpr (std::is_same_v<R, Attachment>) {
    all(r.log_time, r.create_time, r.name, r.media_type);
  } else if constexpr (std::is_same_v<R, AttachmentIndex>) {
    all(r.offset, r.length, r.log_time, r.create_time, r.data_size, r.name, r.media_type);
  } else if constexpr (std::is_same_v<R, Statistics>) {
    all(r.message_count, r.schema_count, r.channel_count, r.attachment_count, r.metadata_count, r.chunk_count,
        r.message_start_time, r.message_end_time, r.channel_message_counts);
  } else if constexpr (std::is_same_v<R, Metadata>) {
    all(r.name, r.metadata);
  } else if constexpr (std::is_same_v<R, MetadataIndex>) {
    all(r.offset, r.length, r.name);
  } else if constexpr (std::is_same_v<R, SummaryOffset>) {
    all(r.group_opcode, r.group_start, r.group_length);
  } else {
    static_assert(std::is_same_v<R, DataEnd>);
    all(r.data_section_crc);
  }
}

template <class R>
constexpr Op op_of() {
  return static_cast<Op>(1 + []<std::size_t... I>(std::index_sequence<I...>) {
    return ((std::is_same_v<R, std::variant_alternative_t<I, Record>> ? I : 0) + ...);
  }(std::make_index_sequence<std::variant_size_v<Record>>()));
}

template <std::size_t I = 0>
Record parse_nth(std::size_t n, Bytes content) {
  if constexpr (I == std::variant_size_v<Record>) {
    throw Unusable("the kind of a record is not known");
  } else {
    return n == I ? Record(parse_as<std::variant_alternative_t<I, Record>>(content)) : parse_nth<I + 1>(n, content);
  }
}

}  // namespace

std::uint32_t crc32(Bytes bytes, std::uint32_t crc) {
  if (bytes.empty()) return crc;  // zlib takes null as a wish to begin anew
  return static_cast<std::uint32_t>(::crc32_z(crc, bytes.data(), bytes.size()));
}

void append(std::vector<std::uint8_t>& out, const Record& record) {
  Out write(out);
  std::visit(
      [&](const auto& r) {
        using R = std::remove_cvref_t<decltype(r)>;
        write(op_of<R>());
        const std::size_t start = out.size();
        write(std::uint64_t{0});
        const std::size_t content = out.size();
        visit(r, write);
        if constexpr (std::is_same_v<R, Message>) write.raw(r.data);
        if constexpr (std::is_same_v<R, Chunk>) {
          write(std::uint64_t{r.records.size()});
          write.raw(r.records);
        }
        if constexpr (std::is_same_v<R, Attachment>) {
          write(std::uint64_t{r.data.size()});
          write.raw(r.data);
          write(crc32(Bytes(out).subspan(content)));
        }
        const std::uint64_t length = out.size() - content;
        std::memcpy(out.data() + start, &length, sizeof length);
      },
      record);
}

template <class R>
R parse_as(Bytes content) {
  In in(content);
  R record;
  visit(record, in);
  if constexpr (std::is_same_v<R, Message>) in.rest(record.data);
  if constexpr (std::is_same_v<R, Chunk>) in.long_bytes(record.records);
  if constexpr (std::is_same_v<R, Attachment>) {
    in.long_bytes(record.data);
    if (in.left() < kAttachmentCrc) throw Unusable("ends early");
    const std::size_t crc_at = content.size() - in.left();
    in(record.crc);
    if (record.crc != 0 && record.crc != crc32(content.first(crc_at))) throw Unusable("its checksum is another one");
  }
  return record;
}

Record parse(Op op, Bytes content) { return parse_nth(static_cast<std::size_t>(op) - 1, content); }

template Header parse_as<Header>(Bytes);
template Footer parse_as<Footer>(Bytes);
template Schema parse_as<Schema>(Bytes);
template Channel parse_as<Channel>(Bytes);
template Message parse_as<Message>(Bytes);
template Chunk parse_as<Chunk>(Bytes);
template MessageIndex parse_as<MessageIndex>(Bytes);
template ChunkIndex parse_as<ChunkIndex>(Bytes);
template Attachment parse_as<Attachment>(Bytes);
template AttachmentIndex parse_as<AttachmentIndex>(Bytes);
template Statistics parse_as<Statistics>(Bytes);
template Metadata parse_as<Metadata>(Bytes);
template MetadataIndex parse_as<MetadataIndex>(Bytes);
template SummaryOffset parse_as<SummaryOffset>(Bytes);
template DataEnd parse_as<DataEnd>(Bytes);

}  // namespace waymark::mcap
