// SPDX-License-Identifier: Apache-2.0
#include "bag_records.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace waymark::rosbag1 {

RecordHeader::RecordHeader(ros::Bytes bytes) {
  for (ros::WireReader wire(bytes); wire.left() > 0;) {
    const std::string_view field = wire.text();
    const std::size_t equals = field.find('=');
    if (equals == std::string_view::npos) throw ros::Unusable("a field of a record's header has no name");
    const auto* const value = reinterpret_cast<const std::uint8_t*>(field.data()) + equals + 1;
    fields_.emplace_back(field.substr(0, equals), ros::Bytes(value, field.size() - equals - 1));
  }
}

ros::Bytes RecordHeader::field(std::string_view name) const {
  const auto found = std::ranges::find(fields_, name, [](const auto& field) { return field.first; });
  if (found == fields_.end()) throw ros::Unusable(fmt::format("a record's header has no field \"{}\"", name));
  return found->second;
}

bool RecordHeader::has(std::string_view name) const {
  return std::ranges::find(fields_, name, [](const auto& field) { return field.first; }) != fields_.end();
}

std::string RecordHeader::text(std::string_view name) const {
  const ros::Bytes bytes = field(name);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Connection read_connection(const RecordHeader& header, ros::Bytes data) {
  const RecordHeader content(data);
  return {header.number<std::uint32_t>("conn"), header.text("topic"), content.text("type"), content.text("md5sum")};
}

std::string read_chunk(ros::Bytes chunk, const std::function<void(const StoredMessage&)>& on_message,
                       const std::function<void(Connection)>& on_connection) {
  std::size_t offset = 0;
  for (ros::WireReader wire(chunk); wire.left() > 0; offset = chunk.size() - wire.left()) {
    try {
      const RecordHeader header(wire.counted());
      const ros::Bytes data = wire.counted();
      switch (header.op()) {
        case Op::message:
          if (on_message) on_message({header.number<std::uint32_t>("conn"), header.time("time"), offset, data});
          break;
        case Op::connection:
          if (on_connection) on_connection(read_connection(header, data));
          break;
        default:
          break;
      }
    } catch (const ros::Unusable& bad) {
      return fmt::format("the record at {} of {} uncompressed bytes: {}", offset, chunk.size(), bad.what());
    }
  }
  return {};
}

}  // namespace waymark::rosbag1
