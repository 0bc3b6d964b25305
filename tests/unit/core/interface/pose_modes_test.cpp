// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/pose_modes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "waymark/math/so3.hpp"

namespace waymark {
namespace {

ParticleView particle(double x, double y, double yaw, double weight) {
  return {Pose{so3::from_rpy(0.0, 0.0, yaw), {x, y, 0.0}}, weight};
}

/// Particles about a pose, of equal weights that sum up to `weight`.
void add(std::vector<ParticleView>& to, std::mt19937& dice, int count, const Eigen::Vector3d& at, double sigma,
         double weight) {
  std::normal_distribution<double> noise(0.0, 1.0);
  for (int i = 0; i < count; ++i) {
    to.push_back(particle(at.x() + sigma * noise(dice), at.y() + sigma * noise(dice),
                          at.z() + sigma / ModeFinder::kHeadingArm * noise(dice), weight / count));
  }
}

/// Share of draws of a Gaussian that are taken for several modes.
double share_of_false_modes(int count, double sigma) {
  ModeFinder finder;
  std::mt19937 dice(3);
  int several = 0;
  for (int i = 0; i < 1000; ++i) {
    std::vector<ParticleView> particles;
    add(particles, dice, count, {400.0, -300.0, 3.1}, sigma, 1.0);
    several += finder.find(particles).size() > 1;
  }
  return several / 1000.0;
}

TEST(PoseModes, OneSpreadIsOneMode) {
  EXPECT_LT(share_of_false_modes(10, 0.05), 0.001);  // within what counts as one place
  EXPECT_LT(share_of_false_modes(3, 0.05), 0.001);
  EXPECT_LT(share_of_false_modes(10, 2.0), 0.005);
  EXPECT_LT(share_of_false_modes(30, 2.0), 0.002);
  EXPECT_LT(share_of_false_modes(100, 2.0), 0.001);
}

TEST(PoseModes, OneParticleIsOneModeAndNoneIsNone) {
  ModeFinder finder;
  EXPECT_TRUE(finder.find({}).empty());
  const std::vector<ParticleView> one{particle(1.0, 2.0, 0.5, 1.0)};
  ASSERT_EQ(finder.find(one).size(), 1U);
  EXPECT_EQ(finder.find(one).front().weight, 1.0);
}

TEST(PoseModes, TwoPlacesAreTwoModesHeaviestFirst) {
  ModeFinder finder;
  std::mt19937 dice(4);
  std::vector<ParticleView> particles;
  add(particles, dice, 4, {0.0, 0.0, 0.0}, 0.03, 0.4);
  add(particles, dice, 6, {1.0, 1.0, 0.0}, 0.03, 0.6);
  const std::vector<PoseMode>& modes = finder.find(particles);
  ASSERT_EQ(modes.size(), 2U);
  EXPECT_NEAR(modes[0].weight, 0.6, 1e-9);
  EXPECT_NEAR(modes[0].T_map_base.p.x(), 1.0, 0.2);
  EXPECT_NEAR(modes[1].weight, 0.4, 1e-9);
  EXPECT_NEAR(modes[1].T_map_base.p.x(), 0.0, 0.2);
}

TEST(PoseModes, ThreePlacesAreThree) {
  ModeFinder finder;
  std::mt19937 dice(5);
  std::vector<ParticleView> particles;
  for (const double x : {0.0, 3.0, 9.0}) add(particles, dice, 10, {x, 2.0, 0.0}, 0.1, 1.0 / 3.0);
  EXPECT_EQ(finder.find(particles).size(), 3U);
}

TEST(PoseModes, TwoHeadingsAtOnePlaceAreTwoAlsoAcrossTheTurn) {
  ModeFinder finder;
  std::mt19937 dice(6);
  std::vector<ParticleView> particles;
  add(particles, dice, 5, {5.0, 5.0, M_PI - 0.2}, 0.03, 0.5);
  add(particles, dice, 5, {5.0, 5.0, -M_PI + 0.2}, 0.03, 0.5);
  EXPECT_EQ(finder.find(particles).size(), 2U);
}

TEST(PoseModes, WhatHasHardlyAnyWeightIsNone) {
  ModeFinder finder;
  std::mt19937 dice(7);
  std::vector<ParticleView> particles;
  add(particles, dice, 5, {0.0, 0.0, 0.0}, 0.03, 0.95);
  add(particles, dice, 5, {8.0, 0.0, 0.0}, 0.03, 0.05);
  EXPECT_EQ(finder.find(particles).size(), 1U);
}

}  // namespace
}  // namespace waymark
