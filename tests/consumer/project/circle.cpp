// SPDX-License-Identifier: Apache-2.0
// A source: a robot that drives in a circle; the twist of its base, the range to a beacon and, now and then, its dock.
#include <cmath>

#include "beacon_range.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/plugin.hpp"

using namespace waymark;

namespace {

class Circle : public Source {
 public:
  explicit Circle(const Config& config)
      : end_(config.integer_in({"samples", "length of the log"}, 1, 1'000'000, 600)),
        radius_m_(config.positive({"radius_m", "m", "radius of the circle"})) {
    channels_.push_back({config.text({"twist_to", "sensor that takes the twist"}), std::string(BodyTwist::kType)});
    channels_.push_back({config.text({"range_to", "sensor that takes the range"}), std::string(BeaconRange::kType)});
    channels_.push_back(
        {config.text({"dock_to", "sensor that takes the dock"}), std::string(LandmarkObservations::kType)});
  }
  const std::vector<Channel>& channels() const override { return channels_; }
  double progress() const override { return static_cast<double>(next_) / static_cast<double>(end_); }

  /// Ten measurements a second at 1 m/s; from the map's origin, eastwards, turning left.
  std::optional<Measurement> next() override {
    if (next_ == end_) return std::nullopt;
    const double turn = 0.1 * static_cast<double>(next_) / radius_m_;
    const Pose T_map_base = Pose::planar(radius_m_ * std::sin(turn), radius_m_ * (1.0 - std::cos(turn)), turn);
    Measurement m;
    m.stamp = m.arrival = Time(std::chrono::milliseconds(100 * next_));
    m.sequence = static_cast<std::uint64_t>(next_);
    m.sensor = next_ % 50 == 7 ? 2 : next_ % 5 == 3 ? 1 : 0;
    Random noise({1, 0, m.stamp.time_since_epoch().count(), m.sensor});  // the same in every run
    const auto twist = std::make_shared<BodyTwist>();
    const auto range = std::make_shared<BeaconRange>();
    const auto seen = std::make_shared<LandmarkObservations>();
    twist->v_x_mps = 1.0 + 0.02 * noise.normal();
    twist->w_z_radps = 1.0 / radius_m_;
    range->range_m = (T_map_base.p - Eigen::Vector3d(8.0, -2.0, 0.0)).norm() + 0.1 * noise.normal();
    const Eigen::Vector3d p_base_dock = T_map_base.inverse() * Eigen::Vector3d(3.0, 6.0, 0.0);
    seen->landmarks.push_back({p_base_dock.norm(), std::atan2(p_base_dock.y(), p_base_dock.x())});
    const std::shared_ptr<const Payload> payloads[] = {twist, range, seen};
    m.payload = payloads[m.sensor];
    ++next_;
    return m;
  }

 private:
  std::vector<Channel> channels_;
  std::int64_t next_ = 0;
  std::int64_t end_;
  double radius_m_;
};

}  // namespace

WAYMARK_PLUGIN(Source, Circle, "circle", "1.0.0")
