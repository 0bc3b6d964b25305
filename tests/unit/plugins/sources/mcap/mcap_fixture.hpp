// SPDX-License-Identifier: Apache-2.0
// Small MCAP files of ROS 2, written by the test.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "plugins/shared/cdr/definition_text.hpp"
#include "plugins/shared/cdr/message.hpp"
#include "plugins/shared/cdr/ros/geometry_msgs.hpp"
#include "plugins/shared/cdr/ros/nav_msgs.hpp"
#include "plugins/shared/cdr/ros/sensor_msgs.hpp"
#include "plugins/shared/mcap/writer.hpp"
#include "temporary_folder.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::mcap_test {

inline ros::std_msgs::Header header(std::int64_t stamp) {
  return {{static_cast<std::int32_t>(stamp / 1'000'000'000), static_cast<std::uint32_t>(stamp % 1'000'000'000)},
          "base"};
}

inline ros::geometry_msgs::TwistStamped twist(std::int64_t stamp, double v) {
  return {header(stamp), {{v, 0.1, 0.0}, {0.0, 0.0, 0.5}}};
}

inline ros::nav_msgs::Odometry odometry(std::int64_t stamp, double x, double z) {
  ros::nav_msgs::Odometry message;
  message.header = header(stamp);
  message.pose.pose.position = {x, 0.0, z};
  message.pose.covariance[14] = 0.04;
  message.twist.twist.linear.x = 1.5;
  return message;
}

/// Writes topics of ROS 2.
class TopicWriter {
 public:
  explicit TopicWriter(mcap::WriterOptions options = {}) : writer_(std::move(options)) {}

  template <ros::Message M>
  void add(const std::string& topic, std::int64_t recorded, const M& message) {
    add(topic, std::string(M::kType), ros::definition_text<M>(), recorded, ros::to_cdr(message));
  }
  void add(const std::string& topic, const std::string& type, const std::string& definition, std::int64_t recorded,
           const std::vector<std::uint8_t>& message) {
    auto [channel, is_new] = channels_.try_emplace(topic, static_cast<std::uint16_t>(channels_.size() + 1));
    if (is_new) {
      writer_.add(mcap::Schema{channel->second, type, "ros2msg", {definition.begin(), definition.end()}});
      writer_.add(mcap::Channel{channel->second, channel->second, topic, "cdr", {}});
    }
    const auto time = static_cast<std::uint64_t>(recorded);
    writer_.add(mcap::Message{channel->second, 0, time, time, message});
  }
  mcap::Writer& writer() { return writer_; }
  std::vector<std::uint8_t> finish() {
    writer_.finish();
    return writer_.take();
  }

 private:
  mcap::Writer writer_;
  std::map<std::string, std::uint16_t> channels_;
};

/// A folder with files, and sources whose YAML lies beside them.
class SourceTest : public ::testing::Test {
 protected:
  explicit SourceTest(std::string plugin) : plugin_(std::move(plugin)) {}

  void write(const std::string& name, const std::vector<std::uint8_t>& content) const {
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(content.data()), static_cast<std::streamsize>(content.size()));
  }
  std::shared_ptr<Source> make(const std::string& channels, const std::string& more = "file: a.mcap") const {
    return make_of(more + "\nchannels: [" + channels + "]\n");
  }
  std::shared_ptr<Source> make_of(const std::string& yaml) const {
    const Config config = Config::parse(yaml, (folder_ / "run.yaml").string());
    auto source = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>(plugin_, config, rig_);
    config.reject_unread();
    return source;
  }
  template <class E = ConfigError>
  std::string error_of(const std::string& channels, const std::string& more = "file: a.mcap") const {
    try {
      read_all(*make(channels, more));
    } catch (const E& error) {
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return {};
  }
  static std::vector<Measurement> read_all(Source& source) {
    std::vector<Measurement> all;
    while (auto measurement = source.next()) all.push_back(std::move(*measurement));
    return all;
  }

  test::TemporaryFolder folder_;
  Rig rig_{{{"a", "", std::nullopt}, {"b", "", std::nullopt}, {"lidar", "waymark/LaserScan@1", std::nullopt}}};

 private:
  std::string plugin_;
};

class McapSourceTest : public SourceTest {
 protected:
  McapSourceTest() : SourceTest("mcap") {}
};

}  // namespace waymark::mcap_test
