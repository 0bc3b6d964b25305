// SPDX-License-Identifier: Apache-2.0
// mcap_cases CASES.json FOLDER: writes each conformance case of MCAP three times, from its list of records: `records/`:
// record by record; `writer/`: with the writer (cases with padding cannot be written so); `read/`: as JSON, what a
// reader finds in the first.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <set>

#include "plugins/shared/mcap/file.hpp"
#include "plugins/shared/mcap/mcap_log.hpp"
#include "plugins/shared/mcap/records.hpp"
#include "plugins/shared/mcap/writer.hpp"

namespace {

using nlohmann::json;
using waymark::mcap::Bytes;
using waymark::mcap::Op;
using waymark::mcap::Record;
namespace mcap = waymark::mcap;

std::uint64_t number(const json& value) { return std::stoull(value.get<std::string>()); }

/// The fields of a record, by name.
class Fields {
 public:
  explicit Fields(const json& record) {
    for (const auto& field : record.at("fields")) fields_[field.at(0).get<std::string>()] = field.at(1);
  }
  template <class T>
  void get(const char* name, T& value) const {
    value = static_cast<T>(number(fields_.at(name)));
  }
  void get(const char* name, std::string& value) const { value = fields_.at(name).get<std::string>(); }
  void get(const char* name, std::vector<std::uint8_t>& value) const {
    for (const auto& byte : fields_.at(name)) value.push_back(static_cast<std::uint8_t>(number(byte)));
  }
  void get(const char* name, mcap::TextMap& value) const {
    for (const auto& [key, text] : fields_.at(name).items()) value.emplace_back(key, text.get<std::string>());
  }
  void get(const char* name, std::vector<std::pair<std::uint16_t, std::uint64_t>>& value) const {
    for (const auto& [key, count] : fields_.at(name).items())
      value.emplace_back(static_cast<std::uint16_t>(std::stoul(key)), number(count));
    std::ranges::sort(value);
  }

 private:
  std::map<std::string, json> fields_;
};

/// Collects the fields of a record as the cases have them.
class Listing {
 public:
  template <class T>
  void get(const char* name, const T& value) {
    add(name, std::to_string(static_cast<std::uint64_t>(value)));
  }
  void get(const char* name, const std::string& value) { add(name, value); }
  void get(const char* name, const std::vector<std::uint8_t>& value) {
    json bytes = json::array();
    for (const std::uint8_t byte : value) bytes.push_back(std::to_string(byte));
    add(name, bytes);
  }
  template <class A, class B>
  void get(const char* name, const std::vector<std::pair<A, B>>& value) {
    json map = json::object();
    for (const auto& [key, one] : value) map[text(key)] = text(one);
    add(name, map);
  }
  json record(const std::string& type) const { return {{"type", type}, {"fields", fields_}}; }

 private:
  static std::string text(const std::string& value) { return value; }
  static std::string text(std::uint64_t value) { return std::to_string(value); }
  void add(const char* name, json value) { fields_.push_back({name, std::move(value)}); }

