// SPDX-License-Identifier: Apache-2.0
// Small bags, written by the test.
#pragma once

#include <bzlib.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <lz4frame.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "temporary_folder.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::rosbag1_test {

template <class T>
std::string bytes_of(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

/// Numbers one after the other, as ROS serializes them.
template <class T>
std::string packed(std::initializer_list<T> values) {
  std::string out;
  for (const T value : values) out += bytes_of(value);
  return out;
}

inline std::string counted(std::string_view text) {
  return bytes_of(static_cast<std::uint32_t>(text.size())) + std::string(text);
}

inline std::string time_bytes(std::int64_t nanoseconds) {
  return bytes_of(static_cast<std::uint32_t>(nanoseconds / 1'000'000'000)) +
         bytes_of(static_cast<std::uint32_t>(nanoseconds % 1'000'000'000));
}

/// std_msgs/Header
inline std::string header(std::int64_t stamp) { return bytes_of(7U) + time_bytes(stamp) + counted("frame"); }

inline std::string covariance(std::size_t count, double first) {
  std::string out = bytes_of(first);
  for (std::size_t i = 1; i < count; ++i) out += bytes_of(0.25);
  return out;
}

struct Type {
  std::string name;
  std::string md5;
};
inline const Type kImu{"sensor_msgs/Imu", "6a62c6daae103f4ff57a132d6f95cec2"};
inline const Type kFix{"sensor_msgs/NavSatFix", "2d3a8cd499b9b4a0249fb98fd05cfa48"};
inline const Type kOdometry{"nav_msgs/Odometry", "cd5e73d190d741a2f92e81eda573aca7"};
inline const Type kTwist{"geometry_msgs/TwistStamped", "98d34b0043a2093cf9d9345ab6eef12e"};
inline const Type kTwistWithCovariance{"geometry_msgs/TwistWithCovarianceStamped", "8927a1a12fb2607ceea095b2dc440a96"};
inline const Type kField{"sensor_msgs/MagneticField", "2f3b0b43eed0c9501de0fa3ff89a45aa"};
inline const Type kScan{"sensor_msgs/LaserScan", "90c7ef2dc6895d81024acba2ac42f369"};
inline const Type kCloud{"sensor_msgs/PointCloud2", "1158d486dd51d683ce2f1be655c3c181"};
inline const Type kImage{"sensor_msgs/Image", "060021388200f6f0f447d0fcd9c64743"};
inline const Type kCompressed{"sensor_msgs/CompressedImage", "8f7a12909da2c9d3332d540a0977563f"};

/// A twist of (v, 0.1, 0) and (0, 0, w).
inline std::string twist_message(std::int64_t stamp, double v, double w = 0.5) {
  return header(stamp) + packed({v, 0.1, 0.0, 0.0, 0.0, w});
}

struct ImuFields {
  std::vector<double> q{0.0, 0.0, 0.0, 1.0};  // x, y, z, w
  double q_variance = 0.01;
  std::vector<double> w{0.1, 0.2, 0.3};
  double w_variance = 0.01;
  std::vector<double> f{0.0, 0.0, 9.81};
  double f_variance = 0.01;
};

inline std::string imu_message(std::int64_t stamp, const ImuFields& fields) {
  std::string out = header(stamp);
  for (const auto& [values, variance] :
       {std::pair(fields.q, fields.q_variance), {fields.w, fields.w_variance}, {fields.f, fields.f_variance}}) {
    for (const double value : values) out += bytes_of(value);
    out += covariance(9, variance);
  }
  return out;
}

inline std::string fix_message(std::int64_t stamp, int status, double latitude, std::uint8_t covariance_type = 2) {
  return header(stamp) + bytes_of(static_cast<std::int8_t>(status)) + bytes_of(std::uint16_t{1}) +
         packed({latitude, 8.5, 112.0}) + packed({0.5, 0.0, 0.0, 0.0, 1.5, 0.0, 0.0, 0.0, 4.0}) +
         bytes_of(covariance_type);
}

inline std::string odometry_message(std::int64_t stamp, double z, double v) {
  std::string pose_covariance;
  for (int i = 0; i < 36; ++i) pose_covariance += bytes_of(i == 14 ? 0.04 : 0.0);
  return header(stamp) + counted("base_link") + packed({1.0, 2.0, z}) + packed({0.0, 0.0, 0.0, 0.0}) + pose_covariance +
         packed({v, 0.2, 0.0, 0.0, 0.0, -0.3}) + covariance(36, 0.1);
}

/// Writes bags of format 2.0.
class BagWriter {
 public:
  BagWriter() {
    const std::string fields = field("op", bytes_of(std::uint8_t{3})) + field("index_pos", bytes_of(std::uint64_t{0})) +
                               field("conn_count", bytes_of(0U)) + field("chunk_count", bytes_of(0U));
    bytes_ = "#ROSBAG V2.0\n" + record(fields, std::string(40, ' '));
  }

  /// A connection; its record goes into the current chunk.
  std::uint32_t connect(const std::string& topic, const Type& type) {
    const auto number = static_cast<std::uint32_t>(connections_.size());
    const std::string fields =
        field("op", bytes_of(std::uint8_t{7})) + field("conn", bytes_of(number)) + field("topic", topic);
    const std::string data = field("topic", topic) + field("type", type.name) + field("md5sum", type.md5) +
                             field("message_definition", "float64 x");
    connections_.push_back(record(fields, data));
    chunk_ += connections_.back();
    return number;
  }

  void add(std::uint32_t connection, std::int64_t recorded, const std::string& message) {
    index_[connection] += time_bytes(recorded) + bytes_of(static_cast<std::uint32_t>(chunk_.size()));
    chunk_ += record(field("op", bytes_of(std::uint8_t{2})) + field("conn", bytes_of(connection)) +
                         field("time", time_bytes(recorded)),
                     message);
  }

  /// Writes what was added since the last one.
  void end_chunk(const std::string& compression = "none") {
    const std::string fields = field("op", bytes_of(std::uint8_t{5})) + field("compression", compression) +
                               field("size", bytes_of(static_cast<std::uint32_t>(chunk_.size())));
    bytes_ += record(fields, compressed(compression));
    for (const auto& [connection, entries] : index_) {
      bytes_ += record(field("op", bytes_of(std::uint8_t{4})) + field("ver", bytes_of(1U)) +
                           field("conn", bytes_of(connection)) +
                           field("count", bytes_of(static_cast<std::uint32_t>(entries.size() / 12))),
                       entries);
    }
    index_.clear();
    chunk_.clear();
  }

  /// The file as far as it is, as after a loss of power.
  const std::string& unclosed() const { return bytes_; }
  /// With the connections at the end.
  std::string closed() const {
    std::string out = bytes_;
    for (const std::string& connection : connections_) out += connection;
    return out;
  }

  static std::string field(std::string_view name, std::string_view value) {
    return counted(std::string(name) + "=" + std::string(value));
  }
  static std::string record(const std::string& fields, const std::string& data) {
    return counted(fields) + counted(data);
  }

 private:
  std::string compressed(const std::string& compression) const {
    if (compression == "bz2") {
      auto size = static_cast<unsigned>(chunk_.size() + 1000);
      std::string out(size, ' ');
      EXPECT_EQ(BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(chunk_.data()),
                                         static_cast<unsigned>(chunk_.size()), 1, 0, 0),
                BZ_OK);
      return out.substr(0, size);
    }
    if (compression == "lz4") {
      std::string out(LZ4F_compressFrameBound(chunk_.size(), nullptr), ' ');
      return out.substr(0, LZ4F_compressFrame(out.data(), out.size(), chunk_.data(), chunk_.size(), nullptr));
    }
    return chunk_;
  }

  std::string bytes_;
  std::string chunk_;
  std::map<std::uint32_t, std::string> index_;
  std::vector<std::string> connections_;
};

/// A folder with bags, and sources whose YAML lies beside them.
class Rosbag1Test : public ::testing::Test {
 protected:
  void write(const std::string& name, std::string_view content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }
  void write_bag(const BagWriter& bag) const { write("a.bag", bag.closed()); }

  std::shared_ptr<Source> make(const std::string& channels, const std::string& more = "file: a.bag") const {
    const std::string yaml = more + "\nchannels: [" + channels + "]\n";
    const Config config = Config::parse(yaml, (folder_ / "run.yaml").string());
    auto source = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("rosbag1", config, rig_);
    config.reject_unread();
    return source;
  }

  static std::vector<Measurement> read_all(Source& source) {
    std::vector<Measurement> all;
    while (auto measurement = source.next()) all.push_back(std::move(*measurement));
    return all;
  }
  /// The measurements of a bag with one chunk and one message.
  std::vector<Measurement> one(const Type& type, const std::string& message, const std::string& more = "") const {
    BagWriter bag;
    bag.add(bag.connect("/x", type), 5'000'000'000, message);
    bag.end_chunk();
    write_bag(bag);
    const auto source = make("{ topic: /x, sensor: a" + more + " }", "file: a.bag\nmax_bad_records: 1");
    auto all = read_all(*source);
    bad_ = source->bad_records().empty() ? "" : source->bad_records().front().reason;
    return all;
  }

  test::TemporaryFolder folder_;
  mutable std::string bad_;  // what `one` skipped
  Rig rig_{{{"a", "", std::nullopt}, {"b", "", std::nullopt}, {"lidar", "waymark/LaserScan@1", std::nullopt}}};
};

}  // namespace waymark::rosbag1_test
