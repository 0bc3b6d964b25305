// SPDX-License-Identifier: Apache-2.0
// A sensor: the distance to a radio beacon whose place is known.
#include "beacon_range.hpp"

#include "waymark/plugin.hpp"

using namespace waymark;

namespace {

struct Setup {
  Eigen::Vector2d p_map_beacon;
  Eigen::Vector3d p_base_antenna;
  double sigma_m;
};

/// z = |p + R l - b|: base at p, antenna at l in the base frame, beacon at b in the map; in the plane.
class RangeUpdate : public Update {
 public:
  RangeUpdate(double range_m, const Setup& setup) : range_m_(range_m), setup_(setup) {}
  Quantity observes() const override { return Quantity::position; }
  void linearize(const StateView& state, Linearization& out) const override {
    const Eigen::Vector3d arm = state.nav.T_map_base.q * setup_.p_base_antenna;
    const Eigen::Vector2d d = (state.nav.T_map_base.p + arm).head<2>() - setup_.p_map_beacon;
    const double expected = std::max(d.norm(), 1e-6);
    const Eigen::RowVector3d unit(d.x() / expected, d.y() / expected, 0.0);
    out.reset(1, 0);  // one row, no states of our own
    out.residual(0) = range_m_ - expected;
    out.R(0, 0) = setup_.sigma_m * setup_.sigma_m;
    out.position() = unit;                    // dz/dp
    out.attitude() = -unit * so3::skew(arm);  // dz/d(rotation of the base, seen from the map)
  }

 private:
  double range_m_;
  Setup setup_;
};

class BeaconRangeSensor : public Sensor {
 public:
  explicit BeaconRangeSensor(const Config& config)
      : setup_{Eigen::Vector2d(config.numbers({"map_p_beacon_m", "m", "the beacon in the map [x, y]"}, 2).data()),
               Eigen::Vector3d(config.numbers({"base_p_antenna_m", "m", "the antenna in the base frame"}, 3).data()),
               config.positive({"sigma_m", "m", "noise of a range"})} {}

  void process(const Measurement& measurement, const Prediction&, UpdateList& out) override {
    const double range_m = measurement.as<BeaconRange>().range_m;
    if (!(range_m > 0.0)) throw DataError("a range of " + std::to_string(range_m) + " m; expected > 0");
    out.emplace<RangeUpdate>(range_m, setup_);
  }
  std::unique_ptr<Sensor> clone() const override { return std::make_unique<BeaconRangeSensor>(*this); }

 private:
  Setup setup_;
};

}  // namespace

WAYMARK_PLUGIN(Sensor, BeaconRangeSensor, "beacon_range", "1.0.0", BeaconRange)
