// SPDX-License-Identifier: Apache-2.0
#include "flight_replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "plugins/shared/cdr/definition.hpp"
#include "plugins/shared/cdr/payload_cdr.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/command.hpp"

namespace waymark::mcap_source {
namespace {

std::string text_of(const message_log::Topic& topic, std::string_view key) {
  const auto found = topic.metadata.find(std::string(key));
  return found == topic.metadata.end() ? std::string() : found->second;
}

/// The layout that payloads of this type have now must be that of the record.
void require_same_layout(const message_log::Topic& topic, const Config& config) {
  try {
    const std::string expected = ros::Definition(topic.type, ros::payload_definition(topic.payload)).layout();
    if (ros::Definition(topic.type, topic.definition).layout() == expected) return;
  } catch (const ros::Unusable& unusable) {
    config.fail("file", fmt::format("the record's {} on \"{}\" cannot be read: {}", topic.payload, topic.name,
                                    unusable.what()));
  }
  config.fail("file",
              fmt::format("the record's {} on \"{}\" has other fields than this version's", topic.payload, topic.name));
}

/// The number with these lower 32 bits that is nearest to the expected one.
std::uint64_t whole_sequence(std::uint32_t low, std::uint64_t expected) {
  const auto difference = static_cast<std::int32_t>(low - static_cast<std::uint32_t>(expected));
  return expected + static_cast<std::uint64_t>(std::int64_t{difference});
}

std::shared_ptr<Command> read_command(ros::Bytes data) {
  const auto text = nlohmann::json::parse(data.begin(), data.end(), nullptr, false);
  if (!text.is_object() || !text.contains("command") || !text["command"].is_string())
    throw ros::Unusable("it is not a command, {\"command\": \"text\"} is expected");
  auto command = std::make_shared<Command>();
  command->text = text["command"].get<std::string>();
  return command;
}

}  // namespace

FlightReplay::FlightReplay(std::unique_ptr<mcap::McapLog> log, std::uint64_t max_bad_records, const Config& config,
                           const Rig& rig)
    : log_(std::move(log)),
      // Where a crash cut a file off, no more than the last second is lost: that is reported, and no reason to stop.
      bad_(max_bad_records +
               static_cast<std::uint64_t>(std::ranges::count_if(
                   log_->files(), [](const mcap::McapFile& file) { return !file.broken_because().empty(); })),
           {"record", "max_bad_records", "goes on after such ones"}) {
  routes_.resize(log_->topics().size());
  for (std::size_t topic = 0; topic < routes_.size(); ++topic) add_topic(topic, config, rig);
  if (channels_.empty()) {
    config.fail("file",
                "it is not a flight record, which the sink `recorder` writes; `channels` is needed to read others");
  }
  // A sensor that never delivered anything is not a mistake of the robot's YAML.
  for (const Mounting& mounting : rig.mountings()) {
    if (std::ranges::find(channels_, mounting.name, &Channel::sensor) == channels_.end())
      channel(mounting.name, mounting.payload);
  }
  std::set<std::size_t> wanted;
  for (std::size_t topic = 0; topic < routes_.size(); ++topic) {
    if (routes_[topic]) wanted.insert(topic);
  }
  log_->select(std::move(wanted));
}

std::uint32_t FlightReplay::channel(const std::string& sensor, const std::string& payload) {
  const auto found = std::ranges::find_if(
      channels_, [&](const Channel& one) { return one.sensor == sensor && one.payload_type == payload; });
  if (found == channels_.end()) channels_.push_back({sensor, payload});
  return static_cast<std::uint32_t>(
      std::ranges::find_if(channels_,
                           [&](const Channel& one) { return one.sensor == sensor && one.payload_type == payload; }) -
      channels_.begin());
}

void FlightReplay::add_topic(std::size_t number, const Config& config, const Rig& rig) {
  const message_log::Topic& topic = log_->topics()[number];
  const std::string role = text_of(topic, mcap::kRoleKey);
  const std::string sensor = text_of(topic, mcap::kSensorKey);
  if (role == mcap::kCommandRole) {
    routes_[number] = Route{channel("", std::string(Command::kType)), true, 0};
  } else if (role == mcap::kDroppedRole && topic.messages > 0) {
    notices_.push_back(
        fmt::format("{} measurements of \"{}\" that the robot dropped are in the record, and not replayed",
                    topic.messages, sensor));
  } else if (role == mcap::kMeasurementRole) {
    const int mounted = rig.find(sensor);
    if (mounted < 0) {
      notices_.push_back(fmt::format("the record has {} measurements of \"{}\", which is not a sensor of this robot",
                                     topic.messages, sensor));
      return;
    }
    const std::string& takes = rig.mountings()[static_cast<std::size_t>(mounted)].payload;
    if (!takes.empty() && takes != topic.payload) {
      config.fail("file", fmt::format("sensor \"{}\" takes {}, but the record gives {}", sensor, takes, topic.payload));
    }
    require_same_layout(topic, config);
    Route route{channel(sensor, topic.payload), false, 0};
    const std::string first = text_of(topic, mcap::kFirstSequenceKey);
    std::from_chars(first.data(), first.data() + first.size(), route.next_sequence);
    routes_[number] = route;
  }
}

Measurement FlightReplay::measure(const message_log::Message& message) {
  // A robot's sensors may have stamped anything, which the filter counts; its own clock did not.
  if (!is_stamp(message.recorded)) throw ros::Unusable("its time of recording lies more than 146 years from the epoch");
  Route& route = *routes_[message.topic];
  Measurement measurement;
  measurement.arrival = message.recorded;
  measurement.sensor = route.channel;
  measurement.sequence = whole_sequence(message.sequence, route.next_sequence);
  if (route.is_command) {
    measurement.stamp = message.recorded;
    measurement.payload = read_command(message.data);
  } else {
    const auto payload = ros::payload_from_cdr(log_->topics()[message.topic].payload, message.data);
    const std::string problem = payload->problem();
    if (!problem.empty()) throw ros::Unusable(problem);
    measurement.stamp = *message.published;
    measurement.payload = payload;
  }
  route.next_sequence = measurement.sequence + 1;
  return measurement;
}

std::optional<Measurement> FlightReplay::next() {
  while (const auto message = log_->next(bad_)) {
    try {
      return measure(*message);
    } catch (const ros::Unusable& unusable) {
      bad_.add(log_->place(*message), fmt::format("{}: {}", log_->topics()[message->topic].name, unusable.what()));
    }
  }
  return std::nullopt;
}

}  // namespace waymark::mcap_source
