// SPDX-License-Identifier: Apache-2.0
#include "flight_encoder.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "plugins/shared/cdr/payload_cdr.hpp"
#include "plugins/shared/mcap/mcap_log.hpp"

namespace waymark::recorder {
namespace {

constexpr std::string_view kCommandSchema =
    R"({"type": "object", "properties": {"command": {"type": "string"}}, "required": ["command"]})";

std::vector<std::uint8_t> bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

std::uint64_t nanoseconds(Time time) { return static_cast<std::uint64_t>(time.time_since_epoch().count()); }

}  // namespace

FlightEncoder::FlightEncoder(mcap::WriterOptions options, std::vector<std::string> sensors, Duration flush)
    : writer_(std::move(options)), sensors_(std::move(sensors)), flush_(flush) {}

std::uint16_t FlightEncoder::schema_of(const Payload& payload) {
  const auto known = schemas_.find(payload.type());
  if (known != schemas_.end()) return known->second;
  const std::string definition = ros::payload_definition(payload);
  const std::uint16_t id = next_schema_++;
  writer_.add(mcap::Schema{id, ros::payload_message_type(payload.type()), "ros2msg", bytes_of(definition)});
  schemas_.emplace(payload.type(), id);
  return id;
}

std::uint16_t FlightEncoder::channel_of(const Measurement& measurement, bool is_dropped) {
  const std::string type(measurement.payload->type());
  const ChannelKey key(measurement.sensor, type, is_dropped);
  const auto known = channels_.find(key);
  if (known != channels_.end()) return known->second;
  const std::uint16_t schema = schema_of(*measurement.payload);
  const std::string& sensor = sensors_.at(measurement.sensor);
  mcap::Channel channel{
      next_channel_++, schema, fmt::format("/waymark/{}{}", sensor, is_dropped ? "/dropped" : ""), "cdr", {}};
  channel.metadata = {
      {std::string(mcap::kRoleKey), std::string(is_dropped ? mcap::kDroppedRole : mcap::kMeasurementRole)},
      {std::string(mcap::kSensorKey), sensor},
      {std::string(mcap::kPayloadKey), type},
      {std::string(mcap::kFirstSequenceKey), std::to_string(measurement.sequence)}};
  writer_.add(channel);
  channels_.emplace(key, channel.id);
  return channel.id;
}

std::uint16_t FlightEncoder::command_channel() {
  if (command_channel_ != 0) return command_channel_;
  const std::uint16_t schema = next_schema_++;
  writer_.add(mcap::Schema{schema, "waymark.Command", "jsonschema", bytes_of(kCommandSchema)});
  command_channel_ = next_channel_++;
  writer_.add(mcap::Channel{command_channel_,
                            schema,
                            "/waymark/commands",
                            "json",
                            {{std::string(mcap::kRoleKey), std::string(mcap::kCommandRole)}}});
  return command_channel_;
}

/// A chunk ends before what arrived too long after its begin.
void FlightEncoder::add_message(const mcap::Message& message, Time arrival) {
  if (chunk_is_open_ && arrival - chunk_begin_ >= flush_) flush();
  if (!chunk_is_open_) chunk_begin_ = arrival;
  chunk_is_open_ = true;
  writer_.add(message);
}

void FlightEncoder::add(const Measurement& measurement, bool is_dropped) {
  const std::string_view type = measurement.payload->type();
  if (left_out_.contains(type)) return;
  try {
    const std::vector<std::uint8_t> content = ros::payload_to_cdr(*measurement.payload);
    const std::uint16_t channel = channel_of(measurement, is_dropped);
    add_message({channel, static_cast<std::uint32_t>(measurement.sequence), nanoseconds(measurement.arrival),
                 nanoseconds(measurement.stamp), content},
                measurement.arrival);
  } catch (const ros::Unusable& unusable) {
    left_out_.emplace(type);
    events_.push_back(fmt::format("{} is not recorded: {}", type, unusable.what()));
  }
}

void FlightEncoder::add_command(Time arrival, std::string_view command) {
  const nlohmann::json json{{"command", command}};
  const std::string text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  const std::vector<std::uint8_t> content = bytes_of(text);
  const std::uint16_t channel = command_channel();
  add_message({channel, commands_++, nanoseconds(arrival), nanoseconds(arrival), content}, arrival);
}

void FlightEncoder::add_attachment(const std::string& name, const std::string& media_type, std::string_view content) {
  const std::vector<std::uint8_t> bytes = bytes_of(content);
  writer_.add(mcap::Attachment{0, 0, name, media_type, bytes, 0});
}

void FlightEncoder::add_metadata(const std::string& name, const std::map<std::string, std::string>& values) {
  writer_.add(mcap::Metadata{name, {values.begin(), values.end()}});
}

void FlightEncoder::flush() {
  writer_.finish_chunk();
  chunk_is_open_ = false;
}

std::vector<std::string> FlightEncoder::take_events() { return std::exchange(events_, {}); }

}  // namespace waymark::recorder
