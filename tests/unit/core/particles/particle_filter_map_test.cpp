// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "unit/core/particle_run.hpp"

namespace waymark {
namespace {

using test::ParticleRun;
using test::ToyMap;
using test::ToyModule;
using Fails = ToyMap::Fails;

ParticleFilterSettings settings() {
  ParticleFilterSettings s;
  s.particles = 12;
  return s;
}

const std::vector<double>& written(ParticleRun& run, std::size_t particle, std::size_t module) {
  return static_cast<const ToyMap&>(*run.filter().particles()[particle].maps[module]).written();
}

/// Runs of one good module alone, and of the same with another one before or behind it.
class FailingModule : public ::testing::TestWithParam<std::pair<Fails, bool>> {
 protected:
  static bool first() { return GetParam().second; }
  static std::size_t good() { return first() ? 1 : 0; }
  static std::size_t bad() { return first() ? 0 : 1; }
  static std::vector<std::shared_ptr<MapModule>> two_modules() {
    const auto fine = std::make_shared<ToyModule>();
    const auto failing = std::make_shared<ToyModule>(GetParam().first, 5);
    if (first()) return {failing, fine};
    return {fine, failing};
  }
};

TEST_P(FailingModule, IsDroppedForAllParticlesAndTheOtherOneContinues) {
  ParticleRun run(settings(), two_modules());
  run.filter().start(run.prior(), true);
  Random noise = test::stream(31);
  const auto failures = run.map(Pose{}, noise);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_EQ(failures[0].first, static_cast<int>(bad()));
  EXPECT_THAT(failures[0].second, ::testing::StartsWith("a toy that breaks in"));
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ(run.filter().particles()[i].maps[bad()], nullptr);
    ASSERT_NE(run.filter().particles()[i].maps[good()], nullptr);
    EXPECT_EQ(written(run, i, good()).size(), 1U)
        << "every particle's other map must have been written, also number 5's";
  }
  EXPECT_TRUE(run.map(Pose{}, noise).empty()) << "it is out of service";
}

INSTANTIATE_TEST_SUITE_P(Places, FailingModule,
                         ::testing::Values(std::pair{Fails::in_refine, true}, std::pair{Fails::in_refine, false},
                                           std::pair{Fails::in_insert, true}, std::pair{Fails::in_insert, false}));

/// What a map of this kind keeps between refine and insert.
struct Marked final : Association {
  explicit Marked(int k) : kind(k) {}
  int kind;
};

class MarkingMap final : public ParticleMap {
 public:
  MarkingMap(int kind, int& strangers) : kind_(kind), strangers_(strangers) {}
  std::unique_ptr<ParticleMap> clone() const override { return std::make_unique<MarkingMap>(*this); }
  void refine(const PoseGaussian&, const Pose&, const Observation&, Refinement& out) const override {
    meet(out.association.get());
    if (!out.association) out.association = std::make_unique<Marked>(kind_);
  }
  void insert(const PoseGaussian&, const Observation&, const Association* association) override { meet(association); }
  void describe(MapDescription&) const override {}
  void save(OutArchive&) const override {}

 private:
  void meet(const Association* association) const {
    if (association != nullptr && static_cast<const Marked*>(association)->kind != kind_) ++strangers_;
  }
  int kind_;
  int& strangers_;
};

class MarkingModule final : public MapModule {
 public:
  explicit MarkingModule(int kind) : kind_(kind) {}
  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<MarkingMap>(kind_, strangers_); }
  std::shared_ptr<const Observation> extract(const Measurement&, std::span<const Companion>,
                                             const MotionWindow&) override {
    return nullptr;
  }
  std::unique_ptr<ParticleMap> load_map(InArchive&) const override { return create_map(); }
  int strangers() const { return strangers_; }

 private:
  int kind_;
  mutable int strangers_ = 0;
};

TEST(ParticleFilterMap, EveryModuleGetsItsOwnAssociationsWhateverOthersTakePart) {
  const auto grid = std::make_shared<MarkingModule>(0);
  const auto features = std::make_shared<MarkingModule>(1);
  ParticleRun run(settings(), {grid, features});
  run.filter().start(run.prior(), true);
  const test::Sighting sighting;
  const std::vector<particles::MappingInput> both{{0, &sighting, 1.0, true}, {1, &sighting, 1.0, true}};
  const std::vector<particles::MappingInput> second{{1, &sighting, 1.0, true}};
  for (const auto& inputs : {both, second, both}) EXPECT_TRUE(run.filter().map(inputs, 3).empty());
  EXPECT_EQ(grid->strangers(), 0);
  EXPECT_EQ(features->strangers(), 0);
}

