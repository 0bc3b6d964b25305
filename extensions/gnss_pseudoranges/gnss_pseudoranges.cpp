// SPDX-License-Identifier: Apache-2.0
// A sensor: pseudoranges of navigation satellites, tightly coupled, with the receiver's clock as states.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "earth.hpp"
#include "first_fix.hpp"
#include "pseudorange_update.hpp"
#include "waymark/base/error.hpp"
#include "waymark/plugin/sensor.hpp"

namespace waymark::gnss {
namespace {

constexpr std::size_t kMostRows = UpdateList::kSlots * kMaxUpdateRows;

/// A signal that is used, and its noise.
struct Signal {
  RangeRow row;
  LateSignal noise;
};

class GnssPseudoranges final : public Sensor {
 public:
  explicit GnssPseudoranges(const Config& config)
      : name_(config.has("name") ? config.text("name") : ""),
        arm_(read_antenna(config)),
        receiver_(std::make_shared<Receiver>(config)) {}

  StateBlock block() const override { return receiver_->block(); }
  SensorTraits traits() const override { return {.is_absolute = true}; }

  std::optional<StartHint> start_hint(const Measurement& measurement, const Datum* datum) const override {
    const auto fix = first_fix(measurement.as<Pseudoranges>(), *receiver_);
    if (!fix) return std::nullopt;
    StartHint hint;
    if (datum == nullptr) {
      hint.datum = to_datum(fix->p_ecef);
      return hint;
    }
    hint.p_map_point = LocalAxes(*datum).to_enu(fix->p_ecef);
    hint.p_base_point = arm_;
    hint.sigma_m = hint.slow_sigma_m = fix->sigma;
    hint.slow_tau_s = receiver_->error_time();
    return hint;
  }

  void process(const Measurement& measurement, const Prediction& prediction, UpdateList& out) override {
    const auto& epoch = measurement.as<Pseudoranges>();
    const double interval = last_stamp_ ? to_seconds(measurement.stamp - *last_stamp_) : kMostInterval;
    if (!first_stamp_) first_stamp_ = measurement.stamp;
    last_stamp_ = measurement.stamp;
    if (prediction.datum == nullptr) return;
    std::vector<Signal> used =
        signals(epoch, to_seconds(measurement.stamp - *first_stamp_), LocalAxes(*prediction.datum));
    if (used.empty() && !epoch.satellites.empty()) throw DataError("no satellite of the systems that are used");
    const double stays = 2.0 * receiver_->error_time() / std::clamp(interval, kLeastInterval, kMostInterval);
    make_gaussian(used, std::max(1.0, stays), prediction);
    for (std::size_t i = 0; i < used.size(); i += kMaxUpdateRows) {
      PseudorangeUpdate update(receiver_, arm_);
      for (std::size_t k = i; k < std::min(i + kMaxUpdateRows, used.size()); ++k) update.add(used[k].row);
      out.emplace<PseudorangeUpdate>(update);
    }
  }

  std::unique_ptr<Sensor> clone() const override { return std::make_unique<GnssPseudoranges>(*this); }
  void save(OutArchive& out) const override { out(*this); }
  void load(InArchive& in) override { in(*this); }
  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("gnss_pseudoranges", 1);
    archive(first_stamp_, last_stamp_);
  }

 private:
  static constexpr double kLeastInterval = 1e-2;  // [s], two epochs with one stamp
  static constexpr double kMostInterval = 1.0;    // [s], an epoch does not stand for more than this

  static Eigen::Vector3d read_antenna(const Config& config) {
    const Config::Key key{"base_p_antenna_m", "m", "lever arm: the antenna in the base frame [x, y, z], or `none`"};
    if (!config.is_list(key.name) && config.has(key.name)) {
      config.choice(key, {"none"});
      return Eigen::Vector3d::Zero();
    }
    return Eigen::Vector3d::Map(config.numbers(key, 3).data());
  }

  /// The strongest first, as many as the host takes.
  std::vector<Signal> signals(const Pseudoranges& epoch, double since, const LocalAxes& axes) const {
    std::vector<Signal> used;
    used.reserve(epoch.satellites.size());
    for (const auto& one : epoch.satellites) {
      const int system = receiver_->find_system(one.system);
      if (system < 0) continue;
      if (!std::isfinite(one.range_m) || !one.p_ecef_m.allFinite())
        throw DataError("satellite " + std::to_string(one.number) + " has no finite range or place");
      const Eigen::Vector3d s = axes.satellite(one.p_ecef_m);
      if (std::asin(s.normalized().z()) < receiver_->least_elevation()) continue;
      used.push_back({{{s, system, since}, one.range_m - s.norm(), 0.0}, receiver_->noise(one)});
    }
    std::ranges::stable_sort(used, {}, [](const Signal& signal) { return signal.noise.share; });
    if (used.size() > kMostRows) used.resize(kMostRows);
    return used;
  }

  /// Gives each signal the Gaussian noise that stands for its own, one after the other, as the mixture's mean and
  /// covariance become with those before; its variance then counts `stays` times.
  void make_gaussian(std::vector<Signal>& signals, double stays, const Prediction& prediction) const {
    const Belief& belief = prediction.belief;
    const Eigen::Vector3d arm = belief.mean.T_map_base.q * arm_;
    ErrorMatrix P = belief.P;
    ErrorVector dx = ErrorVector::Zero(P.rows());
    for (Signal& signal : signals) {
      RangeRow& row = signal.row;
      const ExpectedRange expected = receiver_->expect(row.from, belief.mean.T_map_base.p + arm, prediction.block);
      const ErrorVector H = jacobian(expected, arm, prediction.layout);
      const ErrorVector PH = P * H;
      const double prior = H.dot(PH);
      const double nu = row.value - expected.value - H.dot(dx);
      const Moments noise = equivalent_noise(signal.noise, nu, prior);
      row.value -= noise.mean;
      row.variance = stays * noise.variance;
      const double S = prior + row.variance;
      dx += PH * ((nu - noise.mean) / S);
      P -= PH * PH.transpose() / S;
    }
  }

  ErrorVector jacobian(const ExpectedRange& expected, const Eigen::Vector3d& arm, const StateLayout& layout) const {
    ErrorVector H = ErrorVector::Zero(layout.size());
    const Eigen::RowVector3d by_attitude = -expected.by_antenna * so3::skew(arm);
    for (int axis = 0; axis < 3; ++axis) {
      if (const int i = layout.active(axis); i >= 0) H[i] = expected.by_antenna[axis];
      if (const int i = layout.active(3 + axis); i >= 0) H[i] = by_attitude[axis];
    }
    const auto owner = std::ranges::find(layout.owners(), name_, &StateLayout::Owner::name);
    if (owner != layout.owners().end() && static_cast<int>(owner->block.size()) == receiver_->states()) {
      const int first = layout.core_size() + layout.block_offset(static_cast<int>(owner - layout.owners().begin()));
      H.segment(first, receiver_->states()) = expected.by_block.transpose();
    }
    return H;
  }

  std::string name_;
  Eigen::Vector3d arm_;
  std::shared_ptr<const Receiver> receiver_;
  std::optional<Time> first_stamp_;
  std::optional<Time> last_stamp_;
};

}  // namespace
}  // namespace waymark::gnss

WAYMARK_PLUGIN(waymark::Sensor, waymark::gnss::GnssPseudoranges, "gnss_pseudoranges", "1.0.0",
               waymark::gnss::Pseudoranges)
