// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "unit/sensors/sensor_bench.hpp"

namespace waymark {
namespace {

using sensor_test::measurement_of;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Motion = StateLayout::Motion;

struct Bench {
  explicit Bench(const std::string& keys, Motion motion = Motion::spatial)
      : sensor(make(keys)), layout(motion, {{"altimeter", sensor->block()}}) {
    state.block.setZero(layout.block_size());
  }
  static std::shared_ptr<Sensor> make(const std::string& keys) {
    const Rig rig({{"altimeter", "", Pose{Eigen::Quaterniond::Identity(), {0.4, 0.1, -0.2}}}});
    const Config config = Config::parse("{ name: altimeter" + keys + " }");
    auto sensor = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Sensor>("altimeter", config, rig);
    config.reject_unread();
    return sensor;
  }
  std::size_t feed(double height, double sigma = NAN) {
    updates.clear();
    Height payload;
    payload.height_m = height;
    payload.sigma_m = sigma;
    Belief belief;
    belief.mean = state;
    belief.P.setIdentity(layout.size(), layout.size());
    sensor->process(measurement_of(payload), {belief, layout, state.block.data(), nullptr, false}, updates);
    return updates.size();
  }
  Linearization model() const {
    Linearization out;
    updates[0].linearize({state, state.block.data()}, out);
    return out;
  }

  std::shared_ptr<Sensor> sensor;
  StateLayout layout;
  NavState state;
  UpdateList updates;
};

TEST(Altimeter, MeasuresTheHeightOfTheSensor) {
  Bench bench(", sigma_m: 0.1, level_m: 100");
  bench.state.T_map_base = Pose{so3::from_rpy(0.0, -0.5, 0.0), {3.0, 4.0, 102.0}};  // nose up
  ASSERT_EQ(bench.feed(2.0 + 0.4 * std::sin(0.5) - 0.2 * std::cos(0.5)), 1u);
  EXPECT_NEAR(bench.model().residual(0), 0.0, 1e-12);
  EXPECT_NEAR(bench.model().R(0, 0), 0.01, 1e-15);
}

TEST(Altimeter, JacobiansAgreeWithDifferences) {
  Bench bench(", sigma_m: 0.1, offset_sigma_m: 0.5");
  bench.state.T_map_base = Pose{so3::from_rpy(0.2, -0.3, 1.0), {3.0, 4.0, 2.0}};
  bench.feed(1.0);
  const Linearization model = bench.model();
  const NavState state = bench.state;
  const std::array<std::pair<int, double>, 5> columns = {std::pair{2, model.get(Linearization::kPosition)(0, 2)},
                                                         {3, model.get(Linearization::kAttitude)(0, 0)},
                                                         {4, model.get(Linearization::kAttitude)(0, 1)},
                                                         {5, model.get(Linearization::kAttitude)(0, 2)},
                                                         {kCoreStates, model.get_block()(0, 0)}};
  for (const auto& [column, analytic] : columns) {
    std::array<double, 2> moved{};
    for (int side = 0; side < 2; ++side) {
      ErrorVector delta = ErrorVector::Zero(bench.layout.size());
      delta[column] = side == 0 ? 1e-5 : -1e-5;
      bench.state = state;
      boxplus(bench.state, delta, bench.layout);
      moved[static_cast<std::size_t>(side)] = bench.model().residual(0);
    }
    EXPECT_NEAR(-(moved[0] - moved[1]) / 2e-5, analytic, 1e-6) << column;
  }
}

TEST(Altimeter, InThePlaneItSaysNothing) {
  Bench bench(", sigma_m: 0.1", Motion::planar);
  EXPECT_EQ(bench.feed(2.0), 0u);
}

TEST(Altimeter, TheReportedSigmaCountsAboveTheFloor) {
  Bench bench(", sigma_m: 0.1");
  bench.feed(1.0, 0.5);
  EXPECT_NEAR(bench.model().R(0, 0), 0.25, 1e-15);
  bench.feed(1.0, 0.01);
  EXPECT_NEAR(bench.model().R(0, 0), 0.01, 1e-15);
}

TEST(Altimeter, TheOffsetIsAStateOfItsOwn) {
  EXPECT_TRUE(Bench(", sigma_m: 0.1").sensor->block().empty());
  const auto markov = Bench(", sigma_m: 0.1, offset_sigma_m: 0.5, offset_tau_s: 30").sensor->block();
  ASSERT_EQ(markov.size(), 1u);
  EXPECT_EQ(markov[0].stationary_sigma, 0.5);
  EXPECT_EQ(markov[0].tau_s, 30.0);
  const auto walk = Bench(", sigma_m: 0.1, offset_sigma_m: 0.5, offset_walk_m_per_sqrt_s: 0.02").sensor->block();
  EXPECT_EQ(walk[0].tau_s, 0.0);
  EXPECT_EQ(walk[0].walk_per_sqrt_s, 0.02);
  Bench bench(", sigma_m: 0.1, offset_sigma_m: 0.5");
  bench.state.block[0] = 0.3;
  bench.feed(0.3 - 0.2);
  EXPECT_NEAR(bench.model().residual(0), 0.0, 1e-12);
}

TEST(Altimeter, RefusesWhatCannotBe) {
  Bench bench(", sigma_m: 0.1");
  EXPECT_THROW(bench.feed(NAN), DataError);
  EXPECT_THROW(Bench(""), ConfigError);
  EXPECT_THROW(Bench(", sigma_m: 0"), ConfigError);
  EXPECT_NO_THROW(
      Bench(", sigma_m: 0.1, offset_tau_s: 0, offset_walk_m_per_sqrt_s: 0"));  // as a written configuration has it
  try {
    const Bench offset_of_none(", sigma_m: 0.1, offset_tau_s: 3");
    FAIL() << "not refused";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("text:1:"), HasSubstr("needs offset_sigma_m above 0")));
  }
}

}  // namespace
}  // namespace waymark
