// SPDX-License-Identifier: Apache-2.0
#include "particles/redrawing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace waymark::particles {
namespace {

/// Remembers where observations were written.
class Notebook final : public ParticleMap {
 public:
  explicit Notebook(std::vector<Pose>* written) : written_(written) {}
  std::unique_ptr<ParticleMap> clone() const override { return std::make_unique<Notebook>(written_); }
  std::unique_ptr<ParticleMap> blank() const override { return clone(); }
  void refine(const PoseGaussian&, const Pose&, const Observation&, Refinement&) const override {}
  void insert(const PoseGaussian& pose, const Observation&, const Association* association) override {
    EXPECT_EQ(association, nullptr);
    written_->push_back(pose.T_map_base);
  }
  void describe(MapDescription&) const override {}
  void save(OutArchive&) const override {}

 private:
  std::vector<Pose>* written_;
};

class Scan final : public Observation {};

/// A straight way of one metre a keyframe that was driven in a map where it lay turned by 90°.
std::vector<loops::Keyframe> way(std::size_t length, std::size_t points) {
  std::vector<loops::Keyframe> keyframes(length);
  for (std::size_t i = 0; i < length; ++i) {
    keyframes[i].observations.push_back({0, std::make_shared<Scan>()});
    keyframes[i].points = points;
    keyframes[i].T_map_base = Pose::planar(static_cast<double>(i), 0.0, 0.0);
    keyframes[i].xyyaw = {0.0, static_cast<double>(i), 1.5};
  }
  return keyframes;
}

loops::Correction correction(std::size_t length) {
  loops::Correction correction;
  for (std::size_t i = 0; i < length; ++i) correction.before.emplace_back(static_cast<double>(i), 0.0, 0.0);
  return correction;
}

ParticleMaps notebook(std::vector<Pose>& written) {
  ParticleMaps maps;
  maps.push_back(std::make_unique<Notebook>(&written));
  return maps;
}

TEST(Redrawing, DrawsAPieceInEachStep) {
  std::vector<Pose> written;
  const std::vector<loops::Keyframe> keyframes = way(12, 20'000);
  Redrawing redrawing(correction(10), notebook(written));
  int steps = 0;
  while (!redrawing.is_drawn()) {
    const std::size_t before = written.size();
    redrawing.draw_piece(keyframes);
    ASSERT_LE(written.size(), before + 3) << "60 000 points a step";
    ++steps;
  }
  EXPECT_EQ(steps, 4);
  ASSERT_EQ(written.size(), 10U) << "what came after the correction is not yet drawn";
  for (std::size_t i = 0; i < written.size(); ++i) {
    EXPECT_NEAR(written[i].p.x(), 0.0, 1e-12);
    EXPECT_NEAR(written[i].p.y(), static_cast<double>(i), 1e-12);
    EXPECT_NEAR(written[i].yaw(), 1.5, 1e-12);
  }
}

TEST(Redrawing, TheParticlesGoOnInWhatWasSeenLast) {
  std::vector<Pose> written;
  std::vector<loops::Keyframe> keyframes = way(102, 100);
  for (std::size_t i = 0; i < keyframes.size(); ++i) keyframes[i].way = static_cast<double>(i);
  Redrawing redrawing(correction(100), notebook(written));
  const ParticleMaps recent = redrawing.recent_maps(keyframes);
  ASSERT_EQ(recent.size(), 1U);
  ASSERT_EQ(written.size(), 21U) << "20 m of way";
  EXPECT_NEAR(written.front().p.x(), 79.0, 1e-12) << "where they lay before the correction";
  EXPECT_NEAR(written.back().p.x(), 99.0, 1e-12);
  EXPECT_EQ(redrawing.drawn(), 0U);
}

TEST(Redrawing, GoesOnFromACheckpoint) {
  std::vector<Pose> whole;
  std::vector<Pose> again;
  const std::vector<loops::Keyframe> keyframes = way(10, 10'000);
  Redrawing redrawing(correction(10), notebook(whole));
  redrawing.draw_piece(keyframes);
  Redrawing resumed(redrawing.correction(), notebook(again), keyframes, redrawing.drawn());
  while (!redrawing.is_drawn()) redrawing.draw_piece(keyframes);
  while (!resumed.is_drawn()) resumed.draw_piece(keyframes);
  ASSERT_EQ(whole.size(), 10U);
  ASSERT_EQ(again.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) EXPECT_EQ(again[i].p, whole[i].p);
}

TEST(Redrawing, LeavesOutAModuleThatIsDropped) {
  std::vector<Pose> written;
  Redrawing redrawing(correction(4), notebook(written));
  redrawing.drop_module(0);
  redrawing.draw_piece(way(4, 1));
  EXPECT_TRUE(redrawing.is_drawn());
  EXPECT_TRUE(written.empty());
}

TEST(Redrawing, MovesAPoseAlongWithItsPlace) {
  Pose pose = Pose::planar(2.0, 0.0, 0.1);
  pose.p.z() = 0.7;
  const Pose result = moved(pose, {1.0, 0.0, 0.0}, {5.0, 5.0, 1.5});
  EXPECT_NEAR(result.p.x(), 5.0 + std::cos(1.5), 1e-12);
  EXPECT_NEAR(result.p.y(), 5.0 + std::sin(1.5), 1e-12);
  EXPECT_NEAR(result.yaw(), 1.6, 1e-12);
  EXPECT_EQ(result.p.z(), 0.7);
}

}  // namespace
}  // namespace waymark::particles
