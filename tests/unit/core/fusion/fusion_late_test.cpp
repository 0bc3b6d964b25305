// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, odometry
// Late and out-of-order measurements: without maps the host rolls back, with maps it weights the particles.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "unit/core/fusion_robot.hpp"
#include "unit/core/toy_map.hpp"

namespace waymark {
namespace {

using ::testing::HasSubstr;
using namespace test;  // NOLINT(google-build-using-namespace): the robot's parts

/// Twenty seconds of a curve with fixes that scatter.
std::vector<Measurement> curve() {
  std::vector<Measurement> log;
  Random random = stream(51);
  drive(log, 0.0, 20.0, 1.0, 0.2);
  for (int k = 0; k < 40; ++k) {
    const double t = 0.5 * k + 0.03;
    const double east = 5.0 * std::sin(0.2 * t) + 0.1 * random.normal();
    const double north = 5.0 * (1.0 - std::cos(0.2 * t)) + 0.1 * random.normal();
    log.push_back(fix(t, east, north));
  }
  return in_order(log);
}

/// The same log with every measurement delayed at random, but for the first ones, so that the filter starts alike; in
/// order of arrival.
std::vector<Measurement> shaken(std::vector<Measurement> log, double longest, std::uint64_t seed) {
  Random random = stream(static_cast<int>(seed));
  for (Measurement& m : log) {
    if (m.stamp > at(0.4)) m.arrival = m.stamp + from_seconds(uniform(random, 0.0, longest));
  }
  std::stable_sort(log.begin(), log.end(), [](const auto& a, const auto& b) { return a.arrival < b.arrival; });
  return log;
}

std::string robot_yaml(const std::string& filter) {
  return kAtOrigin + "filter: " + filter + "\nsensors:\n" + kWheels + gps("offset_sigma_m: 0.2");
}

TEST(FusionLate, WithoutMapsTheResultIsThatOfALogInOrderToTheByte) {
  const std::string yaml = robot_yaml("{ max_latency_s: 0, history_s: 2 }");
  FusionRobot ideal(yaml);
  ideal.play(curve());
  for (int trial = 0; trial < 5; ++trial) {
    FusionRobot robot(yaml);
    robot.play(shaken(curve(), 1.0, 60 + static_cast<std::uint64_t>(trial)));
    EXPECT_TRUE(robot.bytes() == ideal.bytes());
    for (const std::size_t sensor : {0U, 1U}) {
      EXPECT_EQ(robot.report(sensor).fused, ideal.report(sensor).fused);
      EXPECT_EQ(robot.report(sensor).nis_sum, ideal.report(sensor).nis_sum);
      EXPECT_EQ(robot.report(sensor).late, 0U);
    }
    EXPECT_GT(robot.report(1).processed_late, 10U);
    EXPECT_GT(robot.report(0).reordered, 10U);
    EXPECT_NEAR(robot.report(0).latency_max_s, 1.0, 0.1);
  }
}

TEST(FusionLate, SeveralParticlesGoBackToo) {
  const std::string yaml = robot_yaml("{ particles: 10, history_s: 2 }");
  FusionRobot ideal(yaml);
  ideal.play(curve());
  FusionRobot robot(yaml);
  robot.play(shaken(curve(), 0.7, 71));
  EXPECT_TRUE(robot.bytes() == ideal.bytes());
}

TEST(FusionLate, AnObserverSeesTheLateMeasurementWithTheBeliefOfNow) {
  FusionRobot robot(robot_yaml("{ history_s: 2 }"));
  std::vector<Measurement> log = curve();
  const auto late =
      std::find_if(log.begin(), log.end(), [](const auto& m) { return m.sensor == 1 && m.stamp > at(10.0); });
  Measurement m = *late;
  log.erase(late);
  for (const Measurement& other : log) {
    if (other.stamp < at(11.0)) robot.fusion().add(other);
  }
  const Belief before = robot.filter().mixture();
  const std::size_t seen = robot.seen().size();
  m.arrival = at(11.0);
  robot.fusion().add(m);
  // What waited for a later arrival comes first.
  ASSERT_GT(robot.seen().size(), seen);
  const Seen& last = robot.seen().back();
  EXPECT_EQ(last.sensor, 1U);
  EXPECT_EQ(last.fate, Fate::fused);
  EXPECT_EQ(last.belief.stamp, robot.filter().stamp());
  EXPECT_GT(last.belief.stamp, m.stamp);
  EXPECT_GE(last.belief.stamp, before.stamp);
}

TEST(FusionLate, WhatIsOlderThanTheHistoryIsCountedAndReported) {
  FusionRobot robot(robot_yaml("{ history_s: 0.5 }"));
  FusionRobot without(robot_yaml("{ history_s: 0.5 }"));
  std::vector<Measurement> log = curve();
  without.play(log);
  Measurement late = fix(3.0, 500.0, 500.0);
  late.arrival = at(19.9);
  late.sequence = 1000;
  log.push_back(late);
  robot.play(log);
  EXPECT_EQ(robot.report(1).late, 1U);
  EXPECT_TRUE(robot.bytes() == without.bytes());
  EXPECT_THAT(robot.events(), HasSubstr("gps: a measurement came 16.900 s after its stamp"));
  EXPECT_THAT(robot.events(), HasSubstr("filter.history_s"));
}

TEST(FusionLate, WithoutHistoryNothingLateIsProcessed) {
  FusionRobot robot(robot_yaml("{ history_s: 0 }"));
  robot.play(shaken(curve(), 0.5, 72));
  EXPECT_GT(robot.report(1).late, 5U);
  EXPECT_EQ(robot.report(1).processed_late, 0U);
}

TEST(FusionLate, AFixedDelayIsSubtractedFromTheStamps) {
  FusionRobot ideal(robot_yaml("{}"));
  ideal.play(curve());
  std::vector<Measurement> stamped_late = curve();
  for (Measurement& m : stamped_late) {
    if (m.sensor == 1) m.stamp += from_seconds(0.3);
    m.arrival = m.stamp;
  }
  std::stable_sort(stamped_late.begin(), stamped_late.end(),
                   [](const auto& a, const auto& b) { return a.arrival < b.arrival; });
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps("offset_sigma_m: 0.2, delay_s: 0.3"));
  robot.play(stamped_late);
  EXPECT_TRUE(robot.bytes() == ideal.bytes());
}

// ---- with maps

/// Extracts nothing: the particles have a map, and nothing writes it.
class IdleModule final : public MapModule {
 public:
  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<ToyMap>(ToyMap::Fails::never); }
  std::shared_ptr<const Observation> extract(const Measurement&, std::span<const Companion>,
                                             const MotionWindow&) override {
    return nullptr;
  }
  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override { return ToyMap::load(in); }
};

