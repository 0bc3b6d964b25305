// SPDX-License-Identifier: Apache-2.0
// The kit must find faults: one sensor that is good, and the same with one fault at a time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <stdexcept>

#include "our_plugins.hpp"
#include "waymark/testing/sensor_contract.hpp"

namespace waymark::contract_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

enum class Fault {
  none,
  wrong_sign,
  slightly_wrong_jacobian,
  missing_block_jacobian,
  negative_r,
  asymmetric_r,
  nan_residual,
  no_reset,
  counts_calls,
  too_wide_block,
  shared_state,
  forgetful_clone,
  no_save,
  forgetful_load,
  lazy_load,
  reads_too_little,
  random_process,
  swallows_foreign_payload,
  asserts_finite_values,
  smooths_over_all,
  throws_int,
  unnamed_state,
  twin_names,
  negative_sigma,
  dead_state
};

/// Range and bearing to a beacon at the origin, with a bias of the range as a state; noise grows with the number of
/// measurements so far.
class BeaconUpdate final : public Update {
 public:
  BeaconUpdate(double range, double bearing, double sigma, Fault fault)
      : range_(range), bearing_(bearing), sigma_(sigma), fault_(fault) {}

  void linearize(const StateView& state, Linearization& out) const override {
    if (fault_ != Fault::no_reset || out.rows() == 0) out.reset(2, fault_ == Fault::too_wide_block ? 2 : 1);
    const Eigen::Vector2d d = -state.nav.T_map_base.p.head<2>();
    const double r = d.norm();
    out.residual[0] = range_ - r - state.block[0];
    out.residual[1] = so3::wrap(bearing_ - std::atan2(d.y(), d.x()) + state.nav.T_map_base.yaw());
    out.R.diagonal().setConstant(sigma_ * sigma_);
    out.position().topLeftCorner<1, 2>() = -d.transpose() / r;
    out.position().bottomLeftCorner<1, 2>() << d.y() / (r * r), -d.x() / (r * r);
    out.attitude()(1, 2) = fault_ == Fault::wrong_sign ? 1.0 : -1.0;
    if (fault_ != Fault::missing_block_jacobian)
      out.block()(0, 0) = fault_ == Fault::slightly_wrong_jacobian ? 1.00001 : 1.0;
    if (fault_ == Fault::negative_r) out.R(1, 1) = -1.0;
    if (fault_ == Fault::asymmetric_r) out.R(0, 1) = 0.1 * sigma_ * sigma_;
    if (fault_ == Fault::nan_residual) out.residual[0] = std::nan("");
    if (fault_ == Fault::counts_calls) out.R(0, 0) += 1e-6 * calls_++;
    // A plugin that relies on zeros which it did not write: position and block of an earlier call stay in `out`.
    if (fault_ == Fault::no_reset) out.attitude()(0, 2) += 1.0;
  }

 private:
  double range_;
  double bearing_;
  double sigma_;
  Fault fault_;
  static inline std::atomic<int> calls_ = 0;
};

class Beacon final : public Sensor {
 public:
  explicit Beacon(Fault fault) : fault_(fault), count_(std::make_shared<int>(0)) {}
  Beacon(const Beacon& other) : Sensor(other), fault_(other.fault_), count_(other.count_), smooth_(other.smooth_) {
    if (fault_ != Fault::shared_state)
      count_ = std::make_shared<int>(fault_ == Fault::forgetful_clone ? 0 : *other.count_);
  }

  StateBlock block() const override {
    BlockState bias;
    bias.name = fault_ == Fault::unnamed_state ? "" : "range_bias_m";
    bias.initial_sigma = fault_ == Fault::negative_sigma ? -0.1 : (fault_ == Fault::dead_state ? 0.0 : 0.1);
    return StateBlock(fault_ == Fault::twin_names ? 2 : 1, bias);
  }

  void process(const Measurement& measurement, const Prediction&, UpdateList& out) override {
    if (fault_ == Fault::throws_int) throw 42;
    if (fault_ == Fault::swallows_foreign_payload && measurement.payload->type() != WheelSpeeds::kType) return;
    const auto& wheels = measurement.as<WheelSpeeds>();  // stands for range and bearing
    if (fault_ == Fault::asserts_finite_values && !std::isfinite(wheels.left_mps)) throw std::logic_error("impossible");
    smooth_ += 0.5 * (wheels.left_mps - smooth_);
    ++*count_;
    if (fault_ == Fault::random_process) *count_ += static_cast<int>(draws_++ % 7);
    out.emplace<BeaconUpdate>(fault_ == Fault::smooths_over_all ? smooth_ : wheels.left_mps, wheels.right_mps,
                              0.1 * *count_, fault_);
  }

