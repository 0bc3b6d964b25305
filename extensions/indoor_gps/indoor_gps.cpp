// SPDX-License-Identifier: Apache-2.0
// A sensor: ranges to radio beacons whose places are known, or differences of such ranges.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "beacons.hpp"
#include "burst.hpp"
#include "late_paths.hpp"
#include "multilateration.hpp"
#include "range_update.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/gaussian.hpp"
#include "waymark/plugin/sensor.hpp"

namespace waymark::indoor_gps {
namespace {

/// A range that waits for others, to find the start.
struct WaitingRange {
  Time stamp{};
  RangeRow row;
};

/// The last answer to the host's question for a start.
struct Asked {
  Time stamp{};
  std::uint64_t sequence = 0;
  std::optional<StartHint> hint;
};

/// Ranges to known beacons (README.md): scale and offset as states, late paths, bursts, and the start.
class IndoorGps final : public Sensor {
 public:
  explicit IndoorGps(const Config& config)
      : name_(config.has("name") ? config.text("name") : ""),
        arm_(read_antenna(config)),
        sigma_(config.positive({"sigma_m", "m", "noise of a range, or of a difference of ranges"})),
        use_reported_sigma_(
            config.boolean({"use_reported_sigma", "the device's own σ instead, where a range has one"}, false)),
        late_paths_(
            config.number_in({"late_share", "share of ranges whose first path is not the straight one; 0: none"}, 0.0,
                             0.45, 0.0),
            config.positive({"late_excess_m", "m", "by how much such a path is longer, on the average"}, 1.0)),
        start_window_s_(config.positive(
            {"start_window_s", "s", "the start is found from ranges to three beacons or more within this time"}, 1.0)),
        start_speed_(config.non_negative(
            {"start_speed_mps", "m/s", "how fast the robot may drive meanwhile: noise of a range by its age"}, 1.0)),
        start_height_(config.number({"start_height_m", "m", "height of the base in the map meanwhile"}, 0.0)),
        beacons_(std::make_shared<Beacons>(config)) {}

  StateBlock block() const override { return beacons_->block(); }
  SensorTraits traits() const override { return {.is_motion_source = false, .is_absolute = true}; }

  std::optional<StartHint> start_hint(const Measurement& measurement, const Datum*) const override {
    const std::vector<RangeRow> burst = rows(measurement.as<Ranges>());
    // The host may ask more than once for one measurement.
    if (asked_ && asked_->stamp == measurement.stamp && asked_->sequence == measurement.sequence) return asked_->hint;
    for (const RangeRow& row : burst) waiting_.push_back({measurement.stamp, row});
    const Duration window = from_seconds(start_window_s_);
    std::erase_if(waiting_, [&](const WaitingRange& one) { return one.stamp < measurement.stamp - window; });
    if (waiting_.size() > static_cast<std::size_t>(kMaxRanges))
      waiting_.erase(waiting_.begin(), waiting_.end() - kMaxRanges);
    asked_ = Asked{measurement.stamp, measurement.sequence, find_position(measurement.stamp)};
    if (asked_->hint) waiting_.clear();  // the next position is independent of this one
    return asked_->hint;
  }

  void process(const Measurement& measurement, const Prediction& prediction, UpdateList& out) override {
    std::vector<RangeRow> burst = rows(measurement.as<Ranges>());
    if (burst.empty()) return;
    std::vector<SizedRange> sized;
    sized.reserve(burst.size());
    for (RangeRow& row : burst) {
      const double nis = make_gaussian(row, prediction);
      sized.push_back({row, nis});
    }
    if (emplace_updates(sized, beacons_, arm_, out) > 0) out.report_degraded("ranges that contradict their burst");
  }

  std::unique_ptr<Sensor> clone() const override { return std::make_unique<IndoorGps>(*this); }

 private:
  /// Scale and offset change slowly, if at all, compared with how long a start takes.
  static constexpr double kSlowTime = 60.0;

  static Eigen::Vector3d read_antenna(const Config& config) {
    const Config::Key key{"base_p_antenna_m", "m",
                          "lever arm: the receiver's antenna in the base frame [x, y, z], or `none`"};
    if (!config.is_list(key.name) && config.has(key.name)) {
      config.choice(key, {"none"});
      return Eigen::Vector3d::Zero();
    }
    return Eigen::Vector3d::Map(config.numbers(key, 3).data());
  }

