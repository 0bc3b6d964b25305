// SPDX-License-Identifier: Apache-2.0
// What a landmark becomes by being seen again and again.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <sstream>

#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"
#include "waymark/math/gaussian.hpp"
#include "waymark/math/random.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::detection_of;
using feature_map_test::observation_of;
using feature_map_test::settings_of;
using feature_map_test::step;

ParticleFeatureMap map_with(const std::string& yaml) {
  return ParticleFeatureMap(std::make_shared<FeatureMapSettings>(settings_of(yaml)));
}

const std::string kWideGate = "negative_information: false, association: { gate_probability: 0.999999 } }";

Landmark only(const ParticleFeatureMap& map) {
  Landmark found;
  map.landmarks().for_all([&](const Landmark& landmark) { found = landmark; });
  return found;
}

/// ∂(landmark in the map)/∂(x, y, yaw) for a detection in the base frame.
Eigen::Matrix<double, 2, 3> pose_jacobian(const Eigen::Vector2d& p_map, const Eigen::Vector3d& pose) {
  Eigen::Matrix<double, 2, 3> G;
  G << 1.0, 0.0, -(p_map.y() - pose.y()), 0.0, 1.0, p_map.x() - pose.x();
  return G;
}

TEST(LandmarkFusion, AFirstSightingHasTheNoiseOfDetectionAndPose) {
  auto map = map_with("{ " + kWideGate);
  const Eigen::Vector3d pose(1.0, 2.0, 0.7);
  const Eigen::Matrix3d kept = Eigen::Vector3d(0.01, 0.02, 1e-3).asDiagonal();
  const Detection detection = detection_of({5.0, 6.0}, pose);
  step(map, pose, kept, kept, observation_of({detection}));
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(pose.z()).toRotationMatrix();
  const auto G = pose_jacobian({5.0, 6.0}, pose);
  const Eigen::Matrix2d expected =
      turn * detection.R.topLeftCorner<2, 2>() * turn.transpose() + G * kept * G.transpose();
  EXPECT_TRUE(only(map).mean.head<2>().isApprox(Eigen::Vector2d(5.0, 6.0), 1e-12));
  EXPECT_LT((only(map).P.topLeftCorner<2, 2>() - expected).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(LandmarkFusion, WithAnExactPoseSightingsAverage) {
  auto map = map_with("{ " + kWideGate);
  const Eigen::Vector3d pose(0.0, 0.0, 0.0);
  const std::array<double, 4> east = {5.02, 4.97, 5.03, 5.06};
  for (const double e : east)
    step(map, pose, Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(), observation_of({detection_of({e, 1.0}, pose)}));
  EXPECT_NEAR(only(map).mean.x(), 5.02, 1e-9);
  EXPECT_NEAR(only(map).P(0, 0), 0.05 * 0.05 / 4.0, 1e-12);
}

TEST(LandmarkFusion, TheRadiusConvergesWithThePosition) {
  auto map = map_with("{ attributes: [radius], " + kWideGate);
  const Eigen::Vector3d pose(0.0, 0.0, 0.0);
  for (const double r : {0.18, 0.22, 0.26, 0.22}) {
    step(map, pose, Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(),
         observation_of({detection_of({5.0, 1.0}, pose, 0.05, r)}));
  }
  EXPECT_NEAR(only(map).mean.z(), 0.22, 1e-9);
  EXPECT_NEAR(only(map).P(2, 2), 0.05 * 0.05 / 4.0, 1e-12);
}

/// Variance of a detection as it reaches the joint Gaussian, in a map that saw the same landmark `since` seconds
/// before.
double reported_variance(double since) {
  auto map = map_with("{ noise: { correlation_s: 2 }, " + kWideGate);
  const Eigen::Vector3d pose(0.0, 0.0, 0.0);
  FeatureObservation observation = observation_of({detection_of({5.0, 1.0}, pose)});
  observation.stamp = Time(from_seconds(100.0));
  step(map, pose, Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(), observation);
  observation.stamp = Time(from_seconds(100.0 + since));
  Refinement refinement;
  map.refine(feature_map_test::gaussian_at(pose, Eigen::Matrix3d::Zero()), {}, observation, refinement);
  Correspondences found;
  map.correspond(observation, refinement.association.get(), found);
  return found.landmarks.at(0).is_new ? -1.0 : found.landmarks.at(0).R(0, 0);
}

// n values of a chain with ρ = exp(−Δt/τ) say (n (1 − ρ) + 2 ρ)/(1 + ρ) times as much about a constant as one.
TEST(LandmarkFusion, ErrorsThatRepeatThemselvesAreReportedOnce) {
  const double rho = std::exp(-0.5 / 2.0);
  EXPECT_NEAR(0.05 * 0.05 / reported_variance(0.5), (1.0 - rho) / (1.0 + rho), 1e-9);
  EXPECT_NEAR(reported_variance(100.0), 0.05 * 0.05, 1e-12);
}

/// A robot that stands: the error that its pose kept is common to all scans.
struct Standstill {
  static constexpr std::array<int, 4> kLooks = {10, 100, 1000, 10000};
  static constexpr int kRuns = 40;
  Eigen::Matrix3d kept = Eigen::Vector3d(0.05 * 0.05, 0.05 * 0.05, 0.01 * 0.01).asDiagonal();
  Eigen::Vector2d truth{5.0, 2.0};
  std::array<double, 4> mean_nees{};
  double least_ratio = 1e300;  ///< smallest eigenvalue of floor⁻¹ P over all scans

  /// Of a symmetric matrix, by its formula: it is needed 400'000 times.
  static double smallest_eigenvalue(const Eigen::Matrix2d& m) {
    const double middle = 0.5 * (m(0, 0) + m(1, 1));
    return middle - std::hypot(0.5 * (m(0, 0) - m(1, 1)), m(0, 1));
  }

  Standstill() {
    const auto settings = std::make_shared<FeatureMapSettings>(settings_of("{ " + kWideGate));
    const auto G = pose_jacobian(truth, Eigen::Vector3d::Zero());
    const Eigen::Matrix2d root_of_floor = Eigen::LLT<Eigen::Matrix2d>(G * kept * G.transpose()).matrixL();
    const Eigen::Matrix2d to_white = root_of_floor.inverse();
    for (std::uint32_t run = 0; run < kRuns; ++run) {
      Random random({.seed = 11, .slot = run, .stamp = 0, .sensor = 0});
      const Eigen::Vector3d pose = gaussian::sample(kept, random);  // estimated; the true one is the origin
      const Eigen::Matrix2d root =
          Eigen::LLT<Eigen::Matrix2d>(detection_of(truth, pose).R.topLeftCorner<2, 2>()).matrixL();
      ParticleFeatureMap map(settings);
      std::size_t look = 0;
      for (int scan = 1; scan <= kLooks.back(); ++scan) {
        Detection detection = detection_of(truth, Eigen::Vector3d::Zero());
        detection.xyr.head<2>() += root * Eigen::Vector2d(random.normal(), random.normal());
        step(map, pose, kept, kept, observation_of({detection}));
        const Landmark landmark = only(map);
        const Eigen::Matrix2d P = landmark.P.topLeftCorner<2, 2>();
        least_ratio = std::min(least_ratio, smallest_eigenvalue(to_white * P * to_white.transpose()));
        if (scan != kLooks[look]) continue;
        const Eigen::Vector2d error = landmark.mean.head<2>() - truth;
        mean_nees[look++] += error.dot(P.inverse() * error) / kRuns;
      }
      EXPECT_EQ(map.landmarks().size(), 1u);
    }
  }
};

// Every scan shows the same error of the pose again, so the landmark's covariance must stop at the pose's share. P = C
// there, the gain is P / (P + R + C), and what the scans' own noise adds to the error is at most C / 2: the expected
// NEES lies between 2 and 3 however many scans. The mean over 40 runs of 2 degrees of freedom has a standard deviation
// of at most 3 / √40; bounds at 3.3 of them.
TEST(LandmarkFusion, TenThousandScansAtStandstillDoNotMakeALandmarkOverconfident) {
  const Standstill standstill;
  for (std::size_t i = 0; i < Standstill::kLooks.size(); ++i) {
    EXPECT_GT(standstill.mean_nees[i], 2.0 - 3.3 * 2.0 / std::sqrt(40.0)) << Standstill::kLooks[i];
    EXPECT_LT(standstill.mean_nees[i], 3.0 + 3.3 * 3.0 / std::sqrt(40.0)) << Standstill::kLooks[i];
  }
  // The floor is taken at the estimated place, which is off by centimetres in five metres.
  EXPECT_GT(standstill.least_ratio, 0.9);
}

// --- signatures
// ----------------------------------------------------------------------------------------------------------

class SignatureFusion : public ::testing::Test {
 protected:
  void see(Signature signature, int times) {
    Detection detection = detection_of({5.0, 1.0}, Eigen::Vector3d::Zero());
    detection.signature = signature;
    for (int i = 0; i < times; ++i) {
      step(map_, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(),
           observation_of({detection}));
    }
    ASSERT_EQ(map_.landmarks().size(), 1u);
  }
  Signature signature() const { return only(map_).signature; }
  int views() const { return only(map_).signature_views; }
  void use(const std::string& association) {
    map_ = map_with("{ attributes: [signature], negative_information: false, association: { signature_lambda: 0, " +
                    association + " } }");
  }

  static constexpr Signature kDark{0.9f, 0.1f};
  static constexpr Signature kBright{0.1f, 0.9f};
  // λ = 0: how signatures are fused must not depend on how they match.
  ParticleFeatureMap map_ = map_with(
      "{ attributes: [signature], negative_information: false, association: { signature_lambda: 0, signature_floor: "
      "0.01 } }");
};

TEST_F(SignatureFusion, IsTheProductOfTheViews) {
  see({0.6f, 0.4f}, 1);
  see({0.7f, 0.3f}, 1);
  EXPECT_NEAR(signature()[0], 0.42 / (0.42 + 0.12), 1e-5);
  EXPECT_NEAR(signature()[1], 0.12 / (0.42 + 0.12), 1e-5);
}

TEST_F(SignatureFusion, NoBinDiesHoweverManyViewsAgree) {
  see(kDark, 1000);
  EXPECT_GT(signature()[1], 0.0099f);  // the floor, up to the normalisation
  EXPECT_NEAR(signature()[0] + signature()[1], 1.0f, 1e-5f);
}

TEST_F(SignatureFusion, OneBadViewDoesNotDecide) {
  see(kDark, 10);
  see(kBright, 1);
  EXPECT_GT(signature()[0], signature()[1]);
}

TEST_F(SignatureFusion, AFewViewsCorrectAWrongSignature) {
  see(kDark, 1000);
  see(kBright, 4);
  EXPECT_GT(signature()[1], 0.9f);
}

TEST_F(SignatureFusion, AnUnknownLookChangesNothingAndIsNoView) {
  see({0.6f, 0.4f}, 1);
  const Signature before = signature();
  see(Signature{}, 5);
  EXPECT_EQ(only(map_).sightings, 6);
  EXPECT_EQ(views(), 1);
  EXPECT_EQ(signature()[0], before[0]);
  see({0.7f, 0.3f}, 1);
  EXPECT_NEAR(signature()[0], 0.42 / (0.42 + 0.12), 1e-5);
}

TEST_F(SignatureFusion, TheFirstLookAfterUnknownOnesIsTaken) {
  for (const char* rule : {"signature_fusion: product", "signature_fusion: dirichlet"}) {
    use(rule);
    see(Signature{}, 10);
    EXPECT_TRUE(signature().empty()) << rule;
    see({0.7f, 0.3f}, 1);
    EXPECT_NEAR(signature()[0], 0.7, 1e-6) << rule;
    EXPECT_EQ(views(), 1) << rule;
  }
}

TEST_F(SignatureFusion, UnderDirichletIsTheMeanOfTheViews) {
  use("signature_fusion: dirichlet");
  see({1.0f, 0.0f}, 1);
  see({0.5f, 0.5f}, 1);
  see({0.3f, 0.7f}, 1);
  EXPECT_NEAR(signature()[0], 0.6, 1e-6);
  EXPECT_NEAR(signature()[1], 0.4, 1e-6);
}

// What the product does and the mean does not: many slightly uneven views collapse to one bin.
TEST_F(SignatureFusion, ManyUnevenViewsCollapseTheProductButNotTheMean) {
  see({0.6f, 0.4f}, 50);
  EXPECT_GT(signature()[0], 0.98f);
  use("signature_fusion: dirichlet");
  see({0.6f, 0.4f}, 50);
  EXPECT_NEAR(signature()[0], 0.6, 1e-5);
}

TEST_F(SignatureFusion, AViewThatSharesNoBinIsOutvotedByThoseBefore) {
  use("signature_floor: 0.001");
  see({0.0f, 1.0f, 0.0f, 0.0f}, 3);
  see({0.0f, 0.0f, 0.0f, 1.0f}, 1);
  EXPECT_NEAR(signature()[1], signature()[3], 0.01);  // one against a signature that the floor has capped
  see({0.0f, 1.0f, 0.0f, 0.0f}, 1);
  EXPECT_GT(signature()[1], 0.9f);
}

TEST_F(SignatureFusion, ComesBackFromAnArchiveWithTheNumberOfViews) {
  use("signature_fusion: dirichlet");
  see({0.6f, 0.4f}, 2);
  see(Signature{}, 1);
  std::stringstream stream;
  OutArchive out(stream);
  map_.save(out);
  InArchive in(stream);
  ParticleFeatureMap loaded = map_with("{ attributes: [signature] }");
  loaded.load(in);
  EXPECT_EQ(only(loaded).signature_views, 2);
  EXPECT_EQ(only(loaded).sightings, 3);
  EXPECT_EQ(only(loaded).signature[0], signature()[0]);
}

TEST_F(SignatureFusion, ACopyThatLearnsALookLeavesTheOriginalUnknown) {
  see(Signature{}, 1);
  const ParticleFeatureMap original = map_;
  see({0.6f, 0.4f}, 1);
  EXPECT_TRUE(only(original).signature.empty());
  EXPECT_EQ(signature().size(), 2u);
}

std::vector<Sighting> sightings_of(const ParticleFeatureMap& map) {
  MapDescription description;
  map.describe(description);
  return description.sightings;
}

TEST(Sightings, AreKeptByLineOfDescentAndThroughACheckpoint) {
  auto map = map_with("{ keep_sightings: true, " + kWideGate);
  const Eigen::Vector3d pose(0.0, 0.0, 0.0);
  const Eigen::Matrix3d none = Eigen::Matrix3d::Zero();
  const auto see = [&](ParticleFeatureMap& seer, double t, const Eigen::Vector2d& p) {
    FeatureObservation observation = observation_of({detection_of(p, pose)});
    observation.stamp = Time{from_seconds(t)};
    step(seer, pose, none, none, observation);
  };
  see(map, 1.0, {5.0, 1.0});
  ParticleFeatureMap child = map;
  see(map, 2.0, {5.0, 1.0});
  see(child, 2.0, {-7.0, 3.0});

  const auto of_map = sightings_of(map);
  ASSERT_EQ(of_map.size(), 2u);
  EXPECT_TRUE(of_map[0].is_first);
  EXPECT_FALSE(of_map[1].is_first);
  EXPECT_EQ(of_map[0].landmark, of_map[1].landmark);
  EXPECT_EQ(of_map[1].stamp, Time{from_seconds(2.0)});
  EXPECT_TRUE(of_map[1].p_base.isApprox(Eigen::Vector2d(5.0, 1.0), 1e-12));
  const auto of_child = sightings_of(child);
  ASSERT_EQ(of_child.size(), 2u);
  EXPECT_TRUE(of_child[1].is_first);
  EXPECT_NE(of_child[1].landmark, of_child[0].landmark);

  std::stringstream stream;
  OutArchive out(stream);
  child.save(out);
  InArchive in(stream);
  auto loaded = map_with("{ keep_sightings: true, " + kWideGate);
  loaded.load(in);
  const auto of_loaded = sightings_of(loaded);
  ASSERT_EQ(of_loaded.size(), 2u);
  EXPECT_EQ(of_loaded[1].landmark, of_child[1].landmark);
  EXPECT_EQ(of_loaded[1].stamp, of_child[1].stamp);
  EXPECT_EQ(of_loaded[1].p_base, of_child[1].p_base);
}

TEST(Sightings, AreNotKeptUnlessAsked) {
  auto map = map_with("{ " + kWideGate);
  step(map, {0.0, 0.0, 0.0}, Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(),
       observation_of({detection_of({5.0, 1.0}, {0.0, 0.0, 0.0})}));
  EXPECT_TRUE(sightings_of(map).empty());
}

}  // namespace
}  // namespace waymark::feature_map
