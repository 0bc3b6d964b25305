// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "datagram_feed.hpp"
#include "file_feed.hpp"
#include "input_feed.hpp"
#include "plugins/shared/json_messages/payload_text.hpp"
#include "server_feed.hpp"
#include "waymark/config/nearest_name.hpp"
#include "waymark/config/source_config.hpp"
#include "waymark/interface/payload_registry.hpp"
#include "waymark/io/bad_record_list.hpp"
#include "waymark/plugin/source.hpp"

namespace waymark::json {
namespace {

using json_messages::BadMessage;
using json_messages::Message;
using json_messages::printable;

/// Lines of JSON, one message each: from programs that run beside the robot, or from a file.
class JsonSource final : public Source {
 public:
  JsonSource(const Config& config, const Rig& rig);

  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override;
  bool is_live() const override { return is_live_; }
  void stop() override { feed_->stop(); }
  std::vector<std::string> take_events() override { return events_.take(); }
  double progress() const override { return feed_->progress(); }
  const std::vector<BadRecord>& bad_records() const override { return bad_.records(); }

 private:
  std::unique_ptr<LineFeed> make_feed(const Config& config);
  void add_channel(const Config& entry, const Rig& rig);
  Measurement measurement_of(const FedLine& fed);
  std::uint32_t channel_of(const std::string& sensor) const;
  void set_times_of_log(Measurement& measurement);
  void skip(const std::string& place, const std::string& reason);

  std::vector<Channel> channels_;
  bool is_live_;
  std::size_t longest_line_;
  live::EventList events_;
  std::optional<Duration> max_jump_;  // of a log
  BadRecordList bad_;
  std::unique_ptr<LineFeed> feed_;
  std::uint64_t skipped_ = 0;
  std::uint64_t next_report_ = 1;
  std::uint64_t delivered_ = 0;
  std::optional<Time> arrival_;  // of a log: the last one
};

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

bool reads_file(const Config& config) {
  return config.choice({"from",
                        "where the lines come from: a UDP port; the clients of a TCP port or of a Unix socket; the "
                        "standard input; or a `file`, which is a log"},
                       {"udp", "tcp", "unix", "stdin", "file"}) == "file";
}

std::uint64_t bad_record_limit(const Config& config, bool is_live) {
  if (is_live) return kNoLimit;
  return static_cast<std::uint64_t>(
      config.integer_in({"max_bad_records", "lines of a file that are skipped before the run stops with an error"}, 0,
                        std::numeric_limits<std::int64_t>::max(), 0));
}

JsonSource::JsonSource(const Config& config, const Rig& rig)
    : is_live_(!reads_file(config)),
      longest_line_(static_cast<std::size_t>(config.integer_in(
          {"max_line_bytes", "a longer line is skipped; an image in base64 needs a third more than its bytes"}, 100,
          1 << 28, 1 << 20))),
      bad_(bad_record_limit(config, is_live_), {"line", "max_bad_records", "skips such lines"}),
      feed_(make_feed(config)) {
  const std::vector<Config> entries = config.items({"channels", "the sensors that messages may name"});
  if (entries.empty()) config.fail("channels", "the list is empty, at least one sensor is expected");
  for (const Config& entry : entries) add_channel(entry, rig);
}

std::unique_ptr<LineFeed> JsonSource::make_feed(const Config& config) {
  const std::string from = config.text("from");
  if (from == "file") {
    max_jump_ = from_seconds(config.number_in(
        {"max_time_jump_s", "s", "a larger step forward within a file is a fault"}, 1e-3, 9e9, 3600.0));
    return std::make_unique<FileFeed>(readable_file(config, {"file", "the log; relative to the YAML"}), longest_line_);
  }
  if (from == "stdin") return std::make_unique<InputFeed>(STDIN_FILENO, longest_line_, events_);
  constexpr std::string_view kAddress =
      "address to listen at; others than that of this machine itself can be reached by anybody in the network";
  if (from == "udp") return std::make_unique<DatagramFeed>(live::read_network_place(config, kAddress), events_);
  const StreamLimits limits{longest_line_, static_cast<std::size_t>(config.integer_in(
                                               {"max_clients", "clients at a time; others are refused"}, 1, 1000, 8))};
  live::ServerPlace place;
  if (from == "tcp") {
    place = live::read_network_place(config, kAddress);
  } else {
    place = config.file().parent_path() /
            config.text({"path", "of the Unix socket, which only the same user can open; relative to the YAML"});
  }
  return std::make_unique<ServerFeed>(std::move(place), limits, events_);
}

void JsonSource::add_channel(const Config& entry, const Rig& rig) {
  const std::string name = entry.text({"payload", "what its messages hold: `WheelSpeeds`, `GnssFix`, …"});
  const std::string_view type = find_payload_type(name);
  if (type.empty()) {
    std::vector<std::string> names;
    for (const KnownPayload& known : known_payloads()) names.emplace_back(short_type_name(known.type));
    const std::string nearest = nearest_name(name, names);
    std::string list;
    for (const std::string& one : names) list += (list.empty() ? "" : ", ") + one;
    entry.fail("payload", fmt::format("there is no payload \"{}\"{}; there are: {}", name,
                                      nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest), list));
  }
  Channel channel = channel_to_sensor(entry, rig, type);
  const bool repeated =
      std::ranges::any_of(channels_, [&](const Channel& other) { return other.sensor == channel.sensor; });
  if (repeated) entry.fail("sensor", fmt::format("\"{}\" is listed twice", channel.sensor));
  channels_.push_back(std::move(channel));
}

std::uint32_t JsonSource::channel_of(const std::string& sensor) const {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (channels_[i].sensor == sensor) return static_cast<std::uint32_t>(i);
    names.push_back(channels_[i].sensor);
  }
  const std::string nearest = nearest_name(printable(sensor), names);
  throw BadMessage(fmt::format("sensor \"{}\" is not under channels{}", printable(sensor),
                               nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest)));
}

