// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/association/pose_refinement.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "map_modules/feature_map/association/likelihoods.hpp"
#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::detection_of;
using feature_map_test::gaussian_at;
using feature_map_test::landmark_at;
using feature_map_test::observation_of;
using feature_map_test::settings_of;

constexpr double kLogTwoPi = 1.8378770664093453;
const Eigen::Vector3d kPose(1.0, -2.0, 0.4);

const std::string kPlain = "{ negative_information: false, association: { gate_probability: 0.999 } }";

Eigen::Matrix3d prior_covariance() {
  Eigen::Matrix3d A;
  A << 0.06, 0.0, 0.0, 0.02, 0.05, 0.0, 0.004, -0.003, 0.008;
  return A * A.transpose();
}

template <int D = 2>
Refinement associated(const LandmarkStore& store, const FeatureMapSettings& settings, const Eigen::Matrix3d& P,
                      const FeatureObservation& observation, FeatureAssociation& association) {
  Refinement refinement;
  associate_and_refine<D>(store, settings, 0.5, gaussian_at(kPose, P), observation, association, refinement);
  return refinement;
}

/// Id of the landmark that detection `d` is associated with, or -1.
std::int64_t id_of(const LandmarkStore& store, const FeatureAssociation& association, std::size_t d) {
  const LandmarkRef ref = association.landmark_of[d];
  return ref.chunk >= 0 ? store.at(ref).id : -1;
}

double log_normal(const Eigen::VectorXd& nu, const Eigen::MatrixXd& S) {
  const Eigen::LLT<Eigen::MatrixXd> factor(S);
  const double log_determinant = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
  return -0.5 * (nu.dot(factor.solve(nu)) + log_determinant + static_cast<double>(nu.size()) * kLogTwoPi);
}

/// Four landmarks, and detections of them from near the prior mean with small errors.
struct Scene {
  LandmarkStore store;
  std::vector<Landmark> landmarks;
  FeatureObservation observation;

  explicit Scene(const Eigen::Vector3d& true_pose) {
    const Eigen::Vector2d places[] = {{6.0, 1.0}, {3.0, 5.0}, {-4.0, 2.0}, {2.0, -8.0}};
    std::vector<Detection> detections;
    for (int i = 0; i < 4; ++i) {
      Landmark landmark = landmark_at(places[i].x(), places[i].y(), 0.03 + 0.01 * i);
      landmark.P(0, 1) = landmark.P(1, 0) = 0.2 * landmark.P(0, 0);
      landmark.P(0, 2) = landmark.P(2, 0) = -0.1 * landmark.P(0, 0);
      landmarks.push_back(landmark);
      store.add(landmark);
      detections.push_back(detection_of(places[i] + Eigen::Vector2d(0.02, -0.01 * i), true_pose, 0.04));
      detections.back().xyr.z() += 0.01 * i;
    }
    observation = observation_of(std::move(detections));
  }
};

/// EKF-SLAM with all landmarks in one state, observations in the robot's own frame, one after the other.
template <int D>
struct JointEkf {
  Eigen::VectorXd mean;
  Eigen::MatrixXd P;
  double log_evidence = 0.0;

