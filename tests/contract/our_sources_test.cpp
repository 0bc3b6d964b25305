// SPDX-License-Identifier: Apache-2.0
// needs plugins: altimeter, carmen, clouds, csv, json, kitti, nmea, rosbag1, simulator
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "our_plugins.hpp"
#include "temporary_folder.hpp"
#include "unit/plugins/sources/clouds/clouds_fixture.hpp"
#include "unit/plugins/sources/rosbag1/rosbag1_fixture.hpp"
#include "waymark/testing/source_contract.hpp"

namespace waymark::contract_test {
namespace {

using testing::check_source;
using testing::to_text;

TEST(OurSources, TheSimulatorKeepsTheContract) {
  EXPECT_EQ(to_text(check_source([] { return make<Source>("simulator", kSimulation); })), "");
}

TEST(OurSources, TheSimulatorsCloudsKeepTheContract) {
  // The rig mounts "altimeter" below the base, so there is no ground to see.
  const std::string clouds =
      "{ duration_s: 20, course: { waypoints_m: [0, 0, 12, 0, 12, 8, 0, 8] }, ground: false,"
      "  walls_m: [-3, -3, 15, -3, 15, -3, 15, 11],"
      "  lidar_3d: { sensor: altimeter, rate_hz: 2, sweep_s: 0.1, beams: 90, step_deg: 4 } }";
  EXPECT_EQ(to_text(check_source([&] { return make<Source>("simulator", clouds); })), "");
}

class OurCsv : public ::testing::Test {
 protected:
  OurCsv() {
    std::ofstream wheels(folder_ / "wheels.csv");
    std::ofstream scans(folder_ / "scans.csv");
    std::ofstream seen(folder_ / "seen.csv");
    std::ofstream inertial(folder_ / "inertial.csv");
    std::ofstream headings(folder_ / "headings.csv");
    std::ofstream images(folder_ / "images.csv");
    std::ofstream(folder_ / "one.jpg") << "\xff\xd8 one";
    std::ofstream(folder_ / "two.jpg") << "\xff\xd8 two";
    wheels << "t,left,right\n";
    scans << "t,r0,r1,r2\n";
    seen << "t,range,bearing,id\n";
    inertial << "t,wx,wy,wz,mx,my,mz\n";
    headings << "t,heading\n";
    images << "t,file\n";
    for (int k = 0; k < 60; ++k) {
      wheels << 0.1 * k << "," << 1.0 + 0.01 * k << "," << (k == 17 ? "fault" : "1.1") << "\n";
      if (k % 3 == 0) scans << 0.1 * k << ",4.5," << 3.0 + 0.1 * k << ",81\n";
      inertial << 0.1 * k << ",0.01,0.02," << 0.1 * k << (k % 5 == 0 ? ",1e-6,2e-6,-3e-6\n" : ",,,\n");
      if (k % 6 == 1) headings << 0.1 * k << "," << 0.02 * k << "\n";
      if (k % 5 == 2) images << 0.1 * k << (k % 2 == 0 ? ",one.jpg\n" : k == 17 ? ",nowhere.jpg\n" : ",two.jpg\n");
      if (k % 4 < 2) seen << 0.4 * (k / 4) << "," << 2.0 + 0.1 * k << ",0.2," << k % 4 << "\n";
    }
  }