  json fields_ = json::array();
};

/// Data of records that own none.
using Data = std::vector<std::uint8_t>;

/// Passes the fields in the order of the alphabet, which is that of the cases. Returns the name of the type.
template <class F, class R>
std::string visit(F& f, R& r, Data& data) {
  using T = std::remove_const_t<R>;
  if constexpr (std::is_same_v<T, mcap::Header>) {
    f.get("library", r.library), f.get("profile", r.profile);
    return "Header";
  } else if constexpr (std::is_same_v<T, mcap::Footer>) {
    f.get("summary_crc", r.summary_crc), f.get("summary_offset_start", r.summary_offset_start);
    f.get("summary_start", r.summary_start);
    return "Footer";
  } else if constexpr (std::is_same_v<T, mcap::Schema>) {
    f.get("data", r.data), f.get("encoding", r.encoding), f.get("id", r.id), f.get("name", r.name);
    return "Schema";
  } else if constexpr (std::is_same_v<T, mcap::Channel>) {
    f.get("id", r.id), f.get("message_encoding", r.message_encoding), f.get("metadata", r.metadata);
    f.get("schema_id", r.schema_id), f.get("topic", r.topic);
    return "Channel";
  } else if constexpr (std::is_same_v<T, mcap::Message>) {
    f.get("channel_id", r.channel_id), f.get("data", data), f.get("log_time", r.log_time);
    f.get("publish_time", r.publish_time), f.get("sequence", r.sequence);
    return "Message";
  } else if constexpr (std::is_same_v<T, mcap::ChunkIndex>) {
    f.get("chunk_length", r.chunk_length), f.get("chunk_start_offset", r.chunk_start_offset);
    f.get("compressed_size", r.compressed_size), f.get("compression", r.compression);
    f.get("message_end_time", r.message_end_time), f.get("message_index_length", r.message_index_length);
    f.get("message_index_offsets", r.message_index_offsets), f.get("message_start_time", r.message_start_time);
    f.get("uncompressed_size", r.uncompressed_size);
    return "ChunkIndex";
  } else if constexpr (std::is_same_v<T, mcap::Attachment>) {
    f.get("create_time", r.create_time), f.get("data", data), f.get("log_time", r.log_time);
    f.get("media_type", r.media_type), f.get("name", r.name);
    return "Attachment";
  } else if constexpr (std::is_same_v<T, mcap::AttachmentIndex>) {
    f.get("create_time", r.create_time), f.get("data_size", r.data_size), f.get("length", r.length);
    f.get("log_time", r.log_time), f.get("media_type", r.media_type), f.get("name", r.name);
    f.get("offset", r.offset);
    return "AttachmentIndex";
  } else if constexpr (std::is_same_v<T, mcap::Statistics>) {
    f.get("attachment_count", r.attachment_count), f.get("channel_count", r.channel_count);
    f.get("channel_message_counts", r.channel_message_counts), f.get("chunk_count", r.chunk_count);
    f.get("message_count", r.message_count), f.get("message_end_time", r.message_end_time);
    f.get("message_start_time", r.message_start_time), f.get("metadata_count", r.metadata_count);
    f.get("schema_count", r.schema_count);
    return "Statistics";
  } else if constexpr (std::is_same_v<T, mcap::Metadata>) {
    f.get("metadata", r.metadata), f.get("name", r.name);
    return "Metadata";
  } else if constexpr (std::is_same_v<T, mcap::MetadataIndex>) {
    f.get("length", r.length), f.get("name", r.name), f.get("offset", r.offset);
    return "MetadataIndex";
  } else if constexpr (std::is_same_v<T, mcap::SummaryOffset>) {
    f.get("group_length", r.group_length), f.get("group_opcode", r.group_opcode), f.get("group_start", r.group_start);
    return "SummaryOffset";
  } else if constexpr (std::is_same_v<T, mcap::DataEnd>) {
    f.get("data_section_crc", r.data_section_crc);
    return "DataEnd";
  } else {
    return "";  // Chunk and MessageIndex are not listed
  }
}

/// A record with its data.
struct Owned {
  std::string type;
  Record record;
  Data data;
};

template <std::size_t I = 0>
Owned read_case_record(const json& text) {
  if constexpr (I == std::variant_size_v<Record>) {
    throw std::runtime_error("unknown type " + text.at("type").get<std::string>());
  } else {
    std::variant_alternative_t<I, Record> record;
    Listing probe;
    Data data;
    const std::string type = visit(probe, std::as_const(record), data);
    if (type != text.at("type")) return read_case_record<I + 1>(text);
    Owned owned{type, {}, {}};
    const Fields fields(text);
    visit(fields, record, owned.data);
    owned.record = record;
    return owned;
  }
}

/// The record with its data in place.
Record with_data(const Owned& owned) {
  Record record = owned.record;
  if (auto* message = std::get_if<mcap::Message>(&record)) message->data = owned.data;
  if (auto* attachment = std::get_if<mcap::Attachment>(&record)) attachment->data = owned.data;
  return record;
}

/// Appends a record, and the bytes that `pad` adds to most.
void append(Data& out, const Record& record, bool pad) {
  const std::size_t start = out.size();
  mcap::append(out, record);
  const auto op = static_cast<Op>(out[start]);
  if (!pad || op == Op::message || op == Op::chunk || op == Op::data_end || op == Op::footer) return;
  for (const int byte : {0x01, 0xff, 0xff}) out.push_back(static_cast<std::uint8_t>(byte));
  const std::uint64_t length = out.size() - start - 9;
  for (std::size_t i = 0; i < sizeof length; ++i) out[start + 1 + i] = static_cast<std::uint8_t>(length >> (8 * i));
}

/// The case, record by record.
Data encode(const std::vector<Owned>& records, const std::set<std::string>& features) {
  const bool pad = features.contains("pad");
  Data out(std::begin(mcap::kMagic), std::end(mcap::kMagic));
  Data chunk;
  mcap::Chunk header;
  std::map<std::uint16_t, mcap::MessageIndex> indices;
  bool in_data = true;
  for (const Owned& owned : records) {
    if (owned.type == "DataEnd") {
      if (!chunk.empty()) {
        header.uncompressed_size = chunk.size();
        header.uncompressed_crc = mcap::crc32(chunk);
        header.records = chunk;
        append(out, header, pad);
        for (const auto& [id, index] : indices) {
          if (features.contains("mx")) append(out, index, pad);
        }
      }
      in_data = false;
    }
    const bool chunked = in_data && features.contains("ch") &&
                         (owned.type == "Schema" || owned.type == "Channel" || owned.type == "Message");
    if (const auto* message = std::get_if<mcap::Message>(&owned.record); message != nullptr && chunked) {
      header.message_start_time =
          indices.empty() ? message->log_time : std::min(header.message_start_time, message->log_time);
      header.message_end_time = std::max(header.message_end_time, message->log_time);
      indices[message->channel_id].channel_id = message->channel_id;
      indices[message->channel_id].entries.emplace_back(message->log_time, chunk.size());
    }
    append(chunked ? chunk : out, with_data(owned), pad && !chunked);
  }
  out.insert(out.end(), std::begin(mcap::kMagic), std::end(mcap::kMagic));
  return out;
}

/// The case as the writer has it, from what a user would add.
Data write(const std::vector<Owned>& records, const std::set<std::string>& features) {
  mcap::WriterOptions options;
  options.compression = mcap::WriterOptions::Compression::none;
  options.chunks = features.contains("ch");
  options.message_index = features.contains("mx");
  options.repeat_schemas = features.contains("rsh");
  options.repeat_channels = features.contains("rch");
  options.statistics = features.contains("st");
  options.chunk_index = features.contains("chx");
  options.attachment_index = features.contains("ax");
  options.metadata_index = features.contains("mdx");
  options.summary_offsets = features.contains("sum");
  mcap::Writer writer(options);
  Data out;
  for (const Owned& owned : records) {
    if (owned.type == "DataEnd") break;
    std::visit(
        [&](const auto& record) {
          if constexpr (requires { writer.add(record); }) writer.add(record);
        },
        with_data(owned));
    const Data piece = writer.take();
    out.insert(out.end(), piece.begin(), piece.end());
  }
  writer.finish();
  const Data piece = writer.take();
  out.insert(out.end(), piece.begin(), piece.end());
  return out;
}

void list_records(Bytes bytes, json& records) {
  while (!bytes.empty()) {
    waymark::ros::WireReader in(bytes);
    const auto op = static_cast<Op>(in.value<std::uint8_t>());
    const Bytes content = in.take(in.value<std::uint64_t>());
    const Record record = mcap::parse(op, content);
    if (const auto* chunk = std::get_if<mcap::Chunk>(&record)) {
      list_records(chunk->records, records);
    } else {
      std::visit(
          [&](const auto& one) {
            Data data;
            if constexpr (requires { one.data.subspan(0); }) data.assign(one.data.begin(), one.data.end());
            Listing listing;
            const std::string type = visit(listing, one, data);
            if (!type.empty()) records.push_back(listing.record(type));
          },
          record);
    }
    bytes = bytes.subspan(bytes.size() - in.left());
  }
}

/// Messages as the indexed reader gives them, in order of time.
json list_messages(const Data& bytes) {
  std::vector<mcap::McapFile> files;
  files.emplace_back(std::make_unique<mcap::MemoryBytes>(bytes), "case");
  mcap::McapLog log(std::move(files));
  std::set<std::size_t> all;
  for (std::size_t i = 0; i < log.topics().size(); ++i) all.insert(i);
  log.select(all);
  waymark::BadRecordList bad(0, {"record", "none", "none"});
  json messages = json::array();
  while (const auto message = log.next(bad)) {
    messages.push_back({message->recorded.time_since_epoch().count(), message->sequence,
                        std::vector<int>(message->data.begin(), message->data.end())});
  }
  return messages;
}

void save(const std::filesystem::path& file, const Data& bytes) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const std::filesystem::path folder = argv[2];
  const json cases = json::parse(std::ifstream(argv[1]));
  for (const auto& [name, one] : cases.items()) {
    const auto features = one.at("meta").at("variant").at("features").get<std::set<std::string>>();
    std::vector<Owned> records;
    for (const auto& record : one.at("records")) records.push_back(read_case_record(record));
    const Data bytes = encode(records, features);
    save(folder / "records" / (name + ".mcap"), bytes);
    if (!features.contains("pad")) save(folder / "writer" / (name + ".mcap"), write(records, features));
    json read = json::array();
    const std::size_t magic = std::size(mcap::kMagic);
    list_records(Bytes(bytes).subspan(magic, bytes.size() - 2 * magic), read);
    std::filesystem::create_directories((folder / "read" / name).parent_path());
    std::ofstream(folder / "read" / (name + ".json")) << json{{"records", read}, {"messages", list_messages(bytes)}};
  }
  return 0;
}
