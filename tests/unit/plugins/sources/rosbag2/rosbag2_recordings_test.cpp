// SPDX-License-Identifier: Apache-2.0
// needs plugins: rosbag1
// A recorded bag of ROS 2, and one of ROS 1 of the same robot, against the tables that lie beside them.
#include <gmock/gmock.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "db3_log.hpp"
#include "plugins/shared/compression/unpacked_file.hpp"
#include "unit/plugins/sources/mcap/mcap_fixture.hpp"

namespace waymark::rosbag2_test {
namespace {

using testing::IsEmpty;

std::string unpacked(const std::filesystem::path& file) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(::gzopen(file.c_str(), "rb"), ::gzclose);
  std::string content;
  std::vector<char> piece(1 << 16);
  for (int got = 1; got > 0;) {
    got = ::gzread(in.get(), piece.data(), static_cast<unsigned>(piece.size()));
    if (got > 0) content.append(piece.data(), static_cast<std::size_t>(got));
  }
  return content;
}

template <class T>
T value_at(const std::string& bytes, std::size_t& at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  at += sizeof value;
  return value;
}

struct Param {
  std::string plugin;
  std::string name;
  std::string ending;
  std::size_t scans;
  std::size_t poses;
};

class JackalRecording : public testing::TestWithParam<Param> {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("WAYMARK_DATA");
    if (folder == nullptr) GTEST_SKIP() << "WAYMARK_DATA is not set";
    data_ = std::filesystem::path(folder) / "jackal_mocap_scan";
  }
  std::vector<Measurement> read(const std::string& channel) const {
    // The bags of ROS 1 are not read from packed files.
    const compression::UnpackedFile file(data_ / (GetParam().name + GetParam().ending + ".gz"));
    const Config config =
        Config::parse("{ file: " + file.path().string() + ", arrival: stamp, channels: [" + channel + "] }");
    const Rig rig({{"lidar", "", std::nullopt}, {"pose", "", std::nullopt}});
    const auto source = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>(GetParam().plugin, config, rig);
    std::vector<Measurement> all;
    while (auto m = source->next()) all.push_back(std::move(*m));
    EXPECT_THAT(source->bad_records(), IsEmpty());
    return all;
  }

  std::filesystem::path data_;
};

TEST_P(JackalRecording, ScansAreThoseOfTheTable) {
  const std::string table = unpacked(data_ / (GetParam().name + "_scans.bin.gz"));
  std::size_t at = 8;
  const auto count = value_at<std::uint32_t>(table, at);
  const auto beams = value_at<std::uint32_t>(table, at);
  const auto start = value_at<float>(table, at);
  const auto step = value_at<float>(table, at);
  const auto scans = read("{ topic: /scan, sensor: lidar }");
  ASSERT_EQ(count, GetParam().scans);
  ASSERT_EQ(scans.size(), count);
  for (const Measurement& m : scans) {
    const auto& scan = m.as<LaserScan>();
    const auto stamp = value_at<double>(table, at);
    at += sizeof(double);  // time of recording
    EXPECT_NEAR(to_seconds(m.stamp.time_since_epoch()), stamp, 1e-6);
    EXPECT_EQ(static_cast<float>(scan.start_rad), start);
    EXPECT_EQ(static_cast<float>(scan.step_rad), step);
    ASSERT_EQ(scan.ranges_m.size(), beams);
    for (const float range : scan.ranges_m) {
      const auto mm = value_at<std::uint16_t>(table, at);
      if (mm == 0) {
        EXPECT_TRUE(range == 0.0f || std::isinf(range) || range > 65.0f) << range;
      } else {
        ASSERT_LE(std::abs(1000.0f * range - static_cast<float>(mm)), 0.501f);
      }
    }
  }
}

TEST_P(JackalRecording, PosesAreThoseOfTheTable) {
  std::istringstream table(unpacked(data_ / (GetParam().name + "_mocap.csv.gz")));
  std::string line;
  std::getline(table, line);
  std::vector<double> heights;
  std::vector<double> stamps;
  while (std::getline(table, line)) {
    double t = 0.0;
    double z = 0.0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%*f,%*f,%*f,%lf", &t, &z), 2) << line;
    stamps.push_back(t);
    heights.push_back(z);
  }
  const auto poses = read("{ topic: /vrpn_client_node/jackal/pose, sensor: pose, payload: Height }");
  ASSERT_EQ(poses.size(), GetParam().poses);
  ASSERT_EQ(heights.size(), poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_NEAR(to_seconds(poses[i].stamp.time_since_epoch()), stamps[i], 1e-6);
    EXPECT_NEAR(poses[i].as<Height>().height_m, heights[i], 5e-4);
  }
}

TEST(JackalDb3, WholePosesAreThoseOfTheTable) {
  const char* folder = std::getenv("WAYMARK_DATA");
  if (folder == nullptr) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const std::filesystem::path data = std::filesystem::path(folder) / "jackal_mocap_scan";
  std::istringstream table(unpacked(data / "2026-02-17-15-18-31_mocap.csv.gz"));
  std::string line;
  std::getline(table, line);
  rosbag2::Db3Log log(data / "2026-02-17-15-18-31.db3.gz");
  std::set<std::size_t> wanted;
  for (std::size_t i = 0; i < log.topics().size(); ++i) {
    if (log.topics()[i].name == "/vrpn_client_node/jackal/pose") wanted.insert(i);
  }
  log.select(wanted);
  BadRecordList bad(0, {"record", "none", "none"});
  std::size_t count = 0;
  for (; std::getline(table, line); ++count) {
    const auto message = log.next(bad);
    ASSERT_TRUE(message);
    const auto pose = ros::from_cdr<ros::geometry_msgs::PoseStamped>(message->data).pose;
    std::array<double, 9> row{};
    std::istringstream in(line);
    for (double& value : row) {
      std::string field;
      std::getline(in, field, ',');
      value = std::stod(field);
    }
    const std::array<double, 7> ours{pose.position.x,    pose.position.y,    pose.position.z,   pose.orientation.x,
                                     pose.orientation.y, pose.orientation.z, pose.orientation.w};
    for (std::size_t i = 0; i < ours.size(); ++i) ASSERT_NEAR(ours[i], row[i + 2], 1e-5) << count;
    EXPECT_NEAR(to_seconds(message->recorded.time_since_epoch()), row[1], 1e-6);
  }
  EXPECT_FALSE(log.next(bad));
  EXPECT_EQ(count, 4315U);
}

INSTANTIATE_TEST_SUITE_P(Bags, JackalRecording,
                         testing::Values(Param{"rosbag2", "2026-02-17-15-18-31", ".db3", 359, 4315},
                                         Param{"rosbag1", "2026-02-17-16-26-34", ".bag", 431, 5206}),
                         [](const auto& one) { return one.param.plugin; });

}  // namespace
}  // namespace waymark::rosbag2_test
