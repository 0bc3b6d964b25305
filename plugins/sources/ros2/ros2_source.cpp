// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <deque>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "initial_pose.hpp"
#include "plugins/shared/cdr/message.hpp"
#include "plugins/shared/cdr/ros/std_msgs.hpp"
#include "plugins/shared/dds/names.hpp"
#include "plugins/shared/dds/reader.hpp"
#include "plugins/shared/live/event_list.hpp"
#include "static_transforms.hpp"
#include "topic_channel.hpp"
#include "topic_state.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/command.hpp"
#include "waymark/io/bad_record_list.hpp"
#include "waymark/plugin/source.hpp"

namespace waymark::ros2 {
namespace {

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();
constexpr std::chrono::milliseconds kLook{250};
constexpr dds::Quality kStatic{.reliable = true, .latched = true, .depth = 100};
constexpr dds::Quality kClock{.reliable = false, .latched = false, .depth = 1};
constexpr dds::Quality kPose{.reliable = true, .latched = false, .depth = 10};

/// From x forward, y left, z up to z forward, x right, y down (REP 103).
Pose T_optical_body() {
  Eigen::Matrix3d R;
  R << 0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0;
  return {Eigen::Quaterniond(R), Eigen::Vector3d::Zero()};
}

constexpr std::string_view kNone = "none";

std::string read_pose_topic(const Config& config) {
  std::string topic = config.text({"initial_pose",
                                   "a pose from this topic, as the button of RViz gives it, is the start, or begins "
                                   "anew there; `none`: no topic"},
                                  "/initialpose");
  try {
    dds::topic_name(topic);
  } catch (const std::invalid_argument& error) {
    config.fail("initial_pose", error.what());
  }
  return topic;
}

/// Refuses a channel that does not fit one before it.
void check_against(const TopicChannel& other, const TopicChannel& channel, const Config& entry) {
  if (other.topic() != channel.topic()) return;
  if (other.channel().payload_type == channel.channel().payload_type) {
    entry.fail("sensor",
               fmt::format("two sensors on one input: \"{}\" and \"{}\" get {} of {}", other.channel().sensor,
                           channel.channel().sensor, short_type_name(channel.channel().payload_type), channel.topic()));
  }
  if (other.type() != channel.type())
    entry.fail("type", fmt::format("{} is {} in another entry", channel.topic(), other.type()));
}

std::vector<TopicChannel> read_topics(const Config& config, const Rig& rig) {
  const std::vector<Config> entries = config.items({"channels", "which sensor gets which topic"});
  if (entries.empty()) config.fail("channels", "the list is empty, at least one channel is expected");
  std::vector<TopicChannel> topics;
  topics.reserve(entries.size());
  for (const Config& entry : entries) {
    TopicChannel channel(entry, rig);
    for (const TopicChannel& other : topics) check_against(other, channel, entry);
    entry.reject_unread();
    topics.push_back(std::move(channel));
  }
  return topics;
}

/// Topics of ROS 2. The domain is joined once the whole configuration is read.
class Ros2Source final : public Source {
 public:
  Ros2Source(const Config& config, const Rig& rig);

  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override;
  bool is_live() const override { return true; }
  void stop() override;
  std::vector<std::string> take_events() override { return events_.take(); }
  const std::vector<BadRecord>& bad_records() const override { return bad_.records(); }
  std::optional<Time> simulated_time() const override;
  std::optional<Pose> T_base_sensor(std::string_view sensor) override;

 private:
  /// A topic that is read.
  struct Input {
    std::string topic;
    dds::Reader reader;
    TopicState state;
    std::vector<std::size_t> channels;  // that its messages feed; none: it is one of the source's own topics
    std::uint64_t messages = 0;
  };
  struct Arrival {
    dds::Sample sample;
    std::size_t input;
  };

  std::size_t add_input(const std::string& topic, const std::string& type, const dds::Quality& quality);
  void take();
  void look();
  void use(const Arrival& arrival);
  void use_measurements(const Arrival& arrival, const Input& input);
  void use_clock(const dds::Sample& sample);
  void use_initial_pose(const dds::Sample& sample);
  void require_size(const dds::Sample& sample) const;
  void skip(const Input& input, const std::string& reason);
  void learn_frames();

  std::vector<Channel> channels_;
  std::size_t most_bytes_;
  std::string base_frame_, map_frame_;
  std::string pose_topic_;
  std::chrono::nanoseconds tf_patience_;
  bool is_simulated_;
  live::EventList events_;
  dds::DomainSettings domain_;
  std::vector<TopicChannel> topics_;
  std::unique_ptr<dds::Participant> participant_;
  dds::Wait wait_;
  std::deque<Input> inputs_;
  std::optional<std::size_t> tf_input_, clock_input_, pose_input_;
  StaticTransforms transforms_;
  std::vector<std::string> frames_;  // of the channels, as far as they are known

