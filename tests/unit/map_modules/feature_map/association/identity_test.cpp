// SPDX-License-Identifier: Apache-2.0
// Identities that a device reads off landmarks: what they decide, and what a misreading can do.
#include <gtest/gtest.h>

#include "map_modules/feature_map/association/pose_refinement.hpp"
#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::detection_of;
using feature_map_test::gaussian_at;
using feature_map_test::landmark_at;
using feature_map_test::observation_of;
using feature_map_test::settings_of;
using feature_map_test::step;

const Eigen::Vector3d kPose(1.0, -2.0, 0.4);
const Eigen::Matrix3d kPrior = Eigen::Vector3d(0.01, 0.01, 1e-4).asDiagonal();
const std::string kKnown = "{ identity: known, negative_information: false }";

Detection read(int identity, const Eigen::Vector2d& p_map, double sigma = 0.05) {
  Detection detection = detection_of(p_map, kPose, sigma);
  detection.identity = identity;
  return detection;
}

Landmark carrying(int identity, double east, double north) {
  Landmark landmark = landmark_at(east, north);
  landmark.identity = identity;
  return landmark;
}

/// Associates and refines; returns the association with the log evidence.
struct Associated {
  FeatureAssociation association;
  Refinement refinement;

  Associated(const LandmarkStore& store, const std::string& yaml, const FeatureObservation& observation) {
    associate_and_refine<2>(store, settings_of(yaml), 0.5, gaussian_at(kPose, kPrior), observation, association,
                            refinement);
  }
  std::int64_t id_of(const LandmarkStore& store, std::size_t detection) const {
    const LandmarkRef ref = association.landmark_of[detection];
    return ref.chunk >= 0 ? store.at(ref).id : ref.chunk;
  }
};

ParticleFeatureMap map_with(const std::string& yaml) {
  return ParticleFeatureMap(std::make_shared<FeatureMapSettings>(settings_of(yaml)));
}

TEST(KnownIdentity, DecidesAgainstTheNearerLandmark) {
  LandmarkStore store;
  store.add(carrying(7, 5.0, 0.0));
  const auto own = store.add(carrying(8, 5.2, 0.0));
  const Associated associated(store, kKnown, observation_of({read(8, {5.02, 0.0})}));
  EXPECT_EQ(associated.id_of(store, 0), own);
}

TEST(KnownIdentity, AnUnknownOneIsANewLandmarkThoughAnotherStandsThere) {
  LandmarkStore store;
  store.add(carrying(7, 5.0, 0.0));
  const Associated associated(store, kKnown, observation_of({read(9, {5.01, 0.0})}));
  EXPECT_EQ(associated.id_of(store, 0), FeatureAssociation::kNew);
  EXPECT_NEAR(associated.refinement.log_evidence, std::log(0.01), 1e-12);  // p₀ = ρ_new
}

TEST(KnownIdentity, WhatFailsTheGateIsRejectedAndNoDuplicate) {
  LandmarkStore store;
  store.add(carrying(7, 5.0, 0.0));
  const Associated associated(store, kKnown, observation_of({read(7, {7.0, 1.0})}));
  EXPECT_EQ(associated.id_of(store, 0), FeatureAssociation::kAmbiguous);
  EXPECT_NEAR(associated.refinement.log_evidence, std::log(0.01), 1e-12);
  EXPECT_TRUE(associated.refinement.information.isZero());
}

TEST(KnownIdentity, ALandmarkOutOfReachIsStillKnown) {
  LandmarkStore store;
  store.add(carrying(7, 400.0, 0.0));
  const Associated associated(store, kKnown, observation_of({read(7, {5.0, 0.0})}));
  EXPECT_EQ(associated.id_of(store, 0), FeatureAssociation::kAmbiguous);
}

TEST(KnownIdentity, ItsGateIsWiderThanThatOfAPlace) {
  LandmarkStore store;
  const auto own = store.add(carrying(7, 5.0, 0.0));
  const auto observation = observation_of({read(7, {5.45, 0.0})});  // about 3.7 σ
  EXPECT_EQ(Associated(store, kKnown, observation).id_of(store, 0), own);
  EXPECT_EQ(Associated(store, "{ negative_information: false }", observation).id_of(store, 0),
            FeatureAssociation::kAmbiguous);
  EXPECT_EQ(
      Associated(store,
                 "{ identity: known, negative_information: false, association: { identity_gate_probability: 0.99 } }",
                 observation)
          .id_of(store, 0),
      FeatureAssociation::kAmbiguous);
}

TEST(KnownIdentity, ReadTwiceInOneImageMakesOneLandmark) {
  ParticleFeatureMap map = map_with(kKnown);
  const auto twice = observation_of({read(7, {5.0, 0.0}), read(7, {6.0, 1.0})});
  step(map, kPose, kPrior, Eigen::Matrix3d::Zero(), twice);
  EXPECT_EQ(map.landmarks().size(), 1u);
  step(map, kPose, kPrior, Eigen::Matrix3d::Zero(), twice);
  EXPECT_EQ(map.landmarks().size(), 1u);
}

