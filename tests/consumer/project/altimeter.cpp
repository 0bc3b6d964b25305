// SPDX-License-Identifier: Apache-2.0
// A height sensor with a payload of its own: all that a user writes for a new sensor.
#include <cmath>

#include "waymark/plugin.hpp"

namespace {

struct Height : waymark::PayloadOf<Height> {
  static constexpr std::string_view kType = "example/Height@1";
  double up_m = 0.0;  ///< of the base above the map's origin
};

class HeightUpdate : public waymark::Update {
 public:
  HeightUpdate(double up_m, double sigma_m) : up_m_(up_m), sigma_m_(sigma_m) {}

  void linearize(const waymark::StateView& state, waymark::Linearization& out) const override {
    out.reset(1, 0);
    out.residual(0) = up_m_ - state.nav.T_map_base.p.z();
    out.R(0, 0) = sigma_m_ * sigma_m_;
    out.position()(0, 2) = 1.0;
  }

 private:
  double up_m_;
  double sigma_m_;
};

class Altimeter : public waymark::Sensor {
 public:
  explicit Altimeter(const waymark::Config& config) : sigma_m_(config.positive("sigma_m")) {}

  void process(const waymark::Measurement& measurement, const waymark::Prediction&, waymark::UpdateList& out) override {
    const double up_m = measurement.as<Height>().up_m;
    if (!std::isfinite(up_m)) throw waymark::DataError("the height is not finite");
    out.emplace<HeightUpdate>(up_m, sigma_m_);
  }

  std::unique_ptr<waymark::Sensor> clone() const override { return std::make_unique<Altimeter>(*this); }

 private:
  double sigma_m_;
};

}  // namespace

WAYMARK_PLUGIN(waymark::Sensor, Altimeter, "altimeter", "1.0.0")