std::vector<MapSlot> idle_map() {
  MapSlot slot;
  slot.name = "idle";
  slot.module = std::make_shared<IdleModule>();
  slot.inputs = {1};
  return {slot};
}

/// A robot whose wheels are so good that its pose in the map is a point: fixes correct the map's place only.
std::string surveyed(double walk) {
  return "initial: { x_m: 0, y_m: 0, position_sigma_m: 5, yaw_deg: 0, yaw_sigma_deg: 5 }\n"
         "motion: { velocity_noise_mps_per_sqrt_s: [1e-6, 1e-6, 1e-6], rate_noise_radps_per_sqrt_s: [1e-6, 1e-6, 1e-6] "
         "}\n"
         "georeference: { position_walk_m_per_sqrt_m: " +
         std::to_string(walk) +
         " }\nfilter: { particles: 1, history_s: 2 }\nsensors:\n  - { name: wheels, plugin: odometry, model: twist, "
         "speed_noise_m_per_sqrt_s: [1e-6, 0], "
         "lateral_noise_m_per_sqrt_s: [1e-6, 0], yaw_noise_rad_per_sqrt_s: [1e-6, 0, 0], " +
         kNoStates + " }\n" +
         gps("jump_sigmas: 0, adaptive_noise: false, frozen_distance_m: 0");  // the filter's part alone
}