  JointEkf(const Eigen::Matrix3d& prior, const std::vector<Landmark>& landmarks)
      : mean(3 + D * static_cast<int>(landmarks.size())), P(Eigen::MatrixXd::Zero(mean.size(), mean.size())) {
    mean.head<3>() = kPose;
    P.topLeftCorner<3, 3>() = prior;
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      const int at = 3 + D * static_cast<int>(i);
      mean.segment<D>(at) = landmarks[i].mean.head<D>();
      P.block<D, D>(at, at) = landmarks[i].P.topLeftCorner<D, D>();
    }
  }

  void update(std::size_t landmark, const Detection& z) {
    const int at = 3 + D * static_cast<int>(landmark);
    const Eigen::Matrix2d back = Eigen::Rotation2Dd(-mean[2]).toRotationMatrix();
    const Eigen::Vector2d d = mean.segment<2>(at) - mean.head<2>();
    Eigen::Matrix<double, D, 1> h = mean.segment<D>(at);
    h.template head<2>() = back * d;
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(D, mean.size());
    H.block<2, 2>(0, 0) = -back;
    H.block<2, 1>(0, 2) = back * Eigen::Vector2d(d.y(), -d.x());
    H.block<D, D>(0, at).setIdentity();
    H.block<2, 2>(0, at) = back;
    const Eigen::VectorXd nu = z.xyr.head<D>() - h;
    const Eigen::MatrixXd S = H * P * H.transpose() + z.R.topLeftCorner<D, D>();
    log_evidence += log_normal(nu, S);
    const Eigen::MatrixXd K = P * H.transpose() * S.inverse();
    mean += K * nu;
    P = ((Eigen::MatrixXd::Identity(mean.size(), mean.size()) - K * H) * P).eval();
  }
};

