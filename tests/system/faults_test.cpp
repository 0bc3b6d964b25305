// SPDX-License-Identifier: Apache-2.0
// needs plugins: compass, dgps, diagnostics, imu, odometry, simulator, tum
// The robot of config/faults.yaml with one fault after the other: no divergence, no lock-out, and the health names what
// is wrong. How often the position is outside its 3σ ellipse while the health is ok is a number, and checked.
// docs/results/faults.md has the table over more seeds.
#include <gmock/gmock.h>

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "waymark/host/session.hpp"

namespace waymark {
namespace {

/// What a run gave, sampled ten times a second.
struct Result {
  double largest_m = 0.0;
  double end_m = 0.0;           ///< mean error of the last ten seconds
  int ok = 0;                   ///< samples while the health was ok
  int ok_outside = 0;           ///< of these: outside the 3σ ellipse of the position
  std::set<std::string> named;  ///< "gps silent"
};

class FaultyRun {
 public:
  explicit FaultyRun(const std::vector<Config::Override>& overrides)
      : session_(host::Robot::load(Config::load(WAYMARK_SOURCE_DIR "/config/faults.yaml", overrides),
                                   PluginLoader({WAYMARK_PLUGIN_DIR})),
                 {.observer = [this](const Snapshot& snapshot, double) { look(snapshot); }}) {}

  Result run() {
    session_.play();
    const host::SessionResult ended = session_.finish();
    EXPECT_THAT(ended.failures, ::testing::IsEmpty());
    const std::size_t tail = std::min<std::size_t>(errors_.size(), 100);
    for (std::size_t i = errors_.size() - tail; i < errors_.size(); ++i) {
      result_.end_m += errors_[i] / static_cast<double>(tail);
    }
    return result_;
  }

 private:
  void look(const Snapshot& snapshot) {
    if (!snapshot.started()) return;
    const Health& health = snapshot.health();
    const std::vector<SensorSlot>& sensors = session_.robot().sensors;
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      if (health.sensors[i].state == SensorHealth::State::ok) continue;
      result_.named.insert(sensors[i].name + " " + to_string(health.sensors[i].state));
    }
    if (snapshot.stamp() < due_) return;
    due_ = snapshot.stamp() + from_seconds(0.1);
    const std::vector<Reference::Point>& truth = session_.robot().source->reference()->trajectory;
    const auto after = std::find_if(truth.begin() + next_, truth.end(),
                                    [&](const Reference::Point& point) { return point.stamp >= snapshot.stamp(); });
    if (after == truth.end() || after == truth.begin()) return;
    next_ = after - truth.begin() - 1;
    const Reference::Point& before = truth[static_cast<std::size_t>(next_)];
    const double share = to_seconds(snapshot.stamp() - before.stamp) / to_seconds(after->stamp - before.stamp);
    const Eigen::Vector3d p = before.T_map_base.p + share * (after->T_map_base.p - before.T_map_base.p);
    const Eigen::Vector2d error = (snapshot.belief().mean.T_map_base.p - p).head<2>();
    const Eigen::Matrix2d P = pose_covariance(snapshot.belief(), snapshot.layout()).topLeftCorner<2, 2>();
    errors_.push_back(error.norm());
    result_.largest_m = std::max(result_.largest_m, error.norm());
    if (health.state != Health::State::ok) return;
    ++result_.ok;
    result_.ok_outside += error.dot(P.inverse() * error) > 9.0 ? 1 : 0;
  }

  Time due_{};
  std::ptrdiff_t next_ = 0;
  std::vector<double> errors_;
  Result result_;
  host::Session session_;  // last: it calls look()
};

Result run(std::vector<Config::Override> overrides, int seed) {
  overrides.push_back("source.seed=" + std::to_string(seed));
  overrides.push_back("filter.seed=" + std::to_string(seed));
  overrides.emplace_back("sinks=[]");
  return FaultyRun(overrides).run();
}

TEST(Health, IsOffBeyond3SigmaAboutAsRarelyAsAnHonestCovarianceIs) {
  int ok = 0;
  int outside = 0;
  for (int seed = 1; seed <= 6; ++seed) {
    const Result result = run({}, seed);
    ok += result.ok;
    outside += result.ok_outside;
  }
  ASSERT_GT(ok, 6 * 2500);
  const double share = static_cast<double>(outside) / ok;  // 0.011 is right; errors last, so it scatters
  EXPECT_LT(share, 0.035);
  EXPECT_GT(share, 0.001) << "covariances far too large are not honest either";
}

TEST(Health, DoesNotCallThePositionGoodThatSlippingWheelsHaveSpoilt) {
  int ok = 0;
  int outside = 0;
  for (int seed = 1; seed <= 4; ++seed) {
    const Result result = run({"source.wheels.spins_s=[50, 55, 120, 125, 200, 205]"}, seed);
    ok += result.ok;
    outside += result.ok_outside;
  }
  ASSERT_GT(ok, 4 * 2000);
  EXPECT_LT(static_cast<double>(outside) / ok, 0.08);  // half of it before one-sided innovations were watched for
}

struct Fault {
  std::string name;
  std::vector<Config::Override> overrides;
  double largest_m;   ///< the position is never farther off
  std::string named;  ///< what the health must have said; empty: nothing is asked
};

void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class Faults : public ::testing::TestWithParam<Fault> {};

TEST_P(Faults, NeitherDivergeNorLockOutAndAreNamed) {
  for (int seed = 1; seed <= 2; ++seed) {
    const Result result = run(GetParam().overrides, seed);
    EXPECT_LT(result.largest_m, GetParam().largest_m) << "seed " << seed;
    EXPECT_LT(result.end_m, 0.6) << "seed " << seed << ": a fault that is over has been overcome";
    if (!GetParam().named.empty()) {
      EXPECT_TRUE(result.named.count(GetParam().named) == 1) << GetParam().named << ", seed " << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    OfTheSimulator, Faults,
    ::testing::Values(Fault{"outliers", {"source.gps.outlier_probability=0.1"}, 0.8, "gps degraded"},
                      Fault{"many_outliers", {"source.gps.outlier_probability=0.3"}, 0.8, "gps degraded"},
                      Fault{"frozen", {"source.gps.frozen_s=[60, 75, 160, 175]"}, 0.8, "gps degraded"},
                      Fault{"outage", {"source.gps.outages_s=[100, 220]"}, 2.0, "gps silent"},
                      Fault{"field", {"source.magnetism.disturbances_s=[60, 80, 160, 180]"}, 0.8, "compass degraded"},
                      Fault{"slip", {"source.wheels.spins_s=[50, 55, 120, 125, 200, 205]"}, 2.0, "gps degraded"},
                      Fault{"wheels_die", {"source.wheels.dead_s=[100, 120]"}, 1.5, "wheels silent"},
                      Fault{"imu_dies", {"source.imu.dead_s=[100, 120]"}, 0.8, "imu silent"},
                      Fault{"nan", {"source.gps.nan_probability=0.05", "source.wheels.nan_probability=0.05"}, 0.8, ""},
                      Fault{"late",
                            {"source.gps.delay_jitter_s=1", "source.wheels.delay_jitter_s=1",
                             "source.imu.delay_jitter_s=1", "filter.max_latency_s=0"},
                            1.5,
                            ""}),
    [](const auto& fault) { return fault.param.name; });

}  // namespace
}  // namespace waymark