TEST(ParticleFilterMap, AModuleThatBreaksInRefineLeavesTheResultOfTheOthersAlone) {
  ParticleRun alone(settings(), {std::make_shared<ToyModule>()});
  ParticleRun with_bad(settings(), {std::make_shared<ToyModule>(Fails::in_refine, 5), std::make_shared<ToyModule>()});
  for (ParticleRun* run : {&alone, &with_bad}) {
    run->filter().start(run->prior(), true);
    run->drive(0, 10);
  }
  for (std::size_t i = 0; i < 12; ++i) {
    const particles::Particle& a = alone.filter().particles()[i];
    const particles::Particle& b = with_bad.filter().particles()[i];
    EXPECT_EQ(a.log_weight, b.log_weight);
    EXPECT_EQ(a.belief.P, b.belief.P);
    EXPECT_EQ(a.belief.mean.T_map_base.p, b.belief.mean.T_map_base.p);
    EXPECT_EQ(written(alone, i, 0), written(with_bad, i, 1));
  }
}

TEST(ParticleFilterMap, EvidenceThatIsNotFiniteCountsAsFailure) {
  ParticleRun run(settings(), {std::make_shared<ToyModule>()});
  run.filter().start(run.prior(), true);
  test::Sighting sighting;
  sighting.see(Pose{}, {1.0, std::nan("")}, {0.0, 0.0});
  const std::vector<particles::MappingInput> inputs = {{0, &sighting, 1.0, true}};
  EXPECT_EQ(run.filter().map(inputs, 0).size(), 1U);
  EXPECT_TRUE(run.filter().mixture().P.allFinite());
}

TEST(ParticleFilterMap, AMapThatOnlyMapsDoesNotMoveTheWeights) {
  ParticleFilterSettings still = settings();
  still.sampling_fraction = 0.0;
  ParticleRun run(still, {std::make_shared<ToyModule>()});
  run.filter().start(run.prior(), true);
  const Belief before = run.filter().particles()[3].belief;
  test::Sighting sighting;
  sighting.see(Pose::planar(3.0, 0.0, 0.0), {1.0, 2.0}, {0.0, 0.0});
  const std::vector<particles::MappingInput> inputs = {{0, &sighting, 1.0, false}};
  EXPECT_TRUE(run.filter().map(inputs, 0).empty());
  EXPECT_EQ(run.filter().particles()[3].belief.P, before.P);
  EXPECT_NEAR(run.filter().effective_sample_size(), 12.0, 1e-9);
  EXPECT_EQ(written(run, 3, 0).size(), 1U);
}

TEST(ParticleFilterMap, WhereNothingIsWrittenNothingIsSampled) {
  ParticleFilterSettings sampled = settings();
  sampled.sampling_fraction = 1.0;
  sampled.resample_threshold = 0.0;
  ParticleRun run(sampled, {std::make_shared<ToyModule>()});
  run.filter().start(run.prior(), false);
  test::Sighting sighting;
  sighting.sigma_m = 100.0;  // so weak that the prior stays as it is
  sighting.see(Pose{}, {5.0, 3.0}, {0.0, 0.0});
  const std::vector<particles::MappingInput> inputs = {{0, &sighting, 1.0, true}};
  const double before = run.filter().particles()[0].belief.P(0, 0);
  sighting.writes = false;
  run.filter().map(inputs, 0);
  EXPECT_GT(run.filter().particles()[0].belief.P(0, 0), 0.99 * before);
  EXPECT_EQ(run.filter().particles()[0].belief.mean.T_map_base.p, run.filter().particles()[1].belief.mean.T_map_base.p);
  sighting.writes = true;
  run.filter().map(inputs, 0);
  EXPECT_LT(run.filter().particles()[0].belief.P(0, 0), 1e-12);
  EXPECT_NE(run.filter().particles()[0].belief.mean.T_map_base.p, run.filter().particles()[1].belief.mean.T_map_base.p);
}

TEST(ParticleFilterMap, TwoHalfSharesOfOneSightingEqualOneWhole) {
  ParticleFilterSettings still = settings();
  still.sampling_fraction = 0.0;  // or the halves would be linearised elsewhere
  ParticleRun whole(still, {std::make_shared<ToyModule>()});
  ParticleRun halves(still, {std::make_shared<ToyModule>(), std::make_shared<ToyModule>()});
  test::Sighting sighting;
  sighting.sigma_m = 100.0;  // so weak that the second half is linearised where the first was
  sighting.see(Pose{}, {5.0, 3.0}, {0.0, 0.0});
  for (ParticleRun* run : {&whole, &halves}) run->filter().start(run->prior(), false);
  whole.filter().map(std::vector<particles::MappingInput>{{0, &sighting, 1.0, true}}, 0);
  halves.filter().map(std::vector<particles::MappingInput>{{0, &sighting, 0.5, true}, {1, &sighting, 0.5, true}}, 0);
  EXPECT_LT((whole.filter().mixture().P - halves.filter().mixture().P).cwiseAbs().maxCoeff(), 1e-9);
}

