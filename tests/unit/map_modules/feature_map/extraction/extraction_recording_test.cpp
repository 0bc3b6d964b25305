// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv
// The extraction of config/victoria_park.yaml, asked for isolation, on the recording itself, next to the detections
// that were published with it (K. Leung, F. Inostroza, 2014). Which detections are trees is not labelled, so things are
// judged by persistence: what stands still is found again by the scans before and after that should see it.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <string>

#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::kDegree;

constexpr double kDuration = 300.0;       // of the recording [s]
constexpr double kWindow = 2.0;           // before and after a scan, within which dead reckoning is good [s]
constexpr double kViewHalfAngle = 80.0;   // [°]
constexpr double kOftenEnough = 0.7;      // of the scans that should see a thing
constexpr std::size_t kScansToJudge = 5;  // fewer prove nothing
constexpr double kOcclusionMargin = 1.0;  // a return nearer than this in front hides a thing [m]
constexpr double kSamePublished = 0.5;    // [m]
constexpr double kSamePlace = 0.5;        // plus the share of the range below [m]
constexpr double kSamePlacePerRange = 0.015;

struct Found {
  Eigen::Vector2d p_sensor;
  double radius;
  bool judged = false;
  bool persistent = false;
};

/// One scan with where it was taken (dead reckoning) and what a detector found in it.
struct Stop {
  Time stamp;
  Pose T_world_sensor;
  ScanView view;
  std::map<std::string, std::vector<Found>> found;
};

/// True if the scan of `stop` should show a thing at `p_sensor`: in its field of view and not behind anything.
bool should_show(const Stop& stop, const Eigen::Vector2d& p_sensor, double radius, double range_max) {
  const double distance = p_sensor.norm();
  const double bearing = std::atan2(p_sensor.y(), p_sensor.x());
  if (distance > range_max || distance < 2.0 || std::abs(bearing) > kViewHalfAngle * kDegree) return false;
  const int beam = static_cast<int>(std::lround((bearing - stop.view.start) / stop.view.step));
  const int half_width = 1 + static_cast<int>(radius / distance / stop.view.step);
  const int last = static_cast<int>(stop.view.ranges.size()) - 1;
  for (int i = std::max(0, beam - half_width); i <= std::min(last, beam + half_width); ++i) {
    if (stop.view.ranges[static_cast<std::size_t>(i)] < distance - kOcclusionMargin) return false;
  }
  return true;
}

