// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/message_log/topic_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <utility>

#include "plugins/shared/cdr/definition.hpp"
#include "plugins/shared/cdr/definition_text.hpp"
#include "plugins/shared/cdr/payload_cdr.hpp"
#include "plugins/shared/message_log/field_decoder.hpp"
#include "plugins/shared/message_log/negation.hpp"
#include "waymark/base/error.hpp"
#include "waymark/config/nearest_name.hpp"
#include "waymark/config/source_config.hpp"
#include "waymark/interface/payload_registry.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::message_log {
namespace {

using ros::Unusable;

/// A name of a type as this recording has them.
std::string type_as_in(const Topic& topic, std::string_view type) {
  return topic.encoding == Topic::Encoding::ros1 ? ros::short_message_name(type) : std::string(type);
}

/// Throws ConfigError if the recorded definition, if there is one, is not of the layout of the expected one.
void require_layout(const std::string& definition, const Topic& topic, const Config& entry) {
  if (topic.definition.empty()) return;
  std::string recorded;
  try {
    recorded = ros::Definition(topic.type, topic.definition).layout();
  } catch (const Unusable& unusable) {
    entry.fail("topic", fmt::format("the recorded definition of {} on \"{}\" cannot be read: {}", topic.type,
                                    topic.name, unusable.what()));
  }
  const std::string expected = ros::Definition(topic.type, definition).layout();
  if (recorded != expected) {
    entry.fail("topic", fmt::format("\"{}\" carries a {} whose definition is another one: its fields are {}but {}are "
                                    "expected",
                                    topic.name, topic.type, recorded.substr(0, 400), expected));
  }
}

/// Throws ConfigError if the recorded definition is not the one that the kind reads.
void require_definition(const ros::MessageKind& kind, const Topic& topic, const Config& entry) {
  if (topic.encoding != Topic::Encoding::ros1) return require_layout(kind.definition(), topic, entry);
  if (kind.ros1_md5 == topic.md5) return;
  entry.fail("topic",
             fmt::format("\"{}\" carries {} with the md5 sum {}, but {} is expected: its definition is another one",
                         topic.name, topic.type, topic.md5, kind.ros1_md5));
}

/// Decoder of payloads that waymark wrote.
ros::Decoder payload_decoder(const std::string& payload_type) {
  return [payload_type](const ros::WireReader& in) {
    return ros::Decoded{std::nullopt, {}, ros::payload_from_cdr(payload_type, in)};
  };
}

/// "a, b or c".
std::string any_of(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " or " : ", ";
    text += words[i];
  }
  return text;
}

bool is_undefined(const Topic& topic) { return topic.md5.empty() && topic.definition.empty(); }

bool agree(const Topic& a, const Topic& b) {
  const bool is_one_definition = is_undefined(a) || is_undefined(b) || (a.md5 == b.md5 && a.definition == b.definition);
  return is_one_definition && a.type == b.type && a.encoding_name == b.encoding_name && a.payload == b.payload;
}

void require_valid(const Payload& payload) {
  const std::string problem = payload.problem();
  if (!problem.empty()) throw Unusable(problem);
}

}  // namespace

TopicSource::TopicSource(const Config& config, const Rig& rig, const LogFormat& format)
    : log_name_(format.one),
      bad_(static_cast<std::uint64_t>(config.integer_in({"max_bad_records", format.bad_record}, 0,
                                                        std::numeric_limits<std::int64_t>::max(), 0)),
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
  max_ahead_ = from_seconds(config.number_in(
      {"max_ahead_s", "s",
       "a stamp may lie this long after the time of recording, as clocks of two computers differ; the host has its own "
       "limit (`clock`)"},
      0.0, 3600.0, 0.1));
  const std::vector<std::string> names = config.texts({"file", format.file_key});
  if (names.empty()) config.fail("file", fmt::format("the list is empty, at least one file is expected"));
  const std::vector<Config> entries = config.items({"channels", "which sensor gets which topic"});
  if (entries.empty()) config.fail("channels", "the list is empty, at least one channel is expected");
  std::vector<Route> routes;
  routes.reserve(entries.size());
  for (const Config& entry : entries) routes.push_back(read_route(entry));

  std::vector<std::filesystem::path> files;
  files.reserve(names.size());
  for (const std::string& name : names) files.push_back(config.file().parent_path() / name);
  try {
    log_ = format.open(files);
  } catch (const DataError& error) {
    config.fail("file", error.what());
  }
  for (std::size_t i = 0; i < entries.size(); ++i) add_route(std::move(routes[i]), entries[i], rig);
  log_->select(wanted_topics());
}

std::string TopicSource::topics_with_counts() const {
  std::map<std::pair<std::string, std::string>, std::uint64_t> count;
  for (const Topic& topic : log_->topics()) count[{topic.name, topic.type}] += topic.messages;
  const std::string problem = log_->problem().empty() ? "" : "; " + log_->problem();
  if (count.empty()) return fmt::format("there is no topic in {}{}", log_name_, problem);
  std::string text;
  for (const auto& [topic, messages] : count)
    text += fmt::format("{}{} ({}, {})", text.empty() ? "" : ", ", topic.first, topic.second, messages);
  return fmt::format("topics in {}, with type and number of messages: {}{}", log_name_, text, problem);
}