struct Ending {
  Eigen::Vector3d p;
  Eigen::Matrix3d P;
};
Ending end_of_survey(double walk, double delay) {
  FusionRobot robot(surveyed(walk), {}, idle_map());
  std::vector<Measurement> log;
  drive(log, 0.0, 12.0, 1.0);
  Random random = stream(81);
  for (int k = 0; k < 20; ++k) {
    const double t = 0.5 * k + 0.25;
    log.push_back(fix(t, 2.0 + t + 0.1 * random.normal(), -1.0 + 0.1 * random.normal()));
  }
  log = in_order(log);
  for (Measurement& m : log) {
    if (m.sensor == 1) m.arrival = m.stamp + from_seconds(delay);
  }
  std::stable_sort(log.begin(), log.end(), [](const auto& a, const auto& b) { return a.arrival < b.arrival; });
  robot.play(log);
  EXPECT_EQ(robot.report(1).processed_late, delay > 0.0 ? 20U : 0U);
  EXPECT_EQ(robot.report(1).fused, 20U);
  return {robot.pose().p, robot.pose_P()};
}

TEST(FusionLate, WithMapsALateFixCorrectsAFixedMapLikeOneInOrder) {
  const Ending ideal = end_of_survey(0.0, 0.0);
  const Ending late = end_of_survey(0.0, 1.0);
  EXPECT_NEAR(ideal.p.x(), 13.9, 0.3);
  EXPECT_LT((late.p - ideal.p).norm(), 1e-3);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(late.P(i, i) / ideal.P(i, i), 1.0, 0.01) << i;
}

// Where the map wanders, fixes that are late together are taken as if those between had been of now.
TEST(FusionLate, WithMapsALateFixCorrectsADriftingMapNearlyLikeOneInOrder) {
  const Ending ideal = end_of_survey(0.05, 0.0);
  const Ending late = end_of_survey(0.05, 1.0);
  EXPECT_LT((late.p - ideal.p).norm(), 0.3 * std::sqrt(ideal.P(0, 0)));
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(late.P(i, i) / ideal.P(i, i), 1.0, 0.1) << i;
}

TEST(FusionLate, WithMapsPosesStayAndWeightsMove) {
  FusionRobot robot(kAtOrigin +
                        "georeference: { enabled: false }\nfilter: { particles: 20, sampling_fraction: 1, "
                        "resample_threshold: 0 }\nsensors:\n" +
                        kWheels + gps(),
                    {}, idle_map());
  std::vector<Measurement> log;
  drive(log, 0.0, 5.0, 1.0);
  for (const Measurement& m : in_order(log)) robot.fusion().add(m);
  std::vector<Eigen::Vector3d> before;
  for (const particles::Particle& particle : robot.filter().particles())
    before.push_back(particle.belief.mean.T_map_base.p);
  Measurement late = fix(4.0, 4.0, 0.1);
  late.arrival = at(4.9);
  late.sequence = 1000;
  robot.fusion().add(late);
  double heaviest = 0.0;
  double nearest = 1e9;
  double weight_of_nearest = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const particles::Particle& particle = robot.filter().particles()[i];
    EXPECT_EQ(particle.belief.mean.T_map_base.p, before[i]);
    const double weight = std::exp(particle.log_weight);
    const double distance = std::abs(particle.belief.mean.T_map_base.p.y() - 0.1);
    heaviest = std::max(heaviest, weight);
    if (distance < nearest) {
      nearest = distance;
      weight_of_nearest = weight;
    }
  }
  EXPECT_GT(heaviest, 0.06);
  EXPECT_GT(weight_of_nearest, 0.05);
}

TEST(FusionLate, WithMapsWheelsThatAreOftenLateAreReportedOnceWithTheRemedy) {
  FusionRobot robot(kAtOrigin + "filter: { particles: 2 }\nsensors:\n" + kWheels + gps(), {}, idle_map());
  std::vector<Measurement> log;
  drive(log, 0.0, 5.0, 1.0);
  for (int k = 0; k < 50; ++k) log.push_back(fix(0.1 * k + 0.05, 0.1 * k + 0.05, 0.0));
  log = in_order(log);
  for (Measurement& m : log) {
    if (m.sensor == 0) m.arrival = m.stamp + from_seconds(0.31);
  }
  std::ranges::stable_sort(log, {}, &Measurement::arrival);
  for (const Measurement& m : log) robot.fusion().add(m);
  std::vector<std::string> reported;
  for (const Event& event : robot.fusion().report().events) {
    if (event.text.find("only weight the particles") != std::string::npos) reported.push_back(event.text);
  }
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_TRUE(reported[0].starts_with("wheels: measurements come 0.310 s after their stamps")) << reported[0];
  EXPECT_NE(reported[0].find("filter.max_latency_s: 0.4 would wait"), std::string::npos) << reported[0];
}

}  // namespace
}  // namespace waymark