  BadRecordList bad_{kNoLimit, {"message", "", ""}};
  std::uint64_t skipped_ = 0;
  std::uint64_t next_report_ = 1;
  std::atomic<bool> stopped_ = false;
  std::atomic<std::int64_t> simulated_ns_ = 0;
  bool clock_has_begun_ = false;
  std::chrono::steady_clock::time_point looked_{};
  std::deque<Arrival> arrivals_;
  std::deque<Measurement> ready_;
  std::uint64_t delivered_ = 0;
};

Ros2Source::Ros2Source(const Config& config, const Rig& rig)
    : most_bytes_(static_cast<std::size_t>(config.integer_in({"max_message_bytes", "a larger message is skipped"}, 1000,
                                                             static_cast<std::int64_t>(dds::kMostBytes),
                                                             static_cast<std::int64_t>(dds::kMostBytes)))),
      base_frame_(config.text({"base_frame", "frame of the robot in /tf_static"}, "base_link")),
      map_frame_(config.text({"map_frame", "frame in which `initial_pose` is given"}, "map")),
      pose_topic_(read_pose_topic(config)),
      tf_patience_(from_seconds(config.number_in(
          {"tf_patience_s", "s", "how long a start waits for /tf_static, if a sensor has `base_T_sensor: from_tf`"},
          0.1, 3600.0, 10.0))),
      is_simulated_(config.boolean(
          {"use_sim_time", "true: the time is that of the topic `/clock`, of a simulation or of a bag that is played"},
          false)),
      domain_(dds::read_domain_settings(config)),
      topics_(read_topics(config, rig)),
      participant_(dds::join_domain(config, domain_, most_bytes_)),
      wait_(*participant_) {
  for (std::size_t i = 0; i < topics_.size(); ++i) {
    const TopicChannel& channel = topics_[i];
    auto input = std::ranges::find(inputs_, channel.topic(), &Input::topic);
    const auto index = static_cast<std::size_t>(input - inputs_.begin());
    if (input == inputs_.end()) add_input(channel.topic(), channel.type(), channel.quality());
    inputs_[index].channels.push_back(i);
    channels_.push_back(channel.channel());
  }
  if (pose_topic_ != kNone) {
    pose_input_ = add_input(pose_topic_, std::string(ros::geometry_msgs::PoseWithCovarianceStamped::kType), kPose);
    channels_.push_back({"", std::string(Command::kType)});
  }
  if (is_simulated_) clock_input_ = add_input("/clock", std::string(ros::rosgraph_msgs::Clock::kType), kClock);
}

std::size_t Ros2Source::add_input(const std::string& topic, const std::string& type, const dds::Quality& quality) {
  inputs_.push_back({topic, dds::Reader(*participant_, topic, type, quality), TopicState(topic, type), {}});
  wait_.add(inputs_.back().reader);
  return inputs_.size() - 1;
}

// --- samples ---------------------------------------------------------------------------------------------------------

/// Takes what has arrived on all topics, in the order of arrival.
void Ros2Source::take() {
  std::vector<dds::Sample> samples;
  std::vector<Arrival> arrivals;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    samples.clear();
    inputs_[i].reader.take(samples);
    for (dds::Sample& sample : samples) arrivals.push_back({std::move(sample), i});
  }
  std::ranges::sort(arrivals, {}, [](const Arrival& arrival) { return arrival.sample.order(); });
  std::ranges::move(arrivals, std::back_inserter(arrivals_));
}

void Ros2Source::look() {
  const auto now = std::chrono::steady_clock::now();
  if (now - looked_ < kLook) return;
  looked_ = now;
  for (Input& input : inputs_) {
    const bool is_clock = clock_input_ && &input == &inputs_[*clock_input_];
    if (!input.channels.empty() || is_clock) input.state.look(*participant_, input.reader, events_);
  }
}

void Ros2Source::require_size(const dds::Sample& sample) const {
  if (sample.size() > most_bytes_) {
    throw ros::Unusable(fmt::format("it has {} bytes; max_message_bytes is {}", sample.size(), most_bytes_));
  }
}

void Ros2Source::use(const Arrival& arrival) {
  Input& input = inputs_[arrival.input];
  ++input.messages;
  try {
    require_size(arrival.sample);
    if (arrival.input == tf_input_) {
      transforms_.add(ros::from_cdr<ros::tf2_msgs::TFMessage>(arrival.sample.bytes()));
    } else if (arrival.input == clock_input_) {
      use_clock(arrival.sample);
    } else if (arrival.input == pose_input_) {
      use_initial_pose(arrival.sample);
    } else {
      use_measurements(arrival, input);
    }
  } catch (const ros::Unusable& unusable) {
    skip(input, unusable.what());
  }
}

void Ros2Source::use_measurements(const Arrival& arrival, const Input& input) {
  if (is_simulated_ && !clock_has_begun_) return;  // nobody knows when it arrived
  for (const std::size_t channel : input.channels) {
    std::optional<Measurement> measurement = topics_[channel].measure(arrival.sample);
    if (!measurement) continue;
    measurement->sensor = static_cast<std::uint32_t>(channel);
    ready_.push_back(std::move(*measurement));
  }
}

void Ros2Source::use_clock(const dds::Sample& sample) {
  const auto message = ros::from_cdr<ros::rosgraph_msgs::Clock>(sample.bytes());
  const std::int64_t now = ros::to_time(message.clock).value_or(Time{}).time_since_epoch().count();
  const std::int64_t before = simulated_ns_.exchange(now);
  if (std::exchange(clock_has_begun_, true) && now < before) {
    events_.add(
        fmt::format("/clock went back by {:.3f} s: the simulation began anew", to_seconds(Duration{before - now})));
  }
}

void Ros2Source::use_initial_pose(const dds::Sample& sample) {
  if (is_simulated_ && !clock_has_begun_) return;
  const auto message = ros::from_cdr<ros::geometry_msgs::PoseWithCovarianceStamped>(sample.bytes());
  auto command = std::make_shared<Command>();
  command->text = set_pose_command(message, map_frame_);
  Measurement measurement;
  measurement.stamp = kUnknownStamp;
  measurement.sensor = static_cast<std::uint32_t>(channels_.size() - 1);
  measurement.payload = std::move(command);
  ready_.push_back(std::move(measurement));
}

/// Reports the first message that is none, then the 10th, the 100th, …
void Ros2Source::skip(const Input& input, const std::string& reason) {
  constexpr std::uint64_t kStep = 10;
  const std::string place = fmt::format("{}, message {}", input.topic, input.messages);
  bad_.add(place, reason);
  if (++skipped_ < next_report_) return;
  next_report_ *= kStep;
  events_.add(fmt::format("{} bad message{} so far; {}: {}", skipped_, skipped_ == 1 ? "" : "s", place, reason));
}

std::optional<Measurement> Ros2Source::next() {
  while (!stopped_) {
    if (!ready_.empty()) {
      Measurement measurement = std::move(ready_.front());
      ready_.pop_front();
      measurement.sequence = delivered_++;
      return measurement;
    }
    if (arrivals_.empty()) {
      look();
      take();
    }
    if (arrivals_.empty()) {
      wait_.wait(kLook);
      continue;
    }
    const Arrival arrival = std::move(arrivals_.front());
    arrivals_.pop_front();
    use(arrival);
  }
  return std::nullopt;
}

void Ros2Source::stop() {
  stopped_ = true;
  wait_.stop();
}

std::optional<Time> Ros2Source::simulated_time() const {
  if (!is_simulated_) return std::nullopt;
  return Time{Duration{simulated_ns_.load()}};
}

// --- where sensors are mounted ---------------------------------------------------------------------------------------

/// Messages before the run tell frames only.
void Ros2Source::learn_frames() {
  take();
  for (const Arrival& arrival : std::exchange(arrivals_, {})) {
    if (arrival.input == tf_input_) use(arrival);
    for (const std::size_t channel : inputs_[arrival.input].channels) {
      if (frames_[channel].empty() && arrival.sample.size() <= most_bytes_)
        frames_[channel] = topics_[channel].frame_of(arrival.sample);
    }
  }
}

std::optional<Pose> Ros2Source::T_base_sensor(std::string_view sensor) {
  const auto found = std::ranges::find(
      topics_, sensor, [](const TopicChannel& one) -> std::string_view { return one.channel().sensor; });
  if (found == topics_.end()) return std::nullopt;
  if (!tf_input_) tf_input_ = add_input("/tf_static", std::string(ros::tf2_msgs::TFMessage::kType), kStatic);
  frames_.resize(topics_.size());
  std::string& frame = frames_[static_cast<std::size_t>(found - topics_.begin())];
  if (frame.empty()) frame = found->given_frame();
  const auto end = std::chrono::steady_clock::now() + tf_patience_;
  for (;;) {
    try {
      learn_frames();
    } catch (const ros::Unusable& unusable) {
      throw DataError(fmt::format("the frame of {}: {}", found->topic(), unusable.what()));
    }
    if (!frame.empty()) {
      if (const auto pose = transforms_.find(base_frame_, frame))
        return found->is_optical() ? *pose * T_optical_body() : *pose;
    }
    if (std::chrono::steady_clock::now() >= end) break;
    wait_.wait(kLook);
  }
  if (frame.empty()) {
    throw DataError(
        fmt::format("no message came on {} within {:.1f} s, so its frame is not known; `frame` of its "
                    "channel gives it",
                    found->topic(), to_seconds(tf_patience_)));
  }
  throw DataError(fmt::format("/tf_static did not connect {} with {} within {:.1f} s; its frames: {}", frame,
                              base_frame_, to_seconds(tf_patience_), transforms_.list()));
}

}  // namespace
}  // namespace waymark::ros2

WAYMARK_PLUGIN(waymark::Source, waymark::ros2::Ros2Source, "ros2", "1.0.0")