// One landmark determines two of the three directions, and its NIS is that of the sighting: rᵀ (H P Hᵀ + R)⁻¹ r.
TEST(ParticleFilterMap, TheInnovationOfMapsIsThatOfWhatTheySaw) {
  ParticleRun run(settings(), {std::make_shared<ToyModule>()});
  run.filter().start(run.prior(), false);
  const Pose prior = run.filter().particles()[0].belief.mean.T_map_base;
  const Eigen::Matrix3d P = pose_covariance(run.filter().particles()[0].belief, run.layout());
  const Eigen::Vector2d landmark(5.0, 3.0);
  test::Sighting sighting;
  sighting.see(Pose::planar(prior.p.x() + 0.3, prior.p.y() - 0.2, prior.yaw() + 0.05), landmark, {0.0, 0.0});
  run.filter().map(std::vector<particles::MappingInput>{{0, &sighting, 1.0, true}}, 0);

  const Eigen::Vector2d away = landmark - prior.p.head<2>();
  const Eigen::Matrix2d R_base_map = prior.q.toRotationMatrix().topLeftCorner<2, 2>().transpose();
  Eigen::Matrix<double, 2, 3> H;
  H << -R_base_map, R_base_map * Eigen::Vector2d(away.y(), -away.x());
  const Eigen::Vector2d residual = sighting.landmarks[0].p_base - R_base_map * away;
  const Eigen::Matrix2d S = H * P * H.transpose() + sighting.sigma_m * sighting.sigma_m * Eigen::Matrix2d::Identity();
  EXPECT_EQ(run.filter().map_innovation().dof, 2);
  EXPECT_NEAR(run.filter().map_innovation().nis, residual.dot(S.inverse() * residual), 1e-6);

  run.filter().map(std::vector<particles::MappingInput>{{0, &sighting, 1.0, false}}, 0);
  EXPECT_EQ(run.filter().map_innovation().dof, 0) << "it does not localise";
}

TEST(ParticleFilterMap, ReportsTheRefinedMixtureUntilTheNextChange) {
  ParticleFilterSettings sampled = settings();
  sampled.particles = 1;
  sampled.sampling_fraction = 1.0;
  ParticleRun run(sampled, {std::make_shared<ToyModule>()});
  run.filter().start(run.prior(), false);
  Random noise = test::stream(32);
  run.map(Pose{}, noise);
  EXPECT_GT(run.filter().mixture().P(0, 0), 1e-4) << "before sampling";
  EXPECT_LT(run.filter().particles()[0].belief.P(0, 0), 1e-12) << "after sampling";
}

/// Where a single particle is after one mapping step.
Eigen::Vector3d mapped_at(double sampling_fraction, std::uint64_t seed) {
  ParticleFilterSettings alone = settings();
  alone.particles = 1;
  alone.sampling_fraction = sampling_fraction;
  alone.seed = seed;
  ParticleRun run(alone, {std::make_shared<ToyModule>()});
  run.filter().start(run.prior(), false);
  test::Sighting sighting;
  sighting.see(Pose{}, {5.0, 3.0}, {0.0, 0.0});
  const double before = run.filter().particles()[0].belief.P(0, 0);
  run.filter().map(std::vector<particles::MappingInput>{{0, &sighting, 1.0, true}}, 0);
  EXPECT_LT(run.filter().particles()[0].belief.P(0, 0), before);
  return run.filter().particles()[0].belief.mean.T_map_base.p;
}

TEST(ParticleFilterMap, ASingleParticleIsDrawnOnlyAsPublished) {
  EXPECT_EQ(mapped_at(0.5, 1), mapped_at(0.5, 2)) << "it takes its mean";
  EXPECT_NE(mapped_at(1.0, 1), mapped_at(1.0, 2)) << "FastSLAM 2.0";
}

TEST(ParticleFilterMap, RecordsThePathAtEveryMappingStep) {
  ParticleRun run(settings(), {std::make_shared<ToyModule>()});
  run.filter().start(run.prior(), true);
  run.drive(0, 7);
  EXPECT_EQ(run.filter().mapping_steps(), 7U);
  for (const particles::Particle& particle : run.filter().particles()) EXPECT_EQ(particle.path.poses().size(), 7U);
}

}  // namespace
}  // namespace waymark
