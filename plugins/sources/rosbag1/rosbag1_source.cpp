// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <queue>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bag.hpp"
#include "message_stream.hpp"
#include "messages.hpp"
#include "waymark/config/nearest_name.hpp"
#include "waymark/config/source_config.hpp"
#include "waymark/io/bad_record_list.hpp"
#include "waymark/plugin/source.hpp"

namespace waymark::rosbag1 {
namespace {

/// Bags of ROS 1, in order of the time of recording or of the stamps.
class Rosbag1Source final : public Source {
 public:
  Rosbag1Source(const Config& config, const Rig& rig);

  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override;
  double progress() const override { return stream_->progress(); }
  const std::vector<BadRecord>& bad_records() const override { return bad_.records(); }

 private:
  /// An entry of `channels` in the YAML.
  struct Route {
    std::string topic;
    std::string sensor;
    std::string payload;  // that is asked for; empty: the usual one
    const MessageKind* kind = nullptr;
    std::uint32_t channel = 0;
    bool stamp_recorded = false;
    Duration stamp_offset{};
  };
  struct LaterArrival {
    bool operator()(const Measurement& a, const Measurement& b) const {
      return a.arrival != b.arrival ? a.arrival > b.arrival : a.sequence > b.sequence;
    }
  };

  void open_bags(const Config& config, const std::vector<std::string>& names);
  static Route read_route(const Config& entry);
  void add_route(Route route, const Config& entry, const Rig& rig);
  const MessageKind& kind_for(const Config& entry, const Route& route) const;
  std::string topics_with_counts() const;
  std::set<std::pair<std::size_t, std::uint32_t>> wanted_connections() const;
  void take(const RawMessage& message);
  Measurement measure(const Route& route, const RawMessage& message) const;
  bool is_due() const;

  std::vector<Bag> bags_;
  std::vector<Route> routes_;
  std::vector<Channel> channels_;
  BadRecordList bad_;
  bool arrival_recorded_ = true;
  Duration reorder_window_{};