/// All topics of the name are of one type and definition; a part that lacks the definition agrees with those that have
/// it.
Topic TopicSource::find_topic(const Config& entry, const std::string& name) const {
  std::vector<std::string> names;
  std::vector<const Topic*> kinds;
  for (const Topic& topic : log_->topics()) {
    names.push_back(topic.name);
    if (topic.name != name) continue;
    const auto same = std::ranges::find_if(kinds, [&](const Topic* kind) { return agree(*kind, topic); });
    if (same == kinds.end()) {
      kinds.push_back(&topic);
    } else if (is_undefined(**same)) {
      *same = &topic;
    }
  }
  if (kinds.empty()) {
    const std::string nearest = nearest_name(name, names);
    entry.fail("topic", fmt::format("there is no topic \"{}\"{}; {}", name,
                                    nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest),
                                    topics_with_counts()));
  }
  if (kinds.size() > 1) {
    entry.fail("topic", fmt::format("\"{}\" carries messages of {} types or definitions; one is expected; {}", name,
                                    kinds.size(), topics_with_counts()));
  }
  const Topic* found = kinds.front();
  if (found->encoding == Topic::Encoding::other) {
    entry.fail("topic", fmt::format("the messages on \"{}\" are encoded as \"{}\"; \"cdr\" is expected", name,
                                    found->encoding_name));
  }
  return *found;
}

void TopicSource::choose_decoder(Route& route, const Topic& topic, const Config& entry) {
  const auto is_asked = [&](std::string_view payload) {
    return route.payload == payload || route.payload == short_type_name(payload);
  };
  if (route.has_fields) {
    if (topic.encoding != Topic::Encoding::cdr || topic.definition.empty())
      entry.fail("fields", fmt::format("the definition of {} was not recorded", topic.type));
    std::string names;
    for (const KnownPayload& known : known_payloads())
      names += fmt::format("{}{}", names.empty() ? "" : ", ", short_type_name(known.type));
    route.payload_type = find_payload_type(route.payload);
    if (route.payload_type.empty())
      entry.fail("payload", fmt::format("with `fields` the payload is needed; one of {} is expected", names));
    route.decode = make_field_decoder(topic.type, topic.definition, route.payload_type, entry);
    return;
  }
  if (!topic.payload.empty()) {
    if (!route.payload.empty() && !is_asked(topic.payload))
      entry.fail("payload", fmt::format("\"{}\" carries {}", topic.name, topic.payload));
    if (!make_payload(topic.payload))
      entry.fail("topic",
                 fmt::format("\"{}\" carries {}, which is a payload neither of core nor of a plugin of this robot",
                             topic.name, topic.payload));
    require_layout(ros::payload_definition(topic.payload), topic, entry);
    route.payload_type = topic.payload;
    route.decode = payload_decoder(topic.payload);
    return;
  }
  const ros::MessageKind* chosen = nullptr;
  std::string readable;
  std::vector<std::string> payloads;
  for (const ros::MessageKind& kind : ros::message_kinds()) {
    const std::string type = type_as_in(topic, kind.type);
    if (readable.find(type) == std::string::npos) readable += fmt::format("{}{}", readable.empty() ? "" : ", ", type);
    if (type != topic.type) continue;
    payloads.emplace_back(short_type_name(kind.payload));
    if (chosen == nullptr && (route.payload.empty() || is_asked(kind.payload))) chosen = &kind;
  }
  if (payloads.empty()) {
    entry.fail("topic",
               fmt::format("\"{}\" carries {}; types that can be read: {}{}", topic.name, topic.type, readable,
                           topic.encoding == Topic::Encoding::cdr ? "; `fields` reads numbers of others" : ""));
  }
  if (chosen == nullptr) {
    entry.fail("payload",
               fmt::format("{} cannot be made of {}; {} is expected", route.payload, topic.type, any_of(payloads)));
  }
  require_definition(*chosen, topic, entry);
  route.payload_type = chosen->payload;
  route.decode = chosen->make(route.settings, entry);
}

TopicSource::Route TopicSource::read_route(const Config& entry) {
  Route route;
  route.topic = entry.text({"topic", "its messages are read; several topics may feed one sensor"});
  route.sensor =
      entry.text({"sensor", "a name under `sensors`; one topic may feed several sensors with different payloads"});
  route.payload = entry.text({"payload", "",
                              "what to make of a message that more than one payload can be made of (of "
                              "`nav_msgs/Odometry`: `BodyTwist`, `Height` or `PoseIncrement`)",
                              "the first of them"},
                             "");
  route.stamp_recorded = entry.choice({"stamp",
                                       "when a measurement was true: `header`: the stamp of the message's `header`; "
                                       "`recorded`: the time of recording"},
                                      {"header", "recorded"}, "header") == "recorded";
  route.stamp_offset = from_seconds(
      entry.number_in({"stamp_offset_s", "s", "is added to the stamp: −0.02 for a device that stamps 20 ms too late"},
                      -3600.0, 3600.0, 0.0));
  route.settings = ros::read_decoder_settings(entry);
  entry.child_or_empty({"fields",
                        "of ROS 2, for messages that are not in the list below: numbers of the payload, each with that "
                        "of the message (`v_x_mps: velocity.x`, also `-velocity.y`) or a value"});
  route.has_fields = entry.has("fields");
  route.negate =
      entry.texts({"negate",
                   "numbers of the payload whose sign is turned, by their names (`w_z_radps`, `yaw_rad`): for "
                   "axes that point the other way"},
                  std::vector<std::string>{});
  return route;
}

