// SPDX-License-Identifier: Apache-2.0
#include <GeographicLib/LocalCartesian.hpp>
#include <algorithm>
#include <array>
#include <cmath>

#include "waymark/error.hpp"
#include "waymark/payloads.hpp"
#include "waymark/plugin.hpp"

namespace waymark {

namespace {

/// A position fix of the antenna: z = p + R l + b, with lever arm l and, if configured, the slowly varying offset b out
/// of the block.
class PositionUpdate final : public Update {
 public:
  PositionUpdate(const Eigen::Vector3d& p_map_antenna, const Eigen::Vector3d& lever_arm, double sigma_horizontal,
                 double sigma_vertical, int rows, int block_size)
      : z_(p_map_antenna),
        arm_(lever_arm),
        variance_(sigma_horizontal * sigma_horizontal, sigma_horizontal * sigma_horizontal,
                  sigma_vertical * sigma_vertical),
        rows_(rows),
        block_size_(block_size) {}

  void linearize(const StateView& state, Linearization& out) const override {
    out.reset(rows_, block_size_);
    const Eigen::Vector3d arm = state.nav.T_map_base.q * arm_;
    Eigen::Vector3d residual = z_ - state.nav.T_map_base.p - arm;
    for (int i = 0; i < std::min(block_size_, rows_); ++i) residual[i] -= state.block[i];
    out.residual = residual.head(rows_);
    out.R.diagonal() = variance_.head(rows_);
    out.position() = Eigen::Matrix3d::Identity().topRows(rows_);
    if (!arm_.isZero(0.0)) out.attitude() = -so3::skew(arm).topRows(rows_);
    if (block_size_ > 0) out.block().leftCols(std::min(block_size_, rows_)).setIdentity();
  }

 private:
  Eigen::Vector3d z_;
  Eigen::Vector3d arm_;
  Eigen::Vector3d variance_;
  int rows_;
  int block_size_;
};

/// GNSS fixes, in local metres or geodetic (estimation.md, "DGPS").
class Dgps final : public Sensor {
 public:
  explicit Dgps(const Config& config)
      : lever_arm_(read_lever_arm(config)),
        sigma_(config.positive("sigma_m")),
        sigma_vertical_(config.positive("sigma_vertical_m", 2.0 * sigma_)),
        sigma_per_hdop_(config.non_negative("sigma_per_hdop_m", 0.0)),
        use_reported_(config.boolean("use_reported_sigma", true)),
        offset_sigma_(config.non_negative("offset_sigma_m", 0.0)),
        offset_tau_(config.positive("offset_tau_s", 30.0)),
        min_satellites_(static_cast<int>(config.integer_in("min_satellites", 0, 100, 0))) {
    const Config by_type = config.child_or_empty("sigma_by_type_m");
    for (const auto& [type, word] : kTypes) {
      if (by_type.has(word)) sigma_by_type_[static_cast<std::size_t>(type)] = by_type.positive(word);
    }
  }

  StateBlock block() const override {
    if (offset_sigma_ == 0.0) return {};
    BlockState state;
    state.initial_sigma = offset_sigma_;
    state.stationary_sigma = offset_sigma_;
    state.tau_s = offset_tau_;
    StateBlock block(2, state);
    block[0].name = "offset_east_m";
    block[1].name = "offset_north_m";
    return block;
  }
  bool is_absolute() const override { return true; }

  std::optional<StartHint> start_hint(const Measurement& measurement, const Datum* datum) const override {
    const auto& fix = measurement.as<GnssFix>();
    check(fix);
    StartHint hint;
    if (is_geodetic(fix) && datum == nullptr) {
      hint.datum = Datum{fix.latitude_deg, fix.longitude_deg, std::isfinite(fix.height_m) ? fix.height_m : 0.0};
      return hint;
    }
    hint.p_map_point = position(fix, datum);
    if (!std::isfinite(hint.p_map_point->z())) hint.p_map_point->z() = 0.0;
    hint.p_base_point = lever_arm_;
    hint.sigma_m = std::hypot(horizontal_sigma(fix), offset_sigma_);
    return hint;
  }