template <int D>
void expect_equal_to_joint_ekf(const std::string& yaml) {
  const Scene scene(kPose + Eigen::Vector3d(0.03, -0.02, 0.005));
  const Eigen::Matrix3d P = prior_covariance();
  FeatureAssociation association;
  const FeatureMapSettings settings = settings_of(yaml);
  const Refinement refinement = associated<D>(scene.store, settings, P, scene.observation, association);
  JointEkf<D> joint(P, scene.landmarks);
  for (std::size_t i = 0; i < 4; ++i) {
    ASSERT_EQ(id_of(scene.store, association, i), static_cast<std::int64_t>(i));
    joint.update(i, scene.observation.detections[i]);
  }
  const Eigen::Matrix3d refined = (P.inverse() + refinement.information).inverse();
  EXPECT_LT((refined - joint.P.template topLeftCorner<3, 3>()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((kPose + refined * refinement.gradient - joint.mean.template head<3>()).cwiseAbs().maxCoeff(), 1e-9);
  const double detected = 4.0 * std::log(settings.association.detection_probability);
  EXPECT_NEAR(refinement.log_evidence - detected, joint.log_evidence, 1e-9);
}

TEST(PoseRefinement, RefinesThePoseAsAnEkfWithAllLandmarksInItsState) { expect_equal_to_joint_ekf<2>(kPlain); }

TEST(PoseRefinement, RefinesThePoseAsAnEkfWithRadiiInItsState) {
  expect_equal_to_joint_ekf<3>(
      "{ attributes: [radius], negative_information: false, association: { gate_probability: 0.999 } }");
}

// With the heading known the model is linear, so the scan has one joint Gaussian: N(ν; 0, H P Hᵀ + diag(Σ + R)).
TEST(PoseRefinement, EvidenceIsTheJointGaussianOfTheScan) {
  const Scene scene(kPose + Eigen::Vector3d(0.04, 0.03, 0.0));
  Eigen::Matrix3d P = prior_covariance();
  P.row(2).setZero();
  P.col(2).setZero();
  const FeatureMapSettings settings = settings_of(kPlain);
  FeatureAssociation association;
  const Refinement refinement = associated(scene.store, settings, P, scene.observation, association);

  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(kPose.z()).toRotationMatrix();
  Eigen::VectorXd nu(8);
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(8, 8);
  for (int i = 0; i < 4; ++i) {
    const Detection& z = scene.observation.detections[static_cast<std::size_t>(i)];
    const Landmark& landmark = scene.landmarks[static_cast<std::size_t>(i)];
    nu.segment<2>(2 * i) = kPose.head<2>() + turn * z.xyr.head<2>() - landmark.mean.head<2>();
    S.block<2, 2>(2 * i, 2 * i) =
        landmark.P.topLeftCorner<2, 2>() + turn * z.R.topLeftCorner<2, 2>() * turn.transpose();
    for (int j = 0; j < 4; ++j) S.block<2, 2>(2 * i, 2 * j) += P.topLeftCorner<2, 2>();
  }
  const double expected = log_normal(nu, S) + 4.0 * std::log(settings.association.detection_probability);
  EXPECT_NEAR(refinement.log_evidence, expected, 1e-9);
}

TEST(PoseRefinement, TwoDetectionsNeverShareALandmark) {
  LandmarkStore store;
  const auto id = store.add(landmark_at(5.0, 0.0));
  FeatureAssociation association;
  associated(store, settings_of(kPlain), prior_covariance(),
             observation_of({detection_of({5.06, 0.0}, kPose), detection_of({5.01, 0.0}, kPose)}), association);
  EXPECT_EQ(id_of(store, association, 0), -1);
  EXPECT_EQ(id_of(store, association, 1), id);  // the likelier one
}

TEST(PoseRefinement, ALandmarkThatIsTakenLeavesTheNextBest) {
  LandmarkStore store;
  const auto near = store.add(landmark_at(5.0, 0.0));
  const auto far = store.add(landmark_at(5.25, 0.0));
  FeatureAssociation association;
  // Both detections are nearer to the first landmark.
  associated(store, settings_of(kPlain), prior_covariance(),
             observation_of({detection_of({5.01, 0.0}, kPose), detection_of({5.11, 0.0}, kPose)}), association);
  EXPECT_EQ(id_of(store, association, 0), near);
  EXPECT_EQ(id_of(store, association, 1), far);
}

TEST(PoseRefinement, TheGateCountsThePosesUncertaintyToo) {
  LandmarkStore store;
  store.add(landmark_at(5.0, 0.0));
  const auto seen = observation_of({detection_of({5.4, 0.0}, kPose)});  // σ of landmark and detection together: 0.07 m
  FeatureAssociation association;
  associated(store, settings_of(kPlain), Eigen::Matrix3d::Zero(), seen, association);
  EXPECT_EQ(id_of(store, association, 0), -1);
  associated(store, settings_of(kPlain), Eigen::Vector3d(0.04, 0.04, 0.0).asDiagonal(), seen, association);
  EXPECT_EQ(id_of(store, association, 0), 0);
}

TEST(PoseRefinement, NothingNearIsANewLandmark) {
  LandmarkStore store;
  store.add(landmark_at(5.0, 0.0));
  FeatureAssociation association;
  const auto settings = settings_of(kPlain);
  const auto refinement =
      associated(store, settings, prior_covariance(), observation_of({detection_of({0.0, 6.0}, kPose)}), association);
  EXPECT_EQ(association.landmark_of[0].chunk, FeatureAssociation::kNew);
  EXPECT_TRUE(refinement.information.isZero());
  EXPECT_NEAR(refinement.log_evidence, std::log(0.01), 1e-12);  // p₀ = ρ_new
}

TEST(PoseRefinement, BelowTheNewLandmarkLikelihoodALandmarkIsNoMatch) {
  LandmarkStore store;
  store.add(landmark_at(5.0, 0.0, 3.0));  // so uncertain that its density falls below a new landmark's
  const auto seen = observation_of({detection_of({5.0, 0.0}, kPose)});
  FeatureAssociation association;
  associated(store, settings_of("{ negative_information: false, association: { new_landmark_density_per_m2: 0.1 } }"),
             prior_covariance(), seen, association);
  EXPECT_EQ(id_of(store, association, 0), -1);
  associated(store, settings_of("{ negative_information: false, association: { new_landmark_density_per_m2: 0.001 } }"),
             prior_covariance(), seen, association);
  EXPECT_EQ(id_of(store, association, 0), 0);
}

TEST(PoseRefinement, AProvisionalLandmarkProvesNothing) {
  LandmarkStore store;
  Landmark provisional = landmark_at(5.0, 0.0);
  provisional.sightings = 1;
  store.add(provisional);
  FeatureAssociation association;
  const auto refinement = associated(store, settings_of(kPlain), prior_covariance(),
                                     observation_of({detection_of({5.0, 0.0}, kPose)}), association);
  EXPECT_EQ(id_of(store, association, 0), 0);
  EXPECT_NEAR(refinement.log_evidence, std::log(0.01), 1e-12);
}

TEST(PoseRefinement, TheRadiusTellsNeighboursApart) {
  LandmarkStore store;
  const auto thin = store.add(landmark_at(5.0, 0.1, 0.05, 0.1));
  const auto thick = store.add(landmark_at(5.0, -0.1, 0.05, 0.6));
  FeatureAssociation association;
  const auto settings = settings_of("{ attributes: [radius], negative_information: false }");
  const Eigen::Matrix3d P = Eigen::Vector3d(0.01, 0.01, 0.0).asDiagonal();
  associated<3>(store, settings, P, observation_of({detection_of({5.0, 0.0}, kPose, 0.05, 0.58)}), association);
  EXPECT_EQ(id_of(store, association, 0), thick);
  associated<3>(store, settings, P, observation_of({detection_of({5.0, 0.0}, kPose, 0.05, 0.12)}), association);
  EXPECT_EQ(id_of(store, association, 0), thin);
}

TEST(PoseRefinement, TheSignatureTellsNeighboursApart) {
  LandmarkStore store;
  Landmark dark = landmark_at(5.0, 0.1);
  dark.signature = {0.95f, 0.05f};
  Landmark bright = landmark_at(5.0, -0.1);
  bright.signature = {0.05f, 0.95f};
  const auto dark_id = store.add(dark);
  const auto bright_id = store.add(bright);
  const auto settings = settings_of("{ attributes: [signature], negative_information: false }");
  Detection detection = detection_of({5.0, 0.0}, kPose);
  FeatureAssociation association;
  detection.signature = dark.signature;
  associated(store, settings, prior_covariance(), observation_of({detection}), association);
  EXPECT_EQ(id_of(store, association, 0), dark_id);
  detection.signature = bright.signature;
  associated(store, settings, prior_covariance(), observation_of({detection}), association);
  EXPECT_EQ(id_of(store, association, 0), bright_id);
}

/// Evidence of a detection 3 cm beside a landmark, with these looks.
double log_evidence_of(const Signature& seen, const Signature& known, const std::string& yaml) {
  LandmarkStore store;
  Landmark landmark = landmark_at(5.0, 0.03);
  landmark.signature = known;
  store.add(landmark);
  Detection detection = detection_of({5.0, 0.0}, kPose);
  detection.signature = seen;
  FeatureAssociation association;
  const double log_evidence = associated(store, settings_of("{ negative_information: false, " + yaml),
                                         prior_covariance(), observation_of({detection}), association)
                                  .log_evidence;
  EXPECT_EQ(id_of(store, association, 0), 0);
  return log_evidence;
}

TEST(UnknownSignature, OfADetectionWeighsAsIfThereWereNoSignatures) {
  const double without = log_evidence_of({}, {}, "}");
  const Signature look{0.9f, 0.1f};
  for (const char* distance : {"0.2", "0.8"}) {
    const std::string yaml =
        std::string("attributes: [signature], association: { new_landmark_signature_distance: ") + distance + " } }";
    EXPECT_NEAR(log_evidence_of({}, look, yaml), without, 1e-9);
    EXPECT_NEAR(log_evidence_of({}, {}, yaml), without, 1e-9);
  }
}

TEST(UnknownSignature, OfALandmarkIsWorthWhatAnyOtherLandmarksIs) {
  const std::string yaml = "attributes: [signature], association: { new_landmark_signature_distance: 0.3 } }";
  EXPECT_NEAR(log_evidence_of({0.9f, 0.1f}, {}, yaml), log_evidence_of({}, {}, "}") - 20.0 * 0.3, 1e-9);
}

TEST(UnknownSignature, NeitherAttractsNorRepels) {
  LandmarkStore store;
  Landmark far = landmark_at(5.0, 0.2);
  far.signature = {0.9f, 0.1f};
  Landmark near = landmark_at(5.0, -0.1);
  near.signature = {0.1f, 0.9f};
  store.add(far);
  const auto near_id = store.add(near);
  Detection detection = detection_of({5.0, 0.0}, kPose);
  detection.signature = {};
  FeatureAssociation association;
  const auto settings = settings_of("{ attributes: [signature], negative_information: false }");
  associated(store, settings, prior_covariance(), observation_of({detection}), association);
  EXPECT_EQ(id_of(store, association, 0), near_id);  // place alone
}

TEST(NewLandmarkLikelihood, IsADensityOverAllThatTakesPart) {
  const std::string association =
      "association: { new_landmark_density_per_m2: 0.02, radius_range_m: 0.5, signature_lambda: 20 } }";
  EXPECT_NEAR(log_new_landmark(settings_of("{ " + association), 0.3), std::log(0.02), 1e-12);
  EXPECT_NEAR(log_new_landmark(settings_of("{ attributes: [radius], " + association), 0.3), std::log(0.02 / 0.5),
              1e-12);
  EXPECT_NEAR(log_new_landmark(settings_of("{ attributes: [radius, signature], " + association), 0.3),
              std::log(0.02 / 0.5) - 6.0, 1e-12);
}

TEST(SignatureDistance, IsTheSquaredHellingerDistance) {
  EXPECT_NEAR(signature_distance({0.3f, 0.7f}, {0.3f, 0.7f}), 0.0, 1e-6);
  EXPECT_NEAR(signature_distance({1.0f, 0.0f}, {0.0f, 1.0f}), 1.0, 1e-12);
  EXPECT_NEAR(signature_distance({0.5f, 0.5f}, {1.0f, 0.0f}), 1.0 - std::sqrt(0.5), 1e-6);
}

/// Two equal landmarks 0.6 m apart across the line of sight, and a third one far away, all seen from kPose; the prior's
/// mean lies between the two ways to see it.
struct Twins {
  LandmarkStore store;
  FeatureMapSettings settings;
  Eigen::Matrix3d P = Eigen::Vector3d(0.09, 0.09, 1e-6).asDiagonal();

  explicit Twins(const std::string& ratio)
      : settings(
            settings_of("{ negative_information: false, association: { gate_probability: 0.999, min_separation_m: 0.1, "
                        "min_likelihood_ratio: " +
                        ratio + " } }")) {
    store.add(landmark_at(6.0, 0.0));
    store.add(landmark_at(6.0, 0.6));
    store.add(landmark_at(-5.0, -2.0));
  }
  static Eigen::Vector3d true_pose() { return kPose + Eigen::Vector3d(0.0, 0.25, 0.0); }
  static Detection of_twin() { return detection_of({6.0, 0.6}, true_pose()); }
  static Detection of_third() { return detection_of({-5.0, -2.0}, true_pose()); }
};

TEST(Ratio, WithoutItTheNearerOneIsTaken) {
  const Twins twins("1");
  FeatureAssociation association;
  associated(twins.store, twins.settings, twins.P, observation_of({Twins::of_twin()}), association);
  EXPECT_EQ(id_of(twins.store, association, 0), 1);
}

TEST(Ratio, WhatCannotBeToldApartIsLeftOut) {
  const Twins twins("10");
  FeatureAssociation association;
  const Refinement refinement =
      associated(twins.store, twins.settings, twins.P, observation_of({Twins::of_twin()}), association);
  EXPECT_EQ(association.landmark_of[0].chunk, FeatureAssociation::kAmbiguous);
  EXPECT_TRUE(refinement.information.isZero(0.0));
  EXPECT_GT(refinement.log_evidence, log_new_landmark(twins.settings, 0.5)) << "it counts as seen all the same";
}

TEST(Ratio, AClearDetectionDecidesAnAmbiguousOne) {
  const Twins twins("10");
  FeatureAssociation association;
  associated(twins.store, twins.settings, twins.P, observation_of({Twins::of_twin(), Twins::of_third()}), association);
  EXPECT_EQ(id_of(twins.store, association, 1), 2);
  EXPECT_EQ(id_of(twins.store, association, 0), 1);
}

}  // namespace
}  // namespace waymark::feature_map