  std::optional<MessageStream> stream_;
  std::priority_queue<Measurement, std::vector<Measurement>, LaterArrival> ready_;
  Time newest_recorded_ = Time::min();   // of the messages that were taken
  Time newest_delivered_ = Time::min();  // arrival
  std::uint64_t taken_ = 0;              // measurements made, for the order of equal arrivals
  std::uint64_t delivered_ = 0;
  bool ended_ = false;
};

Rosbag1Source::Rosbag1Source(const Config& config, const Rig& rig)
    : bad_(static_cast<std::uint64_t>(config.integer_in(
               {"max_bad_records",
                "bad messages, damaged chunks and missing ends that are skipped before the run stops"},
               0, std::numeric_limits<std::int64_t>::max(), 0)),
           {"record", "max_bad_records", "goes on after such ones"}) {
  arrival_recorded_ = config.choice({"arrival",
                                     "when a measurement became known: `recorded`: the time of recording; `stamp`: as "
                                     "if nothing took time; the order is that of the arrivals"},
                                    {"recorded", "stamp"}, "recorded") == "recorded";
  if (!arrival_recorded_) {
    reorder_window_ = from_seconds(config.number_in({"reorder_window_s", "s",
                                                     "with `arrival: stamp`: how much later than the next one a "
                                                     "message may have been recorded and still be put in order"},
                                                    0.0, 3600.0, 1.0));
  }
  const std::vector<std::string> names = config.texts(
      {"file", "a bag, or a list of bags that are read as one (`rosbag record --split`); relative to the YAML"});
  if (names.empty()) config.fail("file", "the list is empty, at least one bag is expected");
  const std::vector<Config> entries = config.items({"channels", "which sensor gets which topic"});
  if (entries.empty()) config.fail("channels", "the list is empty, at least one channel is expected");
  std::vector<Route> routes;
  routes.reserve(entries.size());
  for (const Config& entry : entries) routes.push_back(read_route(entry));

  open_bags(config, names);
  for (std::size_t i = 0; i < entries.size(); ++i) add_route(std::move(routes[i]), entries[i], rig);
  stream_.emplace(bags_, wanted_connections());
}

void Rosbag1Source::open_bags(const Config& config, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    try {
      bags_.emplace_back(config.file().parent_path() / name);
    } catch (const DataError& error) {
      config.fail("file", error.what());
    }
  }
}

std::string Rosbag1Source::topics_with_counts() const {
  std::map<std::pair<std::string, std::string>, std::uint64_t> count;
  for (const Bag& bag : bags_) {
    for (const auto& [number, connection] : bag.connections())
      count[{connection.topic, connection.type}] += bag.messages(number);
  }
  if (count.empty()) return "there is no topic in the bag";
  std::string text;
  for (const auto& [topic, messages] : count)
    text += fmt::format("{}{} ({}, {})", text.empty() ? "" : ", ", topic.first, topic.second, messages);
  return "topics in the bag, with type and number of messages: " + text;
}

const MessageKind& Rosbag1Source::kind_for(const Config& entry, const Route& route) const {
  const std::string& topic = route.topic;
  std::set<std::pair<std::string, std::string>> types;  // with their md5
  std::vector<std::string> topics;
  for (const Bag& bag : bags_) {
    for (const auto& [number, connection] : bag.connections()) {
      topics.push_back(connection.topic);
      if (connection.topic == topic) types.insert({connection.type, connection.md5});
    }
  }
  if (types.empty()) {
    const std::string nearest = nearest_name(topic, topics);
    entry.fail("topic", fmt::format("there is no topic \"{}\"{}; {}", topic,
                                    nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest),
                                    topics_with_counts()));
  }
  if (types.size() > 1) {
    entry.fail("topic", fmt::format("\"{}\" carries messages of {} types or definitions; one is expected; {}", topic,
                                    types.size(), topics_with_counts()));
  }
  const auto& [type, md5] = *types.begin();
  const std::string& asked = route.payload;
  const MessageKind* usual = nullptr;
  std::string readable;
  std::string payloads;
  for (const MessageKind& kind : message_kinds()) {
    if (readable.find(kind.type) == std::string::npos)
      readable += fmt::format("{}{}", readable.empty() ? "" : ", ", kind.type);
    if (kind.type != type) continue;
    if (kind.md5 != md5) {
      entry.fail("topic",
                 fmt::format("\"{}\" carries {} with the md5 sum {}, but {} is expected: its definition is another one",
                             topic, type, md5, kind.md5));
    }
    if (asked == kind.payload || asked == short_type_name(kind.payload)) return kind;
    payloads += fmt::format("{}{}", payloads.empty() ? "" : " or ", short_type_name(kind.payload));
    if (usual == nullptr) usual = &kind;
  }
  if (usual == nullptr)
    entry.fail("topic", fmt::format("\"{}\" carries {}; types that can be read: {}", topic, type, readable));
  if (!asked.empty())
    entry.fail("payload", fmt::format("{} cannot be made of {}; {} is expected", asked, type, payloads));
  return *usual;
}

Rosbag1Source::Route Rosbag1Source::read_route(const Config& entry) {
  Route route;
  route.topic = entry.text({"topic", "its messages are read; several topics may feed one sensor"});
  route.sensor =
      entry.text({"sensor", "a name under `sensors`; one topic may feed several sensors with different payloads"});
  route.payload = entry.text({"payload", "",
                              "what to make of a message that more than one payload can be made of (of "
                              "`nav_msgs/Odometry`: `BodyTwist` or `Height`)",
                              "the first of them"},
                             "");
  route.stamp_recorded = entry.choice({"stamp",
                                       "when a measurement was true: `header`: the stamp of the message's `header`; "
                                       "`recorded`: the time of recording"},
                                      {"header", "recorded"}, "header") == "recorded";
  route.stamp_offset = from_seconds(
      entry.number_in({"stamp_offset_s", "s", "is added to the stamp: −0.02 for a device that stamps 20 ms too late"},
                      -3600.0, 3600.0, 0.0));
  return route;
}

