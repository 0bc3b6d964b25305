// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "adaptive_noise.hpp"
#include "inflation.hpp"
#include "waymark/math/random.hpp"

namespace waymark::dgps {
namespace {

Time at(double t) { return Time{from_seconds(t)}; }

GnssFix fix_of(GnssFix::Type type, int satellites) {
  GnssFix fix;
  fix.type = type;
  fix.satellites = satellites;
  return fix;
}

template <class T>
void copy_by_archive(const T& from, T& to) {
  std::stringstream stream;
  OutArchive out(stream);
  out(from);
  InArchive in(stream);
  in(to);
}

// --- settling ------------------------------------------------------------------------------------------------------

TEST(Settling, AChangeOfTypeCostsForAWhile) {
  Settling settling(Config::parse("{ settling_s: 2, settling_factor: 4 }"));
  EXPECT_EQ(settling.factor(at(0.0), fix_of(GnssFix::Type::rtk_fixed, 9)), 1.0);
  EXPECT_EQ(settling.factor(at(1.0), fix_of(GnssFix::Type::rtk_fixed, 9)), 1.0);
  EXPECT_NEAR(settling.factor(at(2.0), fix_of(GnssFix::Type::rtk_float, 9)), 16.0, 1e-12);
  EXPECT_NEAR(settling.factor(at(4.0), fix_of(GnssFix::Type::rtk_float, 9)), 1.0 + 15.0 * std::exp(-1.0), 1e-12);
  EXPECT_EQ(settling.factor(at(8.0), fix_of(GnssFix::Type::rtk_float, 9)), 1.0);
}

TEST(Settling, OneSatelliteMoreOrLessIsNoChangeThreeAre) {
  Settling settling(Config::parse("{}"));
  settling.factor(at(0.0), fix_of(GnssFix::Type::single, 9));
  EXPECT_EQ(settling.factor(at(1.0), fix_of(GnssFix::Type::single, 8)), 1.0);
  EXPECT_EQ(settling.factor(at(2.0), fix_of(GnssFix::Type::single, -1)), 1.0);  // unknown
  EXPECT_GT(settling.factor(at(3.0), fix_of(GnssFix::Type::single, 5)), 1.0);
}

TEST(Settling, ASentenceWithoutTypeChangesNothing) {
  Settling settling(Config::parse("{}"));
  for (int t = 0; t < 10; ++t) {
    const auto type = t % 2 == 0 ? GnssFix::Type::differential : GnssFix::Type::unknown;
    EXPECT_EQ(settling.factor(at(t), fix_of(type, -1)), 1.0) << t;
  }
  EXPECT_GT(settling.factor(at(10.0), fix_of(GnssFix::Type::single, -1)), 1.0);
}

TEST(Settling, ZeroTurnsItOff) {
  Settling settling(Config::parse("{ settling_s: 0 }"));
  settling.factor(at(0.0), fix_of(GnssFix::Type::single, 9));
  EXPECT_EQ(settling.factor(at(1.0), fix_of(GnssFix::Type::differential, 4)), 1.0);
}

TEST(Settling, ContinuesWhereItWasSaved) {
  const Config config = Config::parse("{}");
  Settling one(config);
  one.factor(at(0.0), fix_of(GnssFix::Type::single, 9));
  one.factor(at(1.0), fix_of(GnssFix::Type::differential, 9));
  Settling other(config);
  copy_by_archive(one, other);
  const GnssFix next = fix_of(GnssFix::Type::differential, 9);
  EXPECT_EQ(one.factor(at(2.0), next), other.factor(at(2.0), next));
}

// --- return after an outage ----------------------------------------------------------------------------------------

const Eigen::Matrix2d kUnit = Eigen::Matrix2d::Identity();

TEST(Reacquisition, TheVarianceDecaysOverTheFixes) {
  Reacquisition soft(Config::parse("{ outage_s: 5, reacquisition_fixes: 4, reacquisition_factor: 3 }"));
  const auto factor = [&](double t) { return soft.factor(at(t), {0.0, 0.0}, kUnit, kUnit); };
  for (int t = 0; t < 5; ++t) EXPECT_EQ(factor(t), 1.0);
  EXPECT_NEAR(factor(30.0), 9.0, 1e-12);
  EXPECT_NEAR(factor(31.0), std::pow(3.0, 1.5), 1e-12);
  EXPECT_NEAR(factor(32.0), 3.0, 1e-12);
  EXPECT_NEAR(factor(33.0), std::sqrt(3.0), 1e-12);
  EXPECT_EQ(factor(34.0), 1.0);
}

TEST(Reacquisition, ASlowReceiverHasNoOutages) {
  Reacquisition soft(Config::parse("{ outage_s: 5 }"));
  soft.factor(at(0.0), {0.0, 0.0}, kUnit, kUnit);
  EXPECT_GT(soft.factor(at(10.0), {0.0, 0.0}, kUnit, kUnit), 1.0);  // nothing is known of its rate yet
  Reacquisition used(Config::parse("{ outage_s: 5, reacquisition_fixes: 1 }"));
  for (int k = 0; k < 3; ++k) used.factor(at(4.0 * k), {0.0, 0.0}, kUnit, kUnit);
  EXPECT_EQ(used.factor(at(18.0), {0.0, 0.0}, kUnit, kUnit), 1.0);  // 10 s, usually 4
  EXPECT_GT(used.factor(at(60.0), {0.0, 0.0}, kUnit, kUnit), 1.0);
}

TEST(Reacquisition, NoFixAfterAnOutageStepsByMoreThanThreeSigma) {
  Random random({.seed = 3, .slot = 0, .stamp = 0, .sensor = 0});
  Reacquisition soft(Config::parse("{ outage_s: 5, reacquisition_fixes: 3, reacquisition_factor: 1 }"));
  for (int k = 0; k < 300; ++k) {
    const double t = k % 3 + 100.0 * (k / 3);
    Eigen::Matrix2d A;
    A << random.normal(), random.normal(), random.normal(), random.normal();
    const Eigen::Matrix2d C = A * A.transpose() + 0.01 * kUnit;
    const Eigen::Matrix2d R = 0.04 * kUnit;
    const Eigen::Vector2d nu = 5.0 * Eigen::Vector2d(random.normal(), random.normal());
    const double factor = soft.factor(at(t), nu, C, R);
    if (k < 3) continue;
    const Eigen::Vector2d step = C * (C + factor * R).inverse() * nu;
    EXPECT_LE(step.dot(C.inverse() * step), 9.0 + 1e-9) << k;
  }
}

TEST(Reacquisition, ContinuesWhereItWasSaved) {
  const Config config = Config::parse("{}");
  Reacquisition one(config);
  for (const double t : {0.0, 1.0, 50.0}) one.factor(at(t), {0.0, 0.0}, kUnit, kUnit);
  Reacquisition other(config);
  copy_by_archive(one, other);
  for (const double t : {51.0, 52.0, 80.0}) {
    EXPECT_EQ(one.factor(at(t), {0.0, 0.0}, kUnit, kUnit), other.factor(at(t), {0.0, 0.0}, kUnit, kUnit));
  }
}

// --- adaptive noise ------------------------------------------------------------------------------------------------

/// Share of the time that the scale is not 1, and its mean over the second half, for noise `truth` times the stated,
/// and innovations that are wrong by `bias`.
std::pair<double, double> adapted(double truth, int window, double bias = 0.0) {
  AdaptiveNoise noise(window);
  Random random({.seed = 7, .slot = 0, .stamp = window, .sensor = 1});
  constexpr double kPrior = 0.5;
  double changed = 0.0;
  double sum = 0.0;
  constexpr int kCount = 4000;
  for (int k = 0; k < kCount; ++k) {
    const double sigma = std::sqrt(kPrior + truth);
    const Eigen::Vector2d nu(bias + sigma * random.normal(), sigma * random.normal());
    noise.take(nu, 2.0 * kPrior, 2.0, 2);
    changed += noise.scale() > 1.0;
    if (k >= kCount / 2) sum += noise.scale();
  }
  return {changed / kCount, sum / (kCount / 2)};
}

TEST(AdaptiveNoise, LeavesNoiseAloneThatIsAsStated) {
  EXPECT_LT(adapted(1.0, 20).first, 0.01);
  EXPECT_LT(adapted(0.3, 20).first, 0.001);
}

TEST(AdaptiveNoise, FindsNoiseThatIsLargerThanStated) {
  EXPECT_NEAR(adapted(9.0, 20).second, 9.0, 0.5);
  EXPECT_NEAR(adapted(4.0, 64).second, 4.0, 0.2);
}

TEST(AdaptiveNoise, HasABound) { EXPECT_NEAR(adapted(400.0, 20).second, 25.0, 1e-6); }

TEST(AdaptiveNoise, DoesNotTakeInnovationsOfOneSideForNoise) { EXPECT_LT(adapted(1.0, 20, 10.0).first, 0.01); }

/// Innovations that turn from one side to the other: nothing but noise.
void shake(AdaptiveNoise& noise, double amplitude, int count) {
  for (int k = 0; k < count; ++k) noise.take({k % 2 == 0 ? amplitude : -amplitude, 0.0}, 0.5, 2.0, 2);
}

TEST(AdaptiveNoise, DoesNotCompareAcrossAnInterruption) {
  AdaptiveNoise noise(10);
  for (int k = 0; k < 40; ++k) {
    noise.take({k % 2 == 0 ? 3.0 : -3.0, 0.0}, 0.5, 2.0, 2);
    noise.interrupt();
  }
  EXPECT_EQ(noise.scale(), 1.0);
}

TEST(AdaptiveNoise, ReturnsWhenTheNoiseDoes) {
  AdaptiveNoise noise(10);
  shake(noise, 3.2, 30);
  EXPECT_GT(noise.scale(), 5.0);
  shake(noise, 1.0, 11);
  EXPECT_EQ(noise.scale(), 1.0);
}

TEST(AdaptiveNoise, RefusesAnArchiveOfAnotherWindow) {
  AdaptiveNoise large(40);
  shake(large, 3.2, 39);
  AdaptiveNoise small(10);
  EXPECT_THROW(copy_by_archive(large, small), DataError);
}

}  // namespace
}  // namespace waymark::dgps
