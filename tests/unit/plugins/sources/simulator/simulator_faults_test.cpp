// SPDX-License-Identifier: Apache-2.0
// Faults that every simulated sensor can have: of time, silence, NaN.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "simulated_log.hpp"

namespace waymark {
namespace {

using test::kLoop;
using test::make_with;
using test::read_all;

Rig rig() {
  std::vector<Mounting> mountings;
  for (const char* name : {"wheels", "gps", "lidar", "imu", "compass"})
    mountings.push_back({.name = name, .payload = "", .T_base_sensor = Pose{}});
  return Rig(mountings);
}

std::shared_ptr<Source> simulate(const std::string& sensors) { return make_with(rig(), kLoop + sensors + "}"); }

double seconds(Time time) { return to_seconds(time.time_since_epoch()); }

/// What a measurement says, bit by bit: NaN is equal to NaN.
std::vector<std::uint64_t> bits_of(const Payload& payload) {
  std::vector<double> values;
  const auto add = [&](const Eigen::Vector3d& v) { values.insert(values.end(), v.begin(), v.end()); };
  if (payload.type() == WheelSpeeds::kType) {
    const auto& wheels = static_cast<const WheelSpeeds&>(payload);
    values = {wheels.left_mps, wheels.right_mps};
  } else if (payload.type() == GnssFix::kType) {
    add(static_cast<const GnssFix&>(payload).p_map_antenna);
  } else if (payload.type() == ImuSample::kType) {
    const auto& imu = static_cast<const ImuSample&>(payload);
    add(imu.w_sensor);
    add(imu.f_sensor);
    add(imu.m_sensor);
  } else if (payload.type() == CompassHeading::kType) {
    values = {static_cast<const CompassHeading&>(payload).heading_rad};
  } else {
    const auto& ranges = static_cast<const LaserScan&>(payload).ranges_m;
    values.assign(ranges.begin(), ranges.end());
  }
  std::vector<std::uint64_t> bits;
  for (const double value : values) bits.push_back(std::bit_cast<std::uint64_t>(value));
  return bits;
}

bool has_nan(const Payload& payload) {
  return std::ranges::any_of(bits_of(payload), [](std::uint64_t b) { return std::isnan(std::bit_cast<double>(b)); });
}

/// By stamp: what order the measurements arrive in does not matter.
std::map<Time, std::vector<std::uint64_t>> contents(const std::vector<Measurement>& all, std::string_view type) {
  std::map<Time, std::vector<std::uint64_t>> of;
  for (const Measurement& m : all) {
    if (m.payload->type() == type) of[m.stamp] = bits_of(*m.payload);
  }
  return of;
}

const std::string kOthers =
    ", lidar: { sensor: lidar, beams: 9, step_deg: 30 }, imu: { sensor: imu, rate_hz: 20 }, compass: { sensor: compass "
    "}";
const std::string kPlain =
    ", wheels: { sensor: wheels, track_m: 0.5 }, gps: { sensor: gps, correlated_sigma_m: 0.5 }" + kOthers;

TEST(SimulatorFaults, JitterReordersAndChangesNoMeasurement) {
  const auto plain = read_all(*simulate(kPlain));
  const auto late = read_all(
      *simulate(", wheels: { sensor: wheels, track_m: 0.5, delay_s: 0.1, delay_jitter_s: 0.5 },"
                "  gps: { sensor: gps, correlated_sigma_m: 0.5, delay_jitter_s: 2, delay_jitter_law: exponential }" +
                kOthers));
  ASSERT_EQ(late.size(), plain.size());
  for (const auto type :
       {WheelSpeeds::kType, GnssFix::kType, LaserScan::kType, ImuSample::kType, CompassHeading::kType})
    EXPECT_EQ(contents(late, type), contents(plain, type)) << type;
  std::map<std::uint32_t, Time> newest;
  std::map<std::uint32_t, int> overtaken;
  std::vector<double> wheels;
  std::vector<double> fixes;
  for (std::size_t i = 0; i < late.size(); ++i) {
    if (i > 0) {
      ASSERT_GE(late[i].arrival, late[i - 1].arrival);
    }
    ASSERT_EQ(late[i].sequence, i);
    if (late[i].stamp < newest[late[i].sensor]) ++overtaken[late[i].sensor];
    newest[late[i].sensor] = std::max(newest[late[i].sensor], late[i].stamp);
    const double delay = to_seconds(late[i].arrival - late[i].stamp);
    if (late[i].sensor == 0) wheels.push_back(delay);
    if (late[i].sensor == 1) fixes.push_back(delay);
  }
  EXPECT_GT(overtaken[0], 1000);
  EXPECT_GT(overtaken[1], 100);
  EXPECT_EQ(overtaken[2], 0);
  const auto mean = [](const std::vector<double>& v) {
    double sum = 0.0;
    for (const double x : v) sum += x;
    return sum / static_cast<double>(v.size());
  };
  EXPECT_GE(std::ranges::min(wheels), 0.1);
  EXPECT_LE(std::ranges::max(wheels), 0.6);
  EXPECT_NEAR(mean(wheels), 0.35, 4.0 * 0.5 / std::sqrt(12.0 * 2400.0));
  EXPECT_NEAR(mean(fixes), 2.0, 4.0 * 2.0 / std::sqrt(300.0));
  EXPECT_GT(std::ranges::max(fixes), 5.0);
}

TEST(SimulatorFaults, AWrongClockShowsInTheStampAlone) {
  const auto plain = read_all(*simulate(kPlain));
  const auto wrong = read_all(*simulate(
      ", wheels: { sensor: wheels, track_m: 0.5 }, gps: { sensor: gps, correlated_sigma_m: 0.5, delay_s: 0.1, "
      "stamp_offset_s: 0.25 }" +
      kOthers));
  const auto fixes = contents(plain, GnssFix::kType);
  int count = 0;
  for (const Measurement& m : wrong) {
    if (m.payload->type() != GnssFix::kType) continue;
    ++count;
    ASSERT_EQ(m.arrival - m.stamp, from_seconds(0.1 - 0.25));
    ASSERT_EQ(bits_of(*m.payload), fixes.at(m.stamp - from_seconds(0.25)));
  }
  EXPECT_EQ(count, 300);
  EXPECT_EQ(contents(wrong, WheelSpeeds::kType), contents(plain, WheelSpeeds::kType));
}

TEST(SimulatorFaults, ADeadSensorIsSilentAndComesBackAsItWas) {
  const std::string dead = ", dead_s: [10, 20, 30, 31] }";
  const auto plain = read_all(*simulate(kPlain));
  const auto mortal = read_all(
      *simulate(", wheels: { sensor: wheels, track_m: 0.5" + dead + ", gps: { sensor: gps, correlated_sigma_m: 0.5" +
                dead + ", lidar: { sensor: lidar, beams: 9, step_deg: 30" + dead + ", imu: { sensor: imu, rate_hz: 20" +
                dead + ", compass: { sensor: compass" + dead));
  for (const auto type :
       {WheelSpeeds::kType, GnssFix::kType, LaserScan::kType, ImuSample::kType, CompassHeading::kType}) {
    auto expected = contents(plain, type);
    const auto gone = std::erase_if(expected, [](const auto& one) {
      const double t = seconds(one.first);
      return (t >= 10.0 && t < 20.0) || (t >= 30.0 && t < 31.0);
    });
    EXPECT_GE(gone, 55u) << type;
    EXPECT_EQ(contents(mortal, type), expected) << type;
  }
}

TEST(SimulatorFaults, NanHitsItsShareAndItsSpansAndNothingElse) {
  const std::string nan = ", nan_probability: 0.1, nan_s: [40, 42] }";
  const auto plain = read_all(*simulate(kPlain));
  const auto spoilt = read_all(
      *simulate(", wheels: { sensor: wheels, track_m: 0.5" + nan + ", gps: { sensor: gps, correlated_sigma_m: 0.5" +
                nan + ", lidar: { sensor: lidar, beams: 9, step_deg: 30" + nan + ", imu: { sensor: imu, rate_hz: 20" +
                nan + ", compass: { sensor: compass" + nan));
  ASSERT_EQ(spoilt.size(), plain.size());
  std::map<std::uint32_t, int> hits;
  std::map<std::uint32_t, int> all;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    ASSERT_EQ(spoilt[i].stamp, plain[i].stamp);
    const double t = seconds(spoilt[i].stamp);
    const bool in_span = t >= 40.0 && t < 42.0;
    if (!has_nan(*spoilt[i].payload)) {
      ASSERT_FALSE(in_span) << t;
      ASSERT_EQ(bits_of(*spoilt[i].payload), bits_of(*plain[i].payload));
    }
    if (in_span) continue;
    ++all[spoilt[i].sensor];
    hits[spoilt[i].sensor] += has_nan(*spoilt[i].payload) ? 1 : 0;
  }
  ASSERT_EQ(all.size(), 5u);
  for (const auto& [sensor, count] : all)
    EXPECT_NEAR(hits[sensor], 0.1 * count, 4.0 * std::sqrt(0.09 * count)) << "sensor " << sensor;
}

TEST(SimulatorFaults, TwoSensorsDoNotFailTogether) {
  // At these rates both measure at 10, 1010, 2010 … ms: 0.13 / 13 = 0.71 / 71.
  const auto log = read_all(
      *simulate(", imu: { sensor: imu, rate_hz: 13, nan_probability: 0.5 }, compass: { sensor: compass, rate_hz: 71, "
                "nan_probability: 0.5 }"));
  std::map<Time, bool> imu;
  std::map<Time, bool> compass;
  for (const Measurement& m : log)
    (m.payload->type() == ImuSample::kType ? imu : compass)[m.stamp] = has_nan(*m.payload);
  int both = 0;
  int equal = 0;
  for (const auto& [stamp, is_nan] : imu) {
    const auto other = compass.find(stamp);
    if (other == compass.end()) continue;
    ++both;
    equal += other->second == is_nan ? 1 : 0;
  }
  ASSERT_GT(both, 50);
  EXPECT_NEAR(equal, 0.5 * both, 4.0 * std::sqrt(0.25 * both));
}

}  // namespace
}  // namespace waymark