void Rosbag1Source::add_route(Route route, const Config& entry, const Rig& rig) {
  route.kind = &kind_for(entry, route);
  const Channel wanted = channel_to_sensor(entry, rig, route.kind->payload, route.topic);
  for (const Route& other : routes_) {
    if (other.topic == route.topic && other.kind == route.kind) {
      entry.fail("sensor", fmt::format("two sensors on one input: \"{}\" and \"{}\" get {} of {}", other.sensor,
                                       route.sensor, short_type_name(wanted.payload_type), route.topic));
    }
  }
  const auto channel = std::ranges::find_if(channels_, [&](const Channel& one) {
    return one.sensor == wanted.sensor && one.payload_type == wanted.payload_type;
  });
  route.channel = static_cast<std::uint32_t>(channel - channels_.begin());
  if (channel == channels_.end()) channels_.push_back(wanted);
  entry.reject_unread();
  routes_.push_back(std::move(route));
}

/// Number of the bag and of the connection in it.
std::set<std::pair<std::size_t, std::uint32_t>> Rosbag1Source::wanted_connections() const {
  std::set<std::pair<std::size_t, std::uint32_t>> wanted;
  for (std::size_t bag = 0; bag < bags_.size(); ++bag) {
    for (const auto& [number, connection] : bags_[bag].connections()) {
      const std::string& topic = connection.topic;
      if (std::ranges::any_of(routes_, [&](const Route& route) { return route.topic == topic; }))
        wanted.insert({bag, number});
    }
  }
  return wanted;
}

Measurement Rosbag1Source::measure(const Route& route, const RawMessage& message) const {
  const Decoded decoded = decode(*route.kind, message.data);
  Measurement measurement;
  if (route.stamp_recorded) {
    measurement.stamp = message.recorded;
  } else if (decoded.stamp) {
    measurement.stamp = *decoded.stamp;
  } else {
    throw Unusable("its header has no stamp; `stamp: recorded` takes the time of recording");
  }
  measurement.stamp += route.stamp_offset;
  measurement.arrival = arrival_recorded_ ? message.recorded : measurement.stamp;
  if (measurement.stamp > measurement.arrival) {
    throw Unusable(
        fmt::format("its stamp lies {:.6f} s after it was recorded; with clocks that differ `stamp: recorded` or a "
                    "negative stamp_offset_s helps",
                    to_seconds(measurement.stamp - measurement.arrival)));
  }
  measurement.sensor = route.channel;
  measurement.payload = decoded.payload;
  return measurement;
}

/// Makes the measurements of one message.
void Rosbag1Source::take(const RawMessage& message) {
  if (arrival_recorded_ && message.recorded < newest_recorded_) {
    bad_.add(stream_->place(message), fmt::format("it was recorded {:.6f} s before a message that the index says is "
                                                  "earlier",
                                                  to_seconds(newest_recorded_ - message.recorded)));
    return;
  }
  newest_recorded_ = std::max(newest_recorded_, message.recorded);
  const std::string& topic = bags_[message.bag].connections().at(message.connection).topic;
  for (const Route& route : routes_) {
    if (route.topic != topic) continue;
    try {
      Measurement measurement = measure(route, message);
      if (measurement.arrival < newest_delivered_) {
        throw Unusable(
            fmt::format("its stamp lies {:.6f} s before one that was delivered; a larger reorder_window_s "
                        "would put them in order",
                        to_seconds(newest_delivered_ - measurement.arrival)));
      }
      measurement.sequence = taken_++;
      ready_.push(std::move(measurement));
    } catch (const Unusable& unusable) {
      bad_.add(stream_->place(message), fmt::format("{}: {}", topic, unusable.what()));
    }
  }
}

/// True if nothing that comes before the first of `ready_` can still be read.
bool Rosbag1Source::is_due() const {
  if (ready_.empty()) return false;
  return ended_ || arrival_recorded_ || ready_.top().arrival <= newest_recorded_ - reorder_window_;
}

std::optional<Measurement> Rosbag1Source::next() {
  while (!is_due()) {
    if (ended_) return std::nullopt;
    if (const auto message = stream_->next(bad_)) {
      take(*message);
    } else {
      ended_ = true;
    }
  }
  Measurement measurement = ready_.top();
  ready_.pop();
  newest_delivered_ = measurement.arrival;
  measurement.sequence = delivered_++;
  return measurement;
}

}  // namespace
}  // namespace waymark::rosbag1

WAYMARK_PLUGIN(waymark::Source, waymark::rosbag1::Rosbag1Source, "rosbag1", "1.0.0")
