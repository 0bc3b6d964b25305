// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "plugins/shared/cdr/wire_reader.hpp"
#include "waymark/base/time.hpp"
#include "waymark/io/bad_record_list.hpp"

namespace waymark::message_log {

/// What a recording holds under one name and type. Several may have the same name: of several files, or of several
/// publishers.
struct Topic {
  enum class Encoding { ros1, cdr, other };

  std::string name;
  std::string type;  ///< as the recording has it: "sensor_msgs/Imu" of ROS 1, "sensor_msgs/msg/Imu" of ROS 2
  Encoding encoding = Encoding::other;
  std::string encoding_name;  ///< for messages to users
  std::string md5;            ///< of the definition, ROS 1
  std::string definition;     ///< its text (`ros2msg`); empty: not recorded
  std::string payload;        ///< of waymark's own messages: "waymark/ImuSample@1"
  std::map<std::string, std::string> metadata;
  std::uint64_t messages = 0;
};

/// A message in memory.
struct Message {
  Time recorded;
  std::optional<Time> published;      ///< if it was recorded, of a message without a stamp of its own
  std::uint32_t sequence = 0;         ///< as recorded; 0 if it was not
  std::size_t topic = 0;              ///< index of the topic
  ros::Bytes data;                    ///< as it was serialized
  std::shared_ptr<const void> owner;  ///< keeps the data
  std::size_t file = 0;               ///< of several that are read as one
  std::uint64_t record = 0;           ///< where the record that holds it lies in its file
  std::uint64_t offset = 0;           ///< where it lies in the record
};

/// A recording of topics: one or several files that are read as one.
class MessageLog {
 public:
  virtual ~MessageLog() = default;

  virtual const std::vector<Topic>& topics() const = 0;

  /// Where and why the recording breaks off, as far as that is known before it is read; empty if it does not.
  virtual std::string problem() const { return ""; }

  /// Which topics `next` is to deliver. Called once, before it.
  virtual void select(std::set<std::size_t> topics) = 0;

  /// The next message in the order of recording, or nothing at the end. What is damaged goes to `bad`. Throws DataError
  /// if a file cannot be read or `bad` is full.
  virtual std::optional<Message> next(BadRecordList& bad) = 0;

  /// "file:byte n", for errors.
  virtual std::string place(const Message& message) const = 0;

  /// Share of the recording that was read, 0..1.
  virtual double progress() const = 0;
};

}  // namespace waymark::message_log