TEST(KnownIdentity, WithoutOneADetectionTellsNothing) {
  ParticleFeatureMap map = map_with(kKnown);
  step(map, kPose, kPrior, Eigen::Matrix3d::Zero(), observation_of({read(-1, {5.0, 0.0})}));
  EXPECT_EQ(map.landmarks().size(), 0u);
}

TEST(KnownIdentity, NeighboursNearerThanTheSeparationAreTwo) {
  ParticleFeatureMap map = map_with(kKnown);  // min_separation_m is 0.5
  step(map, kPose, kPrior, Eigen::Matrix3d::Zero(), observation_of({read(7, {5.0, 0.0})}));
  step(map, kPose, kPrior, Eigen::Matrix3d::Zero(), observation_of({read(8, {5.1, 0.0})}));
  EXPECT_EQ(map.landmarks().size(), 2u);
}

// --- as a signature
// ---------------------------------------------------------------------------------------------------

TEST(IdentitySignature, IsADistributionThatFavoursWhatWasRead) {
  const Signature signature = Signature::of_identity(3, 10, 0.09);
  float sum = 0.0f;
  for (const float bin : signature) sum += bin;
  EXPECT_NEAR(sum, 1.0f, 1e-6f);
  EXPECT_NEAR(signature[3], 0.91f, 1e-6f);
  EXPECT_NEAR(signature[9], 0.01f, 1e-6f);
}

TEST(IdentitySignature, NothingReadIsUniform) {
  for (const float bin : Signature::of_identity(-1, 10, 0.09)) EXPECT_NEAR(bin, 0.1f, 1e-6f);
}

const std::string kSignature =
    "{ identity: signature, negative_information: false, signature: { bins: 100, misreading_probability: 0.01 },"
    " association: { min_separation_m: 0, signature_floor: 1.0e-4, new_landmark_signature_distance: 0.5 } }";

Detection soft(int identity, const Eigen::Vector2d& p_map) {
  Detection detection = detection_of(p_map, kPose);
  detection.signature = Signature::of_identity(identity, 100, 0.01);
  detection.identity = identity;
  return detection;
}

TEST(IdentitySignature, TellsNeighboursApart) {
  ParticleFeatureMap map = map_with(kSignature);
  for (int i = 0; i < 5; ++i) {
    step(map, kPose, kPrior, Eigen::Matrix3d::Zero(), observation_of({soft(7, {5.0, 0.0})}));
    step(map, kPose, kPrior, Eigen::Matrix3d::Zero(), observation_of({soft(8, {5.1, 0.0})}));
  }
  MapDescription description;
  map.describe(description);
  ASSERT_EQ(description.landmarks.size(), 2u);
  EXPECT_NEAR(description.landmarks[0].p_map.x(), 5.0, 0.02);
  EXPECT_NEAR(description.landmarks[1].p_map.x(), 5.1, 0.02);
  EXPECT_EQ(description.landmarks[0].sightings, 5);
}

TEST(IdentitySignature, OneMisreadingDoesNotChangeWhatALandmarkIs) {
  ParticleFeatureMap map = map_with(kSignature);
  for (int i = 0; i < 5; ++i) step(map, kPose, kPrior, Eigen::Matrix3d::Zero(), observation_of({soft(7, {5.0, 0.0})}));
  step(map, kPose, kPrior, Eigen::Matrix3d::Zero(), observation_of({soft(43, {5.0, 0.0})}));
  step(map, kPose, kPrior, Eigen::Matrix3d::Zero(), observation_of({soft(7, {5.0, 0.0})}));
  MapDescription description;
  map.describe(description);
  EXPECT_GE(description.landmarks[0].sightings, 6);
}

TEST(IdentitySignature, MakesNoSecondLandmarkThatLooksTheSame) {
  ParticleFeatureMap map = map_with(kSignature);
  for (int i = 0; i < 3; ++i) step(map, kPose, kPrior, Eigen::Matrix3d::Zero(), observation_of({soft(7, {5.0, 0.0})}));
  step(map, kPose, kPrior, Eigen::Matrix3d::Zero(), observation_of({soft(7, {9.0, 3.0})}));
  EXPECT_EQ(map.landmarks().size(), 1u);
}

TEST(IdentitySettings, AreChecked) {
  EXPECT_THROW(settings_of("{ identity: perhaps }"), ConfigError);
  EXPECT_THROW(settings_of("{ identity: signature, signature: { bins: 1000 } }"), ConfigError);
  EXPECT_TRUE(settings_of("{ identity: signature }").use_signature);
  EXPECT_FALSE(settings_of("{ identity: known }").use_signature);
}

}  // namespace
}  // namespace waymark::feature_map