  std::unique_ptr<Sensor> clone() const override { return std::make_unique<Beacon>(*this); }
  void save(OutArchive& out) const override {
    if (fault_ == Fault::no_save) return;
    out.section("beacon", 1);
    out.value(*count_);
  }
  void load(InArchive& in) override {
    if (fault_ == Fault::no_save || fault_ == Fault::lazy_load) return;
    in.section("beacon", 1);
    if (fault_ == Fault::reads_too_little) return;
    int count = 0;
    in.value(count);
    if (fault_ == Fault::forgetful_load) count = 0;
    count_ = std::make_shared<int>(count);
  }

 private:
  Fault fault_;
  std::shared_ptr<int> count_;
  double smooth_ = 0.0;
  static inline std::atomic<unsigned> draws_ = 0;
};

testing::Violations check(Fault fault) {
  const Beacon sensor(fault);
  return testing::check_sensor(sensor, wheel_speeds(12), StateLayout::Motion::planar);
}

TEST(SensorContract, AGoodSensorHasNoViolation) { EXPECT_THAT(check(Fault::none), IsEmpty()); }

TEST(SensorContract, NoMeasurementsAreAViolation) {
  const Beacon sensor(Fault::none);
  EXPECT_THAT(testing::check_sensor(sensor, {}, StateLayout::Motion::planar),
              Contains(HasSubstr("nothing was checked")));
}

struct Case {
  Fault fault;
  const char* violation;  // how a violation begins
};

class FaultySensor : public ::testing::TestWithParam<Case> {};

TEST_P(FaultySensor, IsReported) { EXPECT_THAT(check(GetParam().fault), Contains(StartsWith(GetParam().violation))); }

INSTANTIATE_TEST_SUITE_P(
    Faults, FaultySensor,
    ::testing::Values(
        Case{Fault::wrong_sign,
             "a Jacobian differs from central differences: measurement 0, update 0, row 1, state yaw: 1 instead"},
        Case{Fault::slightly_wrong_jacobian,
             "a Jacobian differs from central differences: measurement 0, update 0, row 0, state range_bias_m"},
        Case{Fault::missing_block_jacobian, "a Jacobian differs from central differences"},
        Case{Fault::negative_r, "R is not positive definite"}, Case{Fault::asymmetric_r, "R is not symmetric"},
        Case{Fault::nan_residual, "a residual is not finite"},
        Case{Fault::no_reset, "linearize depends on what `out` held before"},
        Case{Fault::counts_calls, "linearize depends on what `out` held before or on earlier calls"},
        Case{Fault::too_wide_block, "linearize fills in a wrong shape"},
        Case{Fault::shared_state, "processing on a clone changes what the original does"},
        Case{Fault::shared_state, "processing on a clone changes what the original saves"},
        Case{Fault::forgetful_clone, "a clone does not take the whole state along"},
        Case{Fault::no_save, "a loaded sensor does not continue as the saved one"},
        Case{Fault::forgetful_load, "a loaded sensor does not continue as the saved one"},
        Case{Fault::forgetful_load, "save after load writes other bytes"},
        Case{Fault::lazy_load, "load does not read all that save wrote"},
        Case{Fault::lazy_load, "load accepts a stream that ends early"},
        Case{Fault::reads_too_little, "load does not read all that save wrote"},
        Case{Fault::random_process, "process is not deterministic"},
        Case{Fault::swallows_foreign_payload, "process does not refuse a foreign payload"},
        Case{Fault::asserts_finite_values,
             "process of a value that is not finite (left_mps = nan, measurement 6) threw"},
        Case{Fault::smooths_over_all, "a value that is not finite stays in the sensor: left_mps = nan, measurement 6"},
        Case{Fault::throws_int, "the check threw: something that is not a std::exception"},
        Case{Fault::unnamed_state, "a state of the block has no name"},
        Case{Fault::twin_names, "two states of the block have one name"},
        Case{Fault::negative_sigma, "a sigma, walk or time constant of the block is negative"},
        Case{Fault::dead_state, "a state of the block can never change"}));

}  // namespace
}  // namespace waymark::contract_test
