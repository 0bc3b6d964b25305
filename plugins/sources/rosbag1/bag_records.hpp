// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plugins/shared/cdr/wire_reader.hpp"

namespace waymark::rosbag1 {

/// The kinds of records that matter here; the number is their field "op".
enum class Op : std::uint8_t { message = 2, bag_header = 3, index = 4, chunk = 5, connection = 7 };

/// The header of a record: fields with names.
class RecordHeader {
 public:
  /// Throws ros::Unusable. The bytes must outlive this.
  explicit RecordHeader(ros::Bytes bytes);

  Op op() const { return static_cast<Op>(number<std::uint8_t>("op")); }
  /// Throws ros::Unusable if there is no such field, or one of another size.
  template <class T>
  T number(std::string_view name) const {
    ros::WireReader wire(field(name));
    const T value = wire.value<T>();
    if (wire.left() != 0) throw ros::Unusable("the field \"" + std::string(name) + "\" has another size");
    return value;
  }
  Time time(std::string_view name) const { return ros::WireReader(field(name)).time(); }
  std::string text(std::string_view name) const;
  bool has(std::string_view name) const;

 private:
  ros::Bytes field(std::string_view name) const;

  std::vector<std::pair<std::string_view, ros::Bytes>> fields_;
};

/// Who publishes what: the topic and its type.
struct Connection {
  std::uint32_t number = 0;
  std::string topic;
  std::string type;  ///< "sensor_msgs/Imu"
  std::string md5;   ///< of the message's definition
};

/// Reads a record of a connection. Throws ros::Unusable.
Connection read_connection(const RecordHeader& header, ros::Bytes data);

/// A message in a chunk, still serialized.
struct StoredMessage {
  std::uint32_t connection = 0;
  Time recorded;
  std::size_t offset = 0;  ///< of its record in the uncompressed chunk
  ros::Bytes data;         ///< points into the chunk
};

/// Calls one of the two functions (which may be null) for each record of an uncompressed chunk. Returns why it stopped
/// before the end, or an empty text.
std::string read_chunk(ros::Bytes chunk, const std::function<void(const StoredMessage&)>& on_message,
                       const std::function<void(Connection)>& on_connection);

}  // namespace waymark::rosbag1
