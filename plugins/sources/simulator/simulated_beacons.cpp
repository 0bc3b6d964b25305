// SPDX-License-Identifier: Apache-2.0
#include "simulated_beacons.hpp"

#include <algorithm>
#include <cmath>

#include "streams.hpp"

namespace waymark::simulator {
namespace {

constexpr double kBeaconsPhase = 0.23;

std::vector<Eigen::Vector3d> read_places(const Config& config) {
  const auto flat =
      config.numbers({"places_m", "m", "x, y, z of one beacon after the other, one flat list; numbered from 0"});
  if (flat.empty() || flat.size() % 3 != 0)
    config.fail("places_m", "x, y and z of at least one beacon are expected, one flat list");
  std::vector<Eigen::Vector3d> places;
  places.reserve(flat.size() / 3);
  for (std::size_t i = 0; i < flat.size(); i += 3) places.emplace_back(flat[i], flat[i + 1], flat[i + 2]);
  return places;
}

}  // namespace

SimulatedBeacons::SimulatedBeacons(const Config& config)
    : SimulatedSensor(config, Ranges::kType, 5.0, kBeaconsPhase),
      places_(read_places(config)),
      p_base_antenna_(Eigen::Vector3d::Map(
          config.numbers({"base_p_antenna_m", "m", "antenna in the base frame"}, 3, {0.0, 0.0, 0.0}).data())),
      range_max_m_(config.positive({"range_max_m", "m", "beacons that are further away are not measured"}, 1000.0)),
      sigma_m_(config.positive({"sigma_m", "m", "white noise of a range; it is reported"}, 0.1)),
      scale_(config.number_in({"scale", "measured range per true distance"}, 0.5, 2.0, 1.0)),
      offset_m_(config.number({"offset_m", "m", "what every range is longer"}, 0.0)),
      late_share_(
          config.number_in({"late_share", "share of ranges whose path is not the straight one"}, 0.0, 1.0, 0.0)),
      late_excess_m_(config.positive(
          {"late_excess_m", "m", "by how much such a path is longer: the mean of an exponential law"}, 1.0)),
      in_turn_(config.boolean({"in_turn", "one beacon per measurement, one after the other; false: all in one burst"},
                              false)),
      differences_(
          config.boolean({"differences", "ranges less the one to beacon 0, which must be in reach as well"}, false)) {
  if (differences_ && in_turn_) config.fail("differences", "needs bursts (in_turn: false)");
}

double SimulatedBeacons::measure(const Truth& truth, Duration time, int beacon,
                                 const Eigen::Vector3d& p_map_antenna) const {
  Random random = stream(truth.seed, Draw::ranges, time, static_cast<std::uint32_t>(beacon));
  const double distance = (p_map_antenna - places_[static_cast<std::size_t>(beacon)]).norm();
  const double white = sigma_m_ * random.normal();
  const bool is_late = random.uniform() < late_share_;
  const double excess = is_late ? -late_excess_m_ * std::log1p(-random.uniform()) : 0.0;
  return scale_ * distance + offset_m_ + white + excess;
}

std::shared_ptr<Payload> SimulatedBeacons::sample(const Truth& truth, Duration time) {
  const Eigen::Vector3d p_map_antenna = truth.trajectory.at(time).pose() * p_base_antenna_;
  const auto count = static_cast<int>(places_.size());
  const auto is_in_reach = [&](int beacon) {
    return (p_map_antenna - places_[static_cast<std::size_t>(beacon)]).norm() <= range_max_m_;
  };
  const int first = in_turn_ ? next_ : 0;
  const int end = in_turn_ ? next_ + 1 : count;
  next_ = (next_ + 1) % count;
  auto ranges = std::make_shared<Ranges>();
  for (int beacon = first; beacon < end; ++beacon) {
    if (!is_in_reach(beacon) || (differences_ && (beacon == 0 || !is_in_reach(0)))) continue;
    // Noise can make the range to a near beacon negative, which no device reports.
    Ranges::One one{.beacon = beacon, .range_m = measure(truth, time, beacon, p_map_antenna), .sigma_m = sigma_m_};
    if (differences_) {
      one.range_m -= measure(truth, time, 0, p_map_antenna);
      one.reference = 0;
      one.sigma_m *= std::sqrt(2.0);
    } else {
      one.range_m = std::max(one.range_m, 0.0);
    }
    ranges->ranges.push_back(one);
  }
  return ranges->ranges.empty() ? nullptr : ranges;
}

}  // namespace waymark::simulator