  std::shared_ptr<Source> source() const {
    const std::string yaml =
        "max_bad_rows: 2\n"
        "files:\n"
        "  - { path: wheels.csv, sensor: wheels, payload: WheelSpeeds, time: t, columns: { left_mps: left, right_mps: "
        "right } }\n"
        "  - { path: scans.csv, sensor: lidar, payload: LaserScan, time: t, arrival: { column: t, offset_s: 0.25 },"
        " columns: { ranges_m: { first: r0, last: r2 } }, scan: { start_deg: -1, step_deg: 1 } }\n"
        "  - { path: seen.csv, sensor: gps, payload: LandmarkObservations, time: t, group_by_time: true,"
        " columns: { range_m: range, bearing_rad: bearing, identity: id } }\n"
        "  - { path: inertial.csv, sensor: wheels, payload: ImuSample, time: t, empty_is_unknown: true,"
        " columns: { w_x_radps: wx, w_y_radps: wy, w_z_radps: wz, m_x_t: mx, m_y_t: my, m_z_t: mz } }\n"
        "  - { path: headings.csv, sensor: wheels, payload: CompassHeading, time: t,"
        " columns: { heading_rad: heading } }\n"
        "  - { path: images.csv, sensor: lidar, payload: Image, time: t, columns: { file: file } }\n";
    const Config config = Config::parse(yaml, (folder_ / "run.yaml").string());
    return PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("csv", config, rig());
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(OurCsv, KeepsTheContract) {
  EXPECT_EQ(to_text(check_source([&] { return source(); })), "");
}

/// A raw recording of 12 frames; one image is missing and one cloud is cut off.
class OurKitti : public ::testing::Test {
 protected:
  OurKitti() {
    const std::filesystem::path clouds = folder_ / "velodyne_points/data";
    const std::filesystem::path images = folder_ / "image_02/data";
    std::filesystem::create_directories(clouds);
    std::filesystem::create_directories(images);
    for (int k = 0; k < 12; ++k) {
      const std::string number = std::to_string(1000 + k);
      const std::array<float, 8> points{5.0f + 0.1f * static_cast<float>(k), 0.0f, 1.0f, 0.3f, 0.0f, 7.0f, 1.2f, 0.2f};
      std::ofstream(clouds / (number + ".bin"), std::ios::binary)
          .write(reinterpret_cast<const char*>(points.data()), k == 8 ? 13 : sizeof points);
      if (k != 4) std::ofstream(images / (number + ".png"), std::ios::binary) << "picture " << k;
    }
  }

  std::shared_ptr<Source> source() const {
    const std::string yaml =
        "{ folder: " + folder_.path().string() +
        ", calibration: none, max_bad_records: 2, lidar: { sensor: lidar, height_m: [0.5, 1.5], step_deg: 10 },"
        "  camera: { sensor: camera } }";
    return PluginLoader({WAYMARK_PLUGIN_DIR})
        .create<Source>("kitti", Config::parse(yaml), Rig({{"lidar", "", Pose{}}, {"camera", "", {}}}));
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(OurKitti, KeepsTheContract) {
  testing::SourceSetting setting;
  setting.content = [](const Payload& payload) {
    if (payload.type() != Image::kType) return std::string();
    const auto& image = static_cast<const Image&>(payload);
    return std::string(image.data.begin(), image.data.end());
  };
  EXPECT_EQ(to_text(check_source([&] { return source(); }, setting)), "");
  const auto log = source();
  int measurements = 0;
  while (log->next()) ++measurements;
  EXPECT_EQ(measurements, 22);
  EXPECT_EQ(log->bad_records().size(), 2U);
}

TEST(OurCarmen, KeepsTheContract) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "recording.log";
  {
    std::ofstream out(file, std::ios::binary);
    for (int k = 0; k < 40; ++k) {
      const double t = 100.0 + 0.2 * k - (k % 9 == 5 ? 0.3 : 0.0);  // some step back
      const std::string end = " " + std::to_string(t) + " host 0\n";
      out << "ODOM 0 0 0 " << (k % 5 == 0 ? -0.2 : 0.2) << " 0 0" << end;
      out << "NMEAGGA 1 0 4930.5 N 830.1 E 1 8 1.5 100 0 48 0 0" << end;
      if (k == 11) out << "FLASER 3 1.0\n";
      out << "FLASER 2 1.5 2.5 0 0 0 " << 0.1 * k << " 0 " << 0.01 * k << end;
    }
  }
  const std::string yaml = "{ file: " + file.string() +
                           ", max_bad_records: 1, wheels: { sensor: wheels }, gnss: { sensor: gps },"
                           " lasers: [{ message: FLASER, sensor: lidar, start_deg: -90, step_deg: 180 }] }";
  EXPECT_EQ(to_text(check_source([&] { return make<Source>("carmen", yaml); })), "");
}

TEST(OurClouds, KeepsTheContract) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "clouds.bin";
  {
    using namespace clouds_test;
    std::string bytes = full_head(40, 3);
    for (int k = 0; k < 40; ++k) {
      const auto value = static_cast<float>(k);
      const std::int64_t t = (k == 17 ? 5 : k) * 100'000'000LL;  // one is not later
      bytes += full_cloud(t, 2, {value, 1.0f, 2.0f, 7.0f, 0.0f, 3.0f, value, 4.0f, 8.0f, 0.01f});
    }
    std::ofstream(file, std::ios::binary) << bytes;
  }
  const std::string yaml = "{ file: " + file.string() + ", sensor: lidar, max_bad_records: 1, start_s: 0.25 }";
  EXPECT_EQ(to_text(check_source([&] { return make<Source>("clouds", yaml); })), "");
}

TEST(OurJson, KeepsTheContract) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "recording.jsonl";
  {
    std::ofstream out(file, std::ios::binary);
    for (int k = 0; k < 40; ++k) {
      out << "{\"sensor\":\"wheels\",\"stamp\":" << 100 + k << ".25,\"left_mps\":1,\"right_mps\":0." << k << "}\n";
      out << "{\"sensor\":\"gps\",\"stamp\":" << 99 + k << ".9,\"east_m\":" << k << ",\"north_m\":2}\n";
      if (k == 17) out << "fault\n{\"sensor\":\"nobody\"}\n";
      out << "{\"sensor\":\"lidar\",\"stamp_ns\":" << 100 + k
          << "300000000,\"start_rad\":0,\"step_rad\":0.1,\"ranges_m\":[1,null," << k << "]}\n";
    }
  }
  const std::string yaml = "{ from: file, file: " + file.string() +
                           ", max_bad_records: 2, channels: [{ sensor: wheels, payload: WheelSpeeds },"
                           " { sensor: gps, payload: GnssFix }, { sensor: lidar, payload: LaserScan }] }";
  EXPECT_EQ(to_text(check_source([&] { return make<Source>("json", yaml); })), "");
}

TEST(OurNmea, KeepsTheContract) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "recording.nmea";
  {
    std::ofstream out(file, std::ios::binary);
    for (int k = 0; k < 30; ++k) {
      const std::string time = "1200" + std::to_string(10 + k);
      if (k % 3 == 0) out << "$GPRMC," << time << ",A,4930.0,N,00830.0,E,1.0,90.0,010125,,,A\r\n";
      out << "$GPGGA," << time << ",4930.0" << k << ",N,00830.0,E," << (k % 7 == 6 ? 0 : 1) << ",08,1.5,100,M,47,M,,\n";
      out << (k == 11 ? "noise\n" : "$GPHDT,12.5,T\n");
    }
  }
  const std::string yaml = "{ file: " + file.string() +
                           ", require_checksum: false, delay_s: 0.1, gnss: { sensor: gps },"
                           " heading: { sensor: imu } }";
  EXPECT_EQ(to_text(check_source([&] { return make<Source>("nmea", yaml); })), "");
}

TEST(OurRosbag1, KeepsTheContract) {
  using namespace rosbag1_test;
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "recording.bag";
  BagWriter bag;
  const auto odometry = bag.connect("/odom", kOdometry);
  const auto imu = bag.connect("/imu", kImu);
  for (int k = 1; k <= 60; ++k) {
    const std::int64_t time = 100'000'000LL * k;
    bag.add(odometry, time, k == 17 ? "fault" : odometry_message(time - 1'000'000 * (k % 3), 0.1 * k, 1.0));
    bag.add(imu, time + 5'000'000, imu_message(time - 20'000'000, {}));
    if (k % 20 == 0) bag.end_chunk(k == 20 ? "bz2" : "lz4");
  }
  std::ofstream(file, std::ios::binary) << bag.closed() << "cut";
  const std::string yaml = "{ file: " + file.string() +
                           ", max_bad_records: 4, channels: [{ topic: /odom, sensor: wheels },"
                           " { topic: /odom, sensor: gps, payload: Height }, { topic: /imu, sensor: imu }], arrival: ";
  for (const char* arrival : {"recorded }", "stamp }"})
    EXPECT_EQ(to_text(check_source([&] { return make<Source>("rosbag1", yaml + arrival); })), "");
}

}  // namespace
}  // namespace waymark::contract_test