void TopicSource::add_route(Route route, const Config& entry, const Rig& rig) {
  choose_decoder(route, find_topic(entry, route.topic), entry);
  if (!route.negate.empty()) route.decode = negated(std::move(route.decode), route.payload_type, route.negate, entry);
  const Channel wanted = channel_to_sensor(entry, rig, route.payload_type, route.topic);
  for (const Route& other : routes_) {
    if (other.topic == route.topic && other.payload_type == route.payload_type && !route.has_fields) {
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

std::set<std::size_t> TopicSource::wanted_topics() const {
  std::set<std::size_t> wanted;
  const std::vector<Topic>& topics = log_->topics();
  for (std::size_t i = 0; i < topics.size(); ++i) {
    if (std::ranges::find(routes_, topics[i].name, &Route::topic) != routes_.end()) wanted.insert(i);
  }
  return wanted;
}

/// Nothing if there is no payload yet.
std::optional<Measurement> TopicSource::measure(const Route& route, const Message& message) const {
  const Topic& topic = log_->topics()[message.topic];
  const bool ros1 = topic.encoding == Topic::Encoding::ros1;
  const ros::Decoded decoded = route.decode(ros1 ? ros::WireReader(message.data) : ros::WireReader::cdr(message.data));
  if (!decoded.payload) return std::nullopt;
  if (route.has_fields || !topic.payload.empty()) require_valid(*decoded.payload);
  Measurement measurement;
  if (route.stamp_recorded) {
    measurement.stamp = message.recorded;
  } else if (decoded.stamp) {
    measurement.stamp = *decoded.stamp;
  } else if (message.published) {
    measurement.stamp = *message.published;
  } else {
    throw Unusable("its header has no stamp; `stamp: recorded` takes the time of recording");
  }
  const auto stamp = moved(measurement.stamp, route.stamp_offset);
  if (!stamp) throw Unusable("its stamp lies more than 146 years from the epoch");
  measurement.stamp = *stamp;
  // What is valid from before its stamp on, an increment, becomes known at its end.
  measurement.arrival = arrival_recorded_ ? message.recorded : measurement.stamp;
  measurement.stamp -= decoded.before;
  if (measurement.stamp - measurement.arrival > max_ahead_) {
    throw Unusable(fmt::format(
        "its stamp lies {:.6f} s after it was recorded; max_ahead_s is {:g}; with clocks that differ `stamp: "
        "recorded` or a negative stamp_offset_s helps",
        to_seconds(measurement.stamp - measurement.arrival), to_seconds(max_ahead_)));
  }
  measurement.sensor = route.channel;
  measurement.payload = decoded.payload;
  return measurement;
}

/// Makes the measurements of one message.
void TopicSource::take(const Message& message) {
  if (!is_stamp(message.recorded)) {
    bad_.add(log_->place(message), "its time of recording lies more than 146 years from the epoch");
    return;
  }
  if (arrival_recorded_ && message.recorded < newest_recorded_) {
    bad_.add(log_->place(message), fmt::format("it was recorded {:.6f} s before a message that the index says is "
                                               "earlier",
                                               to_seconds(newest_recorded_ - message.recorded)));
    return;
  }
  newest_recorded_ = std::max(newest_recorded_, message.recorded);
  const std::string& topic = log_->topics()[message.topic].name;
  for (const Route& route : routes_) {
    if (route.topic != topic) continue;
    try {
      auto measurement = measure(route, message);
      if (!measurement) continue;
      if (measurement->arrival < newest_delivered_) {
        throw Unusable(
            fmt::format("its stamp lies {:.6f} s before one that was delivered; a larger reorder_window_s "
                        "would put them in order",
                        to_seconds(newest_delivered_ - measurement->arrival)));
      }
      measurement->sequence = taken_++;
      ready_.push(std::move(*measurement));
    } catch (const Unusable& unusable) {
      bad_.add(log_->place(message), fmt::format("{}: {}", topic, unusable.what()));
    }
  }
}

/// True if nothing that comes before the first of `ready_` can still be read.
bool TopicSource::is_due() const {
  if (ready_.empty()) return false;
  return ended_ || arrival_recorded_ || ready_.top().arrival <= newest_recorded_ - reorder_window_;
}

std::optional<Measurement> TopicSource::next() {
  while (!is_due()) {
    if (ended_) return std::nullopt;
    if (const auto message = log_->next(bad_)) {
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

}  // namespace waymark::message_log