class ExtractionOnTheRecording : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (std::getenv("WAYMARK_DATA") == nullptr) return;
    const Config config =
        Config::load(WAYMARK_SOURCE_DIR "/config/victoria_park.yaml", {"maps.trees.extraction.isolation_m=3"});
    const FeatureMapSettings settings = FeatureMapSettings::read(config.items("maps").at(0));
    range_max_ = settings.extraction.range_max;
    read_scans(config, settings);
    read_published(std::string(std::getenv("WAYMARK_DATA")) + "/victoria_park/tree_detections.txt");
    for (const char* detector : {"ours", "published"}) judge(detector);
  }

  void SetUp() override {
    if (std::getenv("WAYMARK_DATA") == nullptr) GTEST_SKIP() << "WAYMARK_DATA is not set";
    ASSERT_GT(stops_.size(), 1000u);
  }

  /// The model of the recording's own notes, rear axle; the scanner is mounted 3.78 m ahead and 0.5 m to the left.
  static void read_scans(const Config& config, const FeatureMapSettings& settings) {
    constexpr double kWheelbase = 2.83;
    constexpr double kEncoderLeft = 0.76;
    const Pose T_base_sensor = Pose::planar(3.78, 0.5, 0.0);
    const Rig rig({{"wheels", "", std::nullopt}, {"lidar", "", std::nullopt}, {"gps", "", std::nullopt}});
    const auto source = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("csv", config.child("source"), rig);
    Eigen::Vector3d base = Eigen::Vector3d::Zero();
    std::optional<Time> before;
    while (const auto measurement = source->next()) {
      if (to_seconds(measurement->stamp.time_since_epoch()) > kDuration) break;
      if (measurement->payload->type() == WheelSteering::kType) {
        const auto& wheel = measurement->as<WheelSteering>();
        const double dt = before ? to_seconds(measurement->stamp - *before) : 0.0;
        const double bend = std::tan(wheel.steering_rad) / kWheelbase;
        const double speed = wheel.speed_mps / (1.0 - bend * kEncoderLeft);
        base += dt * speed * Eigen::Vector3d(std::cos(base.z()), std::sin(base.z()), bend);
        before = measurement->stamp;
      } else if (measurement->payload->type() == LaserScan::kType) {
        Stop stop;
        stop.stamp = measurement->stamp;
        stop.T_world_sensor = Pose::planar(base.x(), base.y(), base.z()) * T_base_sensor;
        auto observation = extract_cylinders(measurement->as<LaserScan>(), {}, settings);
        for (const Detection& one : observation.detections)
          stop.found["ours"].push_back({one.xyr.head<2>(), one.xyr.z()});
        stop.view = std::move(observation.view);
        stops_.push_back(std::move(stop));
      }
    }
  }

  static void read_published(const std::string& file) {
    std::map<std::int64_t, Stop*> at_ms;
    for (Stop& stop : stops_) at_ms[std::lround(1e3 * to_seconds(stop.stamp.time_since_epoch()))] = &stop;
    std::ifstream in(file);
    in.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    double time = 0.0;
    double range = 0.0;
    double bearing_from_right = 0.0;
    double diameter = 0.0;
    while (in >> time >> range >> bearing_from_right >> diameter) {
      const auto stop = at_ms.find(std::lround(1e3 * time));
      if (stop == at_ms.end() || range > range_max_) continue;
      const double bearing = bearing_from_right - 0.5 * std::numbers::pi;
      stop->second->found["published"].push_back(
          {range * Eigen::Vector2d(std::cos(bearing), std::sin(bearing)), 0.5 * diameter});
    }
  }

  static void judge(const std::string& detector) {
    for (std::size_t i = 0; i < stops_.size(); ++i) {
      for (Found& one : stops_[i].found[detector]) {
        const Eigen::Vector3d p_world =
            stops_[i].T_world_sensor * Eigen::Vector3d(one.p_sensor.x(), one.p_sensor.y(), 0.0);
        std::size_t should = 0;
        std::size_t did = 0;
        const auto ask = [&](const Stop& other) {
          const Eigen::Vector2d p = (other.T_world_sensor.inverse() * p_world).head<2>();
          if (!should_show(other, p, one.radius, range_max_)) return;
          ++should;
          const auto seen = other.found.find(detector);
          if (seen == other.found.end()) return;
          const double near = kSamePlace + kSamePlacePerRange * p.norm();
          did += std::any_of(seen->second.begin(), seen->second.end(),
                             [&](const Found& again) { return (again.p_sensor - p).norm() < near; })
                     ? 1
                     : 0;
        };
        const auto within = [&](std::size_t j) {
          return std::abs(to_seconds(stops_[j].stamp - stops_[i].stamp)) <= kWindow;
        };
        for (std::size_t j = i; j-- > 0 && within(j);) ask(stops_[j]);
        for (std::size_t j = i + 1; j < stops_.size() && within(j); ++j) ask(stops_[j]);
        one.judged = should >= kScansToJudge;
        one.persistent = one.judged && static_cast<double>(did) >= kOftenEnough * static_cast<double>(should);
      }
    }
  }

  static bool has_match(const Stop& stop, const std::string& detector, const Found& one) {
    const auto found = stop.found.find(detector);
    return found != stop.found.end() &&
           std::any_of(found->second.begin(), found->second.end(),
                       [&](const Found& other) { return (other.p_sensor - one.p_sensor).norm() < kSamePublished; });
  }

  /// Share of what `detector` found, among what `counts`, for which `holds`.
  template <class Counts, class Holds>
  static double share(const std::string& detector, Counts counts, Holds holds) {
    double all = 0.0;
    double good = 0.0;
    for (const Stop& stop : stops_) {
      const auto found = stop.found.find(detector);
      if (found == stop.found.end()) continue;
      for (const Found& one : found->second) {
        if (!counts(stop, one)) continue;
        all += 1.0;
        good += holds(stop, one) ? 1.0 : 0.0;
      }
    }
    return good / all;
  }

  static constexpr auto kJudged = [](const Stop&, const Found& one) { return one.judged; };
  static constexpr auto kPersistent = [](const Stop&, const Found& one) { return one.persistent; };

  static inline std::vector<Stop> stops_;
  static inline double range_max_ = 0.0;
};

TEST_F(ExtractionOnTheRecording, FindsWhatWasPublishedAndStands) {
  const double recall =
      share("published", kPersistent, [](const Stop& stop, const Found& one) { return has_match(stop, "ours", one); });
  RecordProperty("recall", std::to_string(recall));
  EXPECT_GE(recall, 0.95);
}

TEST_F(ExtractionOnTheRecording, IsAsPersistentAsWhatWasPublished) {
  const double ours = share("ours", kJudged, kPersistent);
  const double theirs = share("published", kJudged, kPersistent);
  RecordProperty("ours", std::to_string(ours));
  RecordProperty("published", std::to_string(theirs));
  EXPECT_GE(ours, theirs);
}

TEST_F(ExtractionOnTheRecording, WhatItFindsBeyondThePublishedStandsAsOften) {
  const auto beyond = [](const Stop& stop, const Found& one) {
    return one.judged && !has_match(stop, "published", one);
  };
  const double ours = share("ours", beyond, kPersistent);
  const double theirs = share("published", kJudged, kPersistent);
  RecordProperty("beyond", std::to_string(ours));
  EXPECT_GE(ours, theirs);
}

TEST_F(ExtractionOnTheRecording, TakesLittleThatWasNotPublished) {
  const double precision = share(
      "ours", [](const Stop&, const Found&) { return true; },
      [](const Stop& stop, const Found& one) { return has_match(stop, "published", one); });
  RecordProperty("precision", std::to_string(precision));
  // The published detector finds its own things again in as many of the scans that should see them: no detector can be
  // expected to agree with it more often than it agrees with itself.
  EXPECT_GE(precision, share("published", kJudged, kPersistent));
}

}  // namespace
}  // namespace waymark::feature_map
