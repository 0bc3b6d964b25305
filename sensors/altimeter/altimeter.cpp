// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>

#include "waymark/base/error.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/plugin/sensor.hpp"

namespace waymark::altimeter {

namespace {

/// z = (p + R l)_z + b: the sensor at l in the base frame, the slowly varying level b out of the block if there is one.
class HeightUpdate final : public Update {
 public:
  HeightUpdate(double height, const Eigen::Vector3d& arm, double variance, int block_size)
      : height_(height), arm_(arm), variance_(variance), block_size_(block_size) {}

  Quantity observes() const override { return Quantity::height; }
  void linearize(const StateView& state, Linearization& out) const override {
    const Eigen::Vector3d arm = state.nav.T_map_base.q * arm_;
    out.reset(1, block_size_);
    out.residual(0) = height_ - state.nav.T_map_base.p.z() - arm.z() - (block_size_ > 0 ? state.block[0] : 0.0);
    out.R(0, 0) = variance_;
    out.position()(0, 2) = 1.0;
    if (!arm_.isZero(0.0)) out.attitude() << arm.y(), -arm.x(), 0.0;
    if (block_size_ > 0) out.block()(0, 0) = 1.0;
  }

 private:
  double height_;
  Eigen::Vector3d arm_;
  double variance_;
  int block_size_;
};

/// Height over level ground or over a fixed level: ultrasound, barometer. In planar motion it is ignored.
class Altimeter final : public Sensor {
 public:
  Altimeter(const Config& config, const Rig& rig)
      : arm_(rig.T_base_sensor(config.text("name")).p),
        sigma_(config.positive({"sigma_m", "m", "noise; the floor, whatever the device claims"})),
        use_reported_(config.boolean({"use_reported_sigma", "use the device's own σ where it is larger"}, true)),
        level_(
            config.number({"level_m", "m", "what the height counts from, in the map: added to every reading"}, 0.0)) {
    offset_.name = "offset_up_m";
    offset_.initial_sigma = offset_.stationary_sigma = config.non_negative(
        {"offset_sigma_m", "m", "unknown offset as a state of its own (ground that is not level, weather); 0: none"},
        0.0);
    offset_.tau_s = config.non_negative(
        {"offset_tau_s", "s",
         "the offset varies as a first-order Gauss–Markov process with this time constant; 0: as a random walk"},
        0.0);
    offset_.walk_per_sqrt_s =
        config.non_negative({"offset_walk_m_per_sqrt_s", "m/√s", "random walk of the offset; 0: it is constant"}, 0.0);
    if (offset_.tau_s == 0.0) offset_.stationary_sigma = 0.0;
    if (offset_.initial_sigma > 0.0) return;
    if (offset_.tau_s > 0.0) config.fail("offset_tau_s", "needs offset_sigma_m above 0");
    if (offset_.walk_per_sqrt_s > 0.0) config.fail("offset_walk_m_per_sqrt_s", "needs offset_sigma_m above 0");
  }

  SensorTraits traits() const override { return {.observes_height = true}; }
  StateBlock block() const override { return offset_.initial_sigma > 0.0 ? StateBlock{offset_} : StateBlock{}; }

  std::optional<ObservedMotion> observed_motion(const Measurement& measurement, const Datum*) const override {
    ObservedMotion seen;
    seen.height_m = level_ + measurement.as<Height>().height_m - arm_.z();
    seen.height_offset_sigma_m = offset_.initial_sigma;
    return seen;
  }

  void process(const Measurement& measurement, const Prediction& prediction, UpdateList& out) override {
    const auto& reading = measurement.as<Height>();
    if (!std::isfinite(reading.height_m)) throw DataError("the height is not finite");
    if (prediction.planar()) return;
    const bool reported = use_reported_ && std::isfinite(reading.sigma_m);
    const double sigma = reported ? std::max(sigma_, reading.sigma_m) : sigma_;
    out.emplace<HeightUpdate>(level_ + reading.height_m, arm_, sigma * sigma, offset_.initial_sigma > 0.0 ? 1 : 0);
  }

  std::unique_ptr<Sensor> clone() const override { return std::make_unique<Altimeter>(*this); }

 private:
  Eigen::Vector3d arm_;
  double sigma_;
  bool use_reported_;
  double level_;
  BlockState offset_;
};

}  // namespace

}  // namespace waymark::altimeter

WAYMARK_PLUGIN(waymark::Sensor, waymark::altimeter::Altimeter, "altimeter", "1.0.0")
