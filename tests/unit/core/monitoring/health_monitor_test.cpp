// SPDX-License-Identifier: Apache-2.0
#include "monitoring/health_monitor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace waymark::monitoring {
namespace {

using ::testing::HasSubstr;

Time at(double t) { return Time{from_seconds(t)}; }

constexpr std::size_t kWheels = 0;
constexpr std::size_t kAid = 1;
constexpr double kCertain = 0.1;

/// A robot with wheels and one more sensor, whose log the test writes.
class HealthTest : public ::testing::Test {
 protected:
  explicit HealthTest(HealthMonitor::Role aid = {.name = "gps", .is_aiding = true})
      : monitor_({}, {{.name = "wheels", .is_motion_source = true}, aid}, false) {
    monitor_.start(at(0.0));
  }

  void see(std::size_t sensor, double t, const UpdateResult& result = {}, double sigma = kCertain) {
    monitor_.record(sensor, at(t), result);
    judge(t, sigma);
  }
  void judge(double t, double sigma = kCertain) {
    monitor_.judge(at(t), {sigma});
    const Health::State now = monitor_.health().state;
    if (now == state_) return;
    shortest_ = changed_ ? std::min(shortest_, t - *changed_) : shortest_;
    changed_ = t;
    state_ = now;
    ++changes_;
  }
  const Health& health() const { return monitor_.health(); }