  /// The ranges to beacons that are known. Throws DataError if there are none among several.
  std::vector<RangeRow> rows(const Ranges& burst) const {
    if (burst.ranges.size() > static_cast<std::size_t>(kMaxRanges)) {
      throw DataError("a burst of " + std::to_string(burst.ranges.size()) + " ranges; expected at most " +
                      std::to_string(kMaxRanges));
    }
    std::vector<RangeRow> out;
    out.reserve(burst.ranges.size());
    for (const Ranges::One& one : burst.ranges) {
      const int beacon = beacons_->find(one.beacon);
      const int reference = one.reference < 0 ? -1 : beacons_->find(one.reference);
      if (beacon < 0 || (one.reference >= 0 && reference < 0)) continue;
      if (!std::isfinite(one.range_m))
        throw DataError("a range of " + std::to_string(one.range_m) + " m; expected a number");
      const bool reported = use_reported_sigma_ && one.sigma_m > 0.0;
      const double sigma = reported ? one.sigma_m : sigma_;
      out.push_back({beacon, reference, one.range_m, sigma, sigma * sigma});
    }
    if (out.empty() && !burst.ranges.empty()) {
      throw DataError("beacon " + std::to_string(burst.ranges.front().beacon) +
                      " is not among those whose places are configured (beacons)");
    }
    return out;
  }

  std::optional<StartHint> find_position(Time now) const {
    std::vector<RangeRow> ranges;
    ranges.reserve(waiting_.size());
    for (const WaitingRange& one : waiting_) {
      ranges.push_back(one.row);
      const double moved = start_speed_ * to_seconds(now - one.stamp);
      ranges.back().variance += moved * moved;
    }
    const double height = start_height_ + arm_.z();
    const auto position = multilaterate(*beacons_, ranges, height);
    if (!position) return std::nullopt;
    StartHint hint;
    hint.p_map_point = Eigen::Vector3d(position->p_map_antenna.x(), position->p_map_antenna.y(), height);
    hint.p_base_point = arm_;
    hint.sigma_m = position->sigma;
    hint.slow_sigma_m = position->slow_sigma;
    hint.slow_tau_s = kSlowTime;
    return hint;
  }

  /// Replaces value and variance by those that the density of late paths makes of them, for the mixture. Returns the
  /// NIS.
  double make_gaussian(RangeRow& row, const Prediction& prediction) const {
    const Eigen::Vector3d arm = prediction.belief.mean.T_map_base.q * arm_;
    const ExpectedRange expected =
        beacons_->expect(row.beacon, row.reference, prediction.belief.mean.T_map_base.p + arm, prediction.block);
    const double prior = prior_variance(expected, arm, prediction);
    const double nu = row.value - expected.value;
    const EquivalentInnovation seen = late_paths_.equivalent(nu, prior + row.variance, row.reference >= 0);
    row.value += seen.nu - nu;
    row.variance = std::max(seen.variance - prior, row.variance);
    return seen.nu * seen.nu / seen.variance;
  }

  /// H P Hᵀ of a range, at the mean of the mixture.
  double prior_variance(const ExpectedRange& expected, const Eigen::Vector3d& arm, const Prediction& prediction) const {
    const StateLayout& layout = prediction.layout;
    ErrorVector H = ErrorVector::Zero(layout.size());
    const Eigen::RowVector3d by_attitude = -expected.by_point * so3::skew(arm);
    for (int axis = 0; axis < 3; ++axis) {
      if (const int i = layout.active(axis); i >= 0) H[i] = expected.by_point[axis];
      if (const int i = layout.active(3 + axis); i >= 0) H[i] = by_attitude[axis];
    }
    const auto owner = std::ranges::find(layout.owners(), name_, &StateLayout::Owner::name);
    if (owner != layout.owners().end() && static_cast<int>(owner->block.size()) == beacons_->block_size()) {
      const int first = layout.core_size() + layout.block_offset(static_cast<int>(owner - layout.owners().begin()));
      H.segment(first, beacons_->block_size()) = expected.by_block.transpose();
    }
    return H.dot(prediction.belief.P * H);
  }

  std::string name_;
  Eigen::Vector3d arm_;
  double sigma_;
  bool use_reported_sigma_;
  LatePaths late_paths_;
  double start_window_s_;
  double start_speed_;
  double start_height_;
  std::shared_ptr<const Beacons> beacons_;
  // `start_hint` is const and changes nothing that is saved, but one range alone gives no position: the ranges of the
  // last second before the start, which a checkpoint from before the start does not have.
  mutable std::vector<WaitingRange> waiting_;
  mutable std::optional<Asked> asked_;
};

}  // namespace
}  // namespace waymark::indoor_gps

WAYMARK_PLUGIN(waymark::Sensor, waymark::indoor_gps::IndoorGps, "indoor_gps", "1.0.0")
