// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "map_topics.hpp"
#include "measurement_topics.hpp"
#include "plugins/shared/dds/names.hpp"
#include "plugins/shared/live/event_list.hpp"
#include "pose_topics.hpp"
#include "publisher.hpp"
#include "waymark/base/error.hpp"
#include "waymark/config/nearest_name.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::ros2_publisher {
namespace {

constexpr std::size_t kMostWaitingBytes = std::size_t{1} << 26;
const std::vector<std::string> kWords{"odometry",  "tf",          "pose", "path",    "map",
                                      "landmarks", "diagnostics", "fix",  "octomap", "measurements"};
const std::vector<std::string> kUsual{"odometry", "tf", "pose", "path", "map", "landmarks", "diagnostics"};

bool was_taken_in(Fate fate) {
  return fate == Fate::fused || fate == Fate::gated || fate == Fate::mapped || fate == Fate::skipped ||
         fate == Fate::held_out;
}

std::string read_topic(const Config& config, const Config::Key& key, std::string_view fallback) {
  std::string topic = config.text(key, fallback);
  try {
    dds::topic_name(topic);
  } catch (const std::invalid_argument& error) {
    config.fail(key.name, error.what());
  }
  return topic.starts_with('/') ? topic : "/" + topic;
}

Topics read_topics(const Config& config) {
  Topics topics;
  for (std::string& word : config.texts({"publish", "",
                                         "list of `odometry`, `tf`, `pose`, `path`, `map`, `landmarks`, `diagnostics`, "
                                         "`fix`, `octomap`, `measurements`",
                                         "the first seven of them"},
                                        kUsual)) {
    if (std::ranges::find(kWords, word) == kWords.end()) {
      const std::string nearest = nearest_name(word, kWords);
      config.fail("publish", fmt::format("\"{}\" is none of {}{}", word, fmt::join(kWords, ", "),
                                         nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest)));
    }
    topics.wanted.insert(std::move(word));
  }
  if (topics.wanted.empty()) config.fail("publish", "the list is empty, at least one word is expected");
  const Config names = config.child_or_empty({"topics", "names of the topics"});
  topics.odometry = read_topic(names, {"odometry", "smooth odometry, in the frame `odom`"}, "/odometry/filtered");
  topics.odometry_in_map = read_topic(names, {"odometry_in_map", "odometry in the map"}, "/odometry/filtered_map");
  topics.pose = read_topic(names, {"pose", "pose in the map"}, "/pose");
  topics.fix = read_topic(names, {"fix", "the same as latitude and longitude"}, "/gps/filtered");
  topics.path = read_topic(names, {"path", "path of the best particle"}, "/path");
  topics.map = read_topic(names, {"map", "the first dense map; a second one is `/map/NAME`"}, "/map");
  topics.landmarks = read_topic(names, {"landmarks", "markers of the landmarks"}, "/landmarks");
  topics.octomap = read_topic(names, {"octomap", "the first map that is an octree"}, "/octomap_binary");
  topics.diagnostics = read_topic(names, {"diagnostics", "health of pose and sensors"}, "/diagnostics");
  return topics;
}

/// The datum of the run's configuration.
std::optional<Datum> datum_of(const std::string& config) {
  if (config.empty()) return std::nullopt;
  const Config yaml = Config::parse(config, "effective configuration");
  if (!yaml.is_mapping("datum")) return std::nullopt;
  const Config datum = yaml.child("datum");
  return Datum{datum.number("latitude_deg"), datum.number("longitude_deg"), datum.number("height_m", 0.0)};
}

/// Poses, maps and health as topics of ROS 2, or the measurements themselves.
class Ros2Publisher final : public Sink {
 public:
  Ros2Publisher(const Config& config, const Rig& rig);

  void start(const RunInfo& info) override;
  void arrived(const Measurement& measurement) override;
  void front(const Belief& belief) override;
  void write(const Snapshot& snapshot) override;
  void finish(const Snapshot* last, const RunReport& report) override;
  std::vector<std::string> take_events() override { return events_.take(); }

 private:
  Topics topics_;
  Frames frames_;
  bool wants_front_;
  Duration ahead_;
  MapPeriods periods_;
  MeasurementSettings measurement_settings_;
  std::chrono::milliseconds linger_;
  Rig rig_;
  std::unique_ptr<dds::Participant> participant_;

