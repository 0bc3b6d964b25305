// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "unit/plugins/sinks/fake_snapshot.hpp"

namespace waymark::test {

/// The sink `log` with a rig of four sensors, and what it is given; reads back what it wrote.
class LogSink : public ::testing::Test {
 protected:
  std::shared_ptr<Sink> make(const std::string& yaml = "{}") const {
    const Config config = Config::parse(yaml, (out_.path() / "robot.yaml").string());
    return PluginLoader({WAYMARK_PLUGIN_DIR}).create<Sink>("log", config, rig_);
  }
  void start(const std::string& yaml = "{}", std::shared_ptr<const Reference> reference = nullptr,
             const std::string& config = "") {
    sink_ = make(yaml);
    sink_->start({out_.path(), &rig_, std::move(reference), config});
  }

  template <class T>
  void arrive(int sensor, const T& payload, std::int64_t stamp_ns, std::int64_t arrival_ns) {
    Measurement m;
    m.stamp = Time{Duration{stamp_ns}};
    m.arrival = Time{Duration{arrival_ns}};
    m.sensor = static_cast<std::uint32_t>(sensor);
    m.sequence = sent_.size();
    m.payload = std::make_shared<T>(payload);
    sent_.push_back(m);
    sink_->arrived(m);
  }
  template <class T>
  void arrive(int sensor, const T& payload, std::int64_t stamp_ns) {
    arrive(sensor, payload, stamp_ns, stamp_ns);
  }

  /// The error that a call ends with.
  template <class Call>
  static std::string error_of(const Call& call) {
    try {
      call();
    } catch (const Error& error) {
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return "";
  }

  /// Ends the log and reads it with the csv source, as source.yaml says.
  std::vector<Measurement> read_back() {
    sink_->finish(nullptr, {});
    source_ = PluginLoader({WAYMARK_PLUGIN_DIR})
                  .create<Source>("csv", Config::load(out_.path() / "log/source.yaml").child("source"), rig_);
    std::vector<Measurement> all;
    while (auto m = source_->next()) {
      m->sensor = static_cast<std::uint32_t>(rig_.find(source_->channels()[m->sensor].sensor));
      all.push_back(std::move(*m));
    }
    return all;
  }
  /// The same, and what is read must have come as it was sent. Returns the payloads.
  template <class T>
  std::vector<T> same_order() {
    const std::vector<Measurement> got = read_back();
    EXPECT_EQ(got.size(), sent_.size());
    std::vector<T> payloads;
    for (std::size_t i = 0; i < std::min(got.size(), sent_.size()); ++i) {
      EXPECT_EQ(got[i].sensor, sent_[i].sensor) << i;
      EXPECT_EQ(got[i].stamp, sent_[i].stamp) << i;
      EXPECT_EQ(got[i].arrival, sent_[i].arrival) << i;
      EXPECT_EQ(got[i].sequence, i);
      if (got[i].payload->type() == T::kType) payloads.push_back(got[i].as<T>());
    }
    return payloads;
  }

  static WheelSpeeds wheels(double left_mps, double right_mps = 0.0) {
    WheelSpeeds speeds;
    speeds.left_mps = left_mps;
    speeds.right_mps = right_mps;
    return speeds;
  }
  static Image image(Image::Encoding encoding, std::vector<std::uint8_t> data, int width = 0, int height = 0) {
    Image image;
    image.encoding = encoding;
    image.width = width;
    image.height = height;
    image.data = std::move(data);
    return image;
  }
  static LaserScan scan(std::vector<float> ranges, double start_rad = -0.1) {
    LaserScan scan;
    scan.start_rad = start_rad;
    scan.step_rad = 0.1;
    scan.ranges_m = std::move(ranges);
    return scan;
  }

  TemporaryFolder out_;
  Rig rig_{{{"wheels", "", {}}, {"front lidar", "", {}}, {"camera", "", {}}, {"gps", "", {}}}};
  std::shared_ptr<Sink> sink_;
  std::shared_ptr<Source> source_;
  std::vector<Measurement> sent_;
};

}  // namespace waymark::test