/// Without overflow, whatever the times are.
bool is_later_by_more(Time time, Time before, Duration most) {
  const auto unsigned_count = [](auto t) { return static_cast<std::uint64_t>(t.count()); };
  return time > before &&
         unsigned_count(time.time_since_epoch()) - unsigned_count(before.time_since_epoch()) > unsigned_count(most);
}

/// The order of the lines is that of arrival.
void JsonSource::set_times_of_log(Measurement& measurement) {
  if (measurement.stamp == kUnknownStamp) throw BadMessage("a message in a file needs a stamp or stamp_ns");
  if (arrival_ && is_later_by_more(measurement.stamp, *arrival_, *max_jump_)) {
    throw BadMessage(fmt::format("time jumps forward from {} to {}; a step of at most {:.3f} s is expected",
                                 format_time(*arrival_), format_time(measurement.stamp), to_seconds(*max_jump_)));
  }
  arrival_ = std::max(arrival_.value_or(measurement.stamp), measurement.stamp);
  measurement.arrival = *arrival_;
}

Measurement JsonSource::measurement_of(const FedLine& fed) {
  if (fed.line.is_too_long) throw BadMessage(fmt::format("the line is longer than {} bytes", longest_line_));
  const Message message = json_messages::parse_message(fed.line.text);
  Measurement measurement;
  measurement.sensor = channel_of(message.sensor);
  measurement.stamp = message.stamp.value_or(kUnknownStamp);
  measurement.payload = json_messages::read_payload(message, channels_[measurement.sensor].payload_type);
  if (!is_live_) set_times_of_log(measurement);
  measurement.sequence = delivered_++;
  return measurement;
}

/// Reports the first bad line of a running robot, then the 10th, the 100th, …
void JsonSource::skip(const std::string& place, const std::string& reason) {
  constexpr std::uint64_t kStep = 10;
  bad_.add(place, reason);
  if (!is_live_ || ++skipped_ < next_report_) return;
  next_report_ *= kStep;
  events_.add(fmt::format("{} bad line{} so far; {}: {}", skipped_, skipped_ == 1 ? "" : "s", place, reason));
}

std::optional<Measurement> JsonSource::next() {
  FedLine fed;
  while (feed_->next(fed)) {
    const bool is_blank = fed.line.text.find_first_not_of(" \t\r") == std::string::npos;
    if (is_blank && !fed.line.is_too_long) continue;
    try {
      return measurement_of(fed);
    } catch (const BadMessage& bad) {
      skip(fed.place(), bad.what());
    }
  }
  return std::nullopt;
}

}  // namespace
}  // namespace waymark::json

WAYMARK_PLUGIN(waymark::Source, waymark::json::JsonSource, "json", "1.0.0")