  live::EventList events_;
  std::mutex mutex_;  // `front` is called by another thread than the rest
  std::unique_ptr<PoseTopics> poses_;
  std::unique_ptr<MapTopics> maps_;
  std::unique_ptr<MeasurementTopics> measurements_;
  std::unique_ptr<Publisher> publisher_;  // after what owns the writers: it ends before them
  std::optional<StateIndices> indices_;   // once started
  bool is_lost_ = false;
};

Ros2Publisher::Ros2Publisher(const Config& config, const Rig& rig)
    : topics_(read_topics(config)),
      frames_{config.text({"map_frame", "frame of the map"}, "map"),
              config.text({"odom_frame", "frame in which the pose is smooth, but drifts"}, "odom"),
              config.text({"base_frame", "frame of the robot"}, "base_link")},
      wants_front_(config.choice({"when",
                                  "when poses are published: `front`: the pose now, at the rate of the live host; "
                                  "`committed`: after every measurement that the filter took, also of a log"},
                                 {"front", "committed"}, "front") == "front"),
      ahead_(from_seconds(config.number_in(
          {"transform_ahead_s", "s", "map → odom is said to be valid so much later than the pose"}, 0.0, 10.0, 0.0))),
      periods_{from_seconds(config.number_in(
                   {"period_s", "s", "time between two messages of path, landmarks, health, and changes of grids"},
                   0.05, 3600.0, 1.0)),
               from_seconds(
                   config.number_in({"full_period_s", "s", "the same of whole grids and octrees"}, 0.05, 3600.0, 10.0)),
               static_cast<std::size_t>(
                   config.integer_in({"path_poses", "most poses of the path, which is thinned"}, 2, 100'000, 2000))},
      measurement_settings_(read_measurement_settings(config, rig)),
      linger_(static_cast<std::int64_t>(
          1e3 * config.number_in({"linger_s", "s", "at the end: how long readers that are slow are waited for"}, 0.0,
                                 60.0, 1.0))),
      rig_(rig),
      participant_(dds::join_domain(config, dds::read_domain_settings(config))) {}

void Ros2Publisher::start(const RunInfo& info) {
  const std::optional<Datum> datum = datum_of(info.config);
  if (topics_.has("fix") && !datum) throw Error("publish: fix needs the map's place on the Earth: `datum` of the YAML");
  std::vector<std::string> sensors;
  for (const Mounting& mounting : rig_.mountings()) sensors.push_back(mounting.name);
  const std::lock_guard lock(mutex_);
  publisher_ = std::make_unique<Publisher>(kMostWaitingBytes);
  poses_ = std::make_unique<PoseTopics>(*participant_, topics_, frames_, ahead_, datum);
  maps_ = std::make_unique<MapTopics>(*participant_, *publisher_, topics_, periods_, frames_.map, std::move(sensors));
  if (topics_.has("measurements")) {
    measurements_ = std::make_unique<MeasurementTopics>(*participant_, *publisher_, events_, rig_,
                                                        measurement_settings_, datum, frames_.base);
  }
}

void Ros2Publisher::arrived(const Measurement& measurement) {
  if (measurements_) measurements_->publish(measurement);
}

void Ros2Publisher::front(const Belief& belief) {
  if (!wants_front_) return;
  const std::lock_guard lock(mutex_);
  if (poses_ && indices_ && !is_lost_) poses_->publish(belief, *indices_);
}

void Ros2Publisher::write(const Snapshot& snapshot) {
  if (maps_) maps_->publish(snapshot);
  const std::lock_guard lock(mutex_);
  is_lost_ = !snapshot.started();
  if (is_lost_) return;
  if (!indices_) indices_.emplace(snapshot.layout());
  if (poses_ && !wants_front_ && was_taken_in(snapshot.fate())) poses_->publish(snapshot.belief(), *indices_);
}

void Ros2Publisher::finish(const Snapshot*, const RunReport&) {
  const std::lock_guard lock(mutex_);
  if (!publisher_) return;
  publisher_->finish(linger_);
  std::uint64_t left_out = publisher_->left_out() + poses_->left_out();
  if (measurements_) {
    measurements_->wait_for_readers(linger_);
    left_out += measurements_->left_out();
  }
  if (left_out > 0) events_.add(fmt::format("ros2_publisher: {} messages were left out for slow readers", left_out));
  publisher_ = nullptr;
  measurements_ = nullptr;
  maps_ = nullptr;
  poses_ = nullptr;
}

}  // namespace
}  // namespace waymark::ros2_publisher

WAYMARK_PLUGIN(waymark::Sink, waymark::ros2_publisher::Ros2Publisher, "ros2_publisher", "1.0.0")