  HealthMonitor monitor_;
  Health::State state_ = Health::State::ok;
  std::optional<double> changed_;
  double shortest_ = 1e9;  // time in one state, but for the first
  int changes_ = 0;
};

UpdateResult position(double nis = 2.0) {
  UpdateResult result;
  result.nis = nis;
  result.dof = 2;
  result.observes_position = true;
  return result;
}

TEST_F(HealthTest, APauseOfTheLogIsNoSilence) {
  for (int k = 0; k < 600; ++k) {
    const double t = 0.1 * k + (k >= 300 ? 20.0 : 0.0);  // nothing at all for 20 s
    see(kAid, t, position());
    see(kWheels, t);
    ASSERT_EQ(health().state, Health::State::ok) << t << " s: " << health().reason;
  }
  EXPECT_EQ(monitor_.times().lost_s, 0.0);
  EXPECT_NEAR(monitor_.times().ok_s, 60.0, 1.0);
}

TEST_F(HealthTest, ASensorThatIsSilentWhileOthersDeliverIsSilent) {
  for (int k = 0; k < 100; ++k) {
    if (k < 50) see(kWheels, 0.1 * k);
    see(kAid, 0.1 * k, position());
  }
  EXPECT_EQ(health().state, Health::State::lost);
  EXPECT_EQ(health().reason, "no motion source delivers");
  EXPECT_EQ(health().sensors[kWheels].state, SensorHealth::State::silent);
}

TEST_F(HealthTest, AHeightThatNothingObservesIsDegraded) {
  double height = 0.0;
  for (int k = 0; k < 200; ++k) {
    monitor_.record(kWheels, at(0.1 * k), {});
    monitor_.record(kAid, at(0.1 * k), position());
    if (k >= 100) height += 0.5;
    monitor_.judge(at(0.1 * k), {.position = kCertain, .height = height});
    if (k < 100) {
      ASSERT_EQ(health().state, Health::State::ok) << k;
    }
  }
  EXPECT_EQ(health().state, Health::State::degraded);
  EXPECT_EQ(health().reason, "the height is too uncertain");
}

TEST_F(HealthTest, AnAttitudeThatNothingObservesIsDegraded) {
  for (int k = 0; k < 100; ++k) {
    monitor_.record(kWheels, at(0.1 * k), {});
    monitor_.record(kAid, at(0.1 * k), position());
    monitor_.judge(at(0.1 * k), {.position = kCertain, .tilt = 0.3});
  }
  EXPECT_EQ(health().state, Health::State::degraded);
  EXPECT_EQ(health().reason, "roll and pitch are too uncertain");
}

TEST_F(HealthTest, APositionAtTheLimitDoesNotFlicker) {
  for (int k = 0; k < 2000; ++k) {
    see(kWheels, 0.1 * k, {}, 10.5);
    see(kAid, 0.1 * k, position(), k < 1000 ? 9.5 : 5.0);  // each fix brings it below
  }
  EXPECT_LE(changes_, 2);
  EXPECT_GE(shortest_, 0.5);
}

TEST_F(HealthTest, ParticlesAtMoreThanOnePlaceAreDegraded) {
  for (int k = 0; k < 200; ++k) {
    monitor_.set_modes(k < 50 || k >= 150 ? 1 : 2);
    see(kWheels, 0.1 * k);
    see(kAid, 0.1 * k, position());
    if (k == 45 || k == 195) {
      EXPECT_EQ(health().state, Health::State::ok);
    }
    if (k == 100) {
      EXPECT_EQ(health().state, Health::State::degraded);
      EXPECT_THAT(health().reason, HasSubstr("more than one place"));
    }
  }
}

TEST_F(HealthTest, ACovarianceThatIsTooSmallIsDegraded) {
  for (int k = 0; k < 100; ++k) {
    monitor_.set_particles_alone(k >= 50);
    see(kWheels, 0.1 * k);
    see(kAid, 0.1 * k, position());
    if (k == 45) {
      EXPECT_EQ(health().state, Health::State::ok);
    }
  }
  EXPECT_EQ(health().state, Health::State::degraded);
  EXPECT_THAT(health().reason, HasSubstr("the joint Gaussian was given up"));
}

TEST_F(HealthTest, EveryStateLastsForAWhile) {
  for (int k = 0; k < 3000; ++k) {
    UpdateResult fix = position();
    if (k % 73 == 0) fix.degraded_reason = "settling";
    see(kWheels, 0.1 * k);
    see(kAid, 0.1 * k, fix);
  }
  EXPECT_GT(changes_, 10);
  EXPECT_GE(shortest_, 0.499);
}

TEST_F(HealthTest, AReacquisitionIsLostAtOnceAndForSeconds) {
  for (int k = 0; k < 100; ++k) {
    if (k == 50) monitor_.reacquired(at(5.0));
    see(kWheels, 0.1 * k);
    see(kAid, 0.1 * k, position());
    if (k == 50) {
      EXPECT_EQ(health().state, Health::State::lost);
    }
  }
  EXPECT_EQ(health().state, Health::State::lost) << "5 s, and 2 s until it is believed";
  EXPECT_NEAR(monitor_.times().lost_s, 4.9, 0.11);
  EXPECT_NEAR(monitor_.times().lost_share(), 0.5, 0.02);
}

TEST_F(HealthTest, ContinuesWhereItWasSaved) {
  HealthMonitor other({}, {{.name = "wheels", .is_motion_source = true}, {.name = "gps", .is_aiding = true}}, false);
  for (int k = 0; k < 80; ++k) {
    if (k == 50) monitor_.reacquired(at(5.0));
    see(kWheels, 0.1 * k);
  }
  std::stringstream stream;
  OutArchive out(stream);
  out(monitor_);
  InArchive in(stream);
  in(other);
  EXPECT_EQ(other.health().state, Health::State::lost);
  EXPECT_EQ(other.health().reason, monitor_.health().reason);
  for (int k = 80; k < 140; ++k) {
    see(kWheels, 0.1 * k);
    other.record(kWheels, at(0.1 * k), {});
    other.judge(at(0.1 * k), {kCertain});
    ASSERT_EQ(other.health().state, health().state) << k;
  }
  EXPECT_EQ(other.times().lost_s, monitor_.times().lost_s);
}

/// A robot with a compass: nothing observes its position.
class HealthOfDeadReckoning : public HealthTest {
 protected:
  HealthOfDeadReckoning() : HealthTest({.name = "compass", .is_aiding = true}) {}
};

TEST_F(HealthOfDeadReckoning, IsJudgedByWhatIsObserved) {
  for (int k = 0; k < 1000; ++k) {
    see(kWheels, 0.1 * k, {}, 0.5 * k);
    see(kAid, 0.1 * k, {.nis = 1.0, .dof = 1}, 0.5 * k);
  }
  EXPECT_EQ(health().state, Health::State::ok) << health().reason;
}

/// A robot that makes a map.
class HealthOfAMap : public HealthTest {
 protected:
  HealthOfAMap() : HealthTest({.name = "lidar", .is_aiding = true, .localizes = true}) {}
  void drive(int from, int to, int failing_of_ten, bool contradicts = true) {
    for (int k = from; k < to; ++k) {
      see(kWheels, 0.1 * k);
      const bool fails = k % 10 < failing_of_ten;
      see(kAid, 0.1 * k,
          {.fate = Fate::mapped, .localized = !fails, .match_failed = fails, .match_searched = fails && contradicts});
    }
  }
};

TEST_F(HealthOfAMap, ScansThatDoNotFitTheMapCount) {
  drive(0, 300, 1);
  EXPECT_EQ(health().state, Health::State::ok) << health().reason;
  drive(300, 600, 3);
  EXPECT_EQ(health().state, Health::State::degraded);
  EXPECT_THAT(health().reason, HasSubstr("lidar is degraded: some of its scans do not fit the map"));
  drive(600, 900, 7);
  EXPECT_THAT(health().reason, HasSubstr("most of its scans do not fit the map"));
}

TEST_F(HealthOfAMap, ScansThatSeeLittleOfItCountWhereTheyAreMost) {
  drive(0, 300, 3, false);
  EXPECT_EQ(health().state, Health::State::ok) << health().reason;
  drive(300, 600, 7, false);
  EXPECT_THAT(health().reason, HasSubstr("most of its scans do not fit the map"));
}

TEST_F(HealthOfAMap, ScansThatDoNotFitWhereTheyAreExpectedCount) {
  const auto see_searches = [&](int from, int of_ten) {
    for (int k = from; k < from + 100; ++k) {
      see(kWheels, 0.1 * k);
      see(kAid, 0.1 * k, {.fate = Fate::mapped, .localized = true, .match_searched = k % 10 < of_ten});
    }
  };
  see_searches(0, 5);  // a scanner that turns far between two scans
  EXPECT_EQ(health().state, Health::State::ok) << health().reason;
  see_searches(100, 9);
  EXPECT_EQ(health().state, Health::State::degraded);
  EXPECT_THAT(health().reason, HasSubstr("where the robot is expected"));
  see_searches(200, 1);
  EXPECT_EQ(health().state, Health::State::ok) << health().reason;
}

TEST_F(HealthOfAMap, MayBeTornUntilALoopRelatesBothSides) {
  const auto see_tears = [&](double t, std::size_t suspected_tears) {
    for (double end = t + 10.0; t < end; t += 0.1) {
      see(kWheels, t);
      see(kAid, t, {.fate = Fate::mapped, .localized = true, .suspected_tears = suspected_tears});
    }
  };
  see_tears(0.0, 0);
  see_tears(10.0, 1);  // one alone
  EXPECT_EQ(health().state, Health::State::ok) << health().reason;
  see_tears(20.0, 2);
  EXPECT_EQ(health().state, Health::State::degraded);
  EXPECT_THAT(health().reason, HasSubstr("the map may be torn"));
  see_tears(30.0, 2);
  EXPECT_EQ(health().state, Health::State::degraded);
  see_tears(40.0, 0);
  EXPECT_EQ(health().state, Health::State::ok) << health().reason;
}

TEST_F(HealthOfAMap, AnUncertainPositionInNewPlacesIsDegraded) {
  for (int k = 0; k < 100; ++k) {
    see(kWheels, 0.1 * k, {}, 20.0);
    see(kAid, 0.1 * k, {.fate = Fate::mapped, .localized = true}, 20.0);
  }
  EXPECT_EQ(health().state, Health::State::degraded);
  EXPECT_THAT(health().reason, HasSubstr("in new places"));
}

TEST_F(HealthOfAMap, APositionThatNoScanFixesIsLost) {
  for (int k = 0; k < 100; ++k) see(kWheels, 0.1 * k, {}, 20.0);
  EXPECT_EQ(health().state, Health::State::lost);
}

}  // namespace
}  // namespace waymark::monitoring