  void process(const Measurement& measurement, const Prediction& prediction, UpdateList& out) override {
    const auto& fix = measurement.as<GnssFix>();
    check(fix);
    const Eigen::Vector3d p = position(fix, prediction.datum);
    const bool height = prediction.layout.motion() == StateLayout::Motion::spatial && std::isfinite(p.z());
    const double vertical = use_reported_ && std::isfinite(fix.sigma_vertical_m)
                                ? std::max(fix.sigma_vertical_m, sigma_vertical_)
                                : sigma_vertical_;
    out.emplace<PositionUpdate>(p, lever_arm_, horizontal_sigma(fix), vertical, height ? 3 : 2,
                                offset_sigma_ > 0.0 ? 2 : 0);
  }

  std::unique_ptr<Sensor> clone() const override { return std::make_unique<Dgps>(*this); }

 private:
  static constexpr std::array<std::pair<GnssFix::Type, const char*>, 4> kTypes = {
      {{GnssFix::Type::single, "single"},
       {GnssFix::Type::differential, "differential"},
       {GnssFix::Type::rtk_float, "rtk_float"},
       {GnssFix::Type::rtk_fixed, "rtk_fixed"}}};

  static Eigen::Vector3d read_lever_arm(const Config& config) {
    // An antenna a metre off the axle makes a metre of error: the YAML must say where it is, or that it does not
    // matter.
    if (!config.is_list("base_p_antenna_m") && config.has("base_p_antenna_m")) {
      config.choice("base_p_antenna_m", {"none"});
      return Eigen::Vector3d::Zero();
    }
    const auto arm = config.numbers("base_p_antenna_m", 3);
    return {arm[0], arm[1], arm[2]};
  }

  static bool is_geodetic(const GnssFix& fix) { return !std::isfinite(fix.p_map_antenna.x()); }

  void check(const GnssFix& fix) const {
    if (fix.type == GnssFix::Type::none) throw DataError("the receiver reports no fix");
    if (fix.satellites >= 0 && fix.satellites < min_satellites_)
      throw DataError("too few satellites: " + std::to_string(fix.satellites));
    const bool local = std::isfinite(fix.p_map_antenna.x()) && std::isfinite(fix.p_map_antenna.y());
    const bool geodetic = std::isfinite(fix.latitude_deg) && std::isfinite(fix.longitude_deg);
    if (!local && !geodetic) throw DataError("the fix has neither east and north nor latitude and longitude");
    if (!local && (std::abs(fix.latitude_deg) > 90.0 || std::abs(fix.longitude_deg) > 180.0)) {
      throw DataError("latitude " + std::to_string(fix.latitude_deg) + ", longitude " +
                      std::to_string(fix.longitude_deg) + " is no place on Earth");
    }
  }

  static Eigen::Vector3d position(const GnssFix& fix, const Datum* datum) {
    if (!is_geodetic(fix)) return fix.p_map_antenna;
    if (datum == nullptr) throw DataError("a geodetic fix needs a datum");
    const GeographicLib::LocalCartesian frame(datum->latitude_deg, datum->longitude_deg, datum->height_m);
    Eigen::Vector3d p;
    frame.Forward(fix.latitude_deg, fix.longitude_deg, std::isfinite(fix.height_m) ? fix.height_m : datum->height_m,
                  p.x(), p.y(), p.z());
    if (!std::isfinite(fix.height_m)) p.z() = GnssFix::kUnknown;
    return p;
  }

  /// The best that is known of this fix, never below `sigma_m`.
  double horizontal_sigma(const GnssFix& fix) const {
    if (use_reported_ && std::isfinite(fix.sigma_horizontal_m)) return std::max(sigma_, fix.sigma_horizontal_m);
    double sigma = sigma_;
    if (sigma_per_hdop_ > 0.0 && std::isfinite(fix.hdop)) sigma = std::max(sigma, sigma_per_hdop_ * fix.hdop);
    const double by_type = sigma_by_type_[static_cast<std::size_t>(fix.type)];
    return std::max(sigma, by_type);
  }

  Eigen::Vector3d lever_arm_;
  double sigma_;
  double sigma_vertical_;
  double sigma_per_hdop_;
  bool use_reported_;
  double offset_sigma_;
  double offset_tau_;
  int min_satellites_;
  std::array<double, 6> sigma_by_type_{};
};

}  // namespace

}  // namespace waymark

WAYMARK_PLUGIN(waymark::Sensor, waymark::Dgps, "dgps", "1.0.0")
