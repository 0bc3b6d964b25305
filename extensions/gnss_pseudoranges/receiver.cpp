// SPDX-License-Identifier: Apache-2.0
#include "receiver.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "earth.hpp"

namespace waymark::gnss {
namespace {

constexpr double kLeastShare = 0.05;  // of reflections, of the strongest signals
constexpr double kMostShare = 0.95;   // of the weakest

std::vector<std::int64_t> read_systems(const Config& config) {
  std::vector<std::int64_t> systems;
  for (const double number : config.numbers({"systems", "",
                                             "numbers of the satellite systems that are used; the first one's time is "
                                             "that of the clock"})) {
    if (number != std::floor(number) || std::ranges::find(systems, static_cast<std::int64_t>(number)) != systems.end())
      config.fail("systems", "expected whole numbers, each once");
    systems.push_back(static_cast<std::int64_t>(number));
  }
  if (systems.empty()) config.fail("systems", "the list is empty; expected at least one system");
  return systems;
}

}  // namespace

Receiver::Receiver(const Config& config)
    : systems_(read_systems(config)),
      sigma_(config.positive({"sigma_m", "m", "noise of a direct signal"}, 4.0)),
      use_reported_sigma_(
          config.boolean({"use_reported_sigma", "the receiver's own σ instead, where it gives one"}, false)),
      late_excess_(
          config.positive({"late_excess_m", "m", "by how much a reflected signal is longer, on the average"}, 40.0)),
      open_cn0_(
          config.number({"open_cn0_dbhz", "dBHz", "one signal in twenty that is so strong is a reflection"}, 50.0)),
      blocked_cn0_(config.number(
          {"blocked_cn0_dbhz", "dBHz", "nineteen in twenty that are so weak are reflections; between them linearly"},
          30.0)),
      least_elevation_(kRadPerDegree * config.number_in({"least_elevation_deg", "°", "lower satellites are not used"},
                                                        -90.0, 90.0, 5.0)),
      error_time_(config.non_negative({"error_time_s", "s",
                                       "how long reflections stay as they are: the variance counts 2 · this / interval "
                                       "times"},
                                      3.0)) {
  if (!(open_cn0_ > blocked_cn0_))
    config.fail("open_cn0_dbhz", "expected more than blocked_cn0_dbhz, " + std::to_string(blocked_cn0_));
  const auto add = [&](std::string name, double sigma, double walk, double walk_per_m = 0.0) {
    BlockState state;
    state.name = std::move(name);
    state.initial_sigma = sigma;
    state.walk_per_sqrt_s = walk;
    state.walk_per_sqrt_m = walk_per_m;
    block_.push_back(state);
  };
  add("clock_m", config.positive({"clock_sigma_m", "m", "the clock's offset at the start: its σ"}, 3e5),
      config.non_negative({"clock_walk_m_per_sqrt_s", "m/√s", "white noise of the clock's frequency"}, 0.5));
  add("drift_mps", config.positive({"drift_sigma_mps", "m/s", "the clock's drift, a constant: its σ"}, 300.0), 0.0);
  const double offset =
      config.positive({"system_offset_sigma_m", "m", "time of a further system against the first: its σ"}, 30.0);
  const double offset_walk = config.non_negative({"system_offset_walk_m_per_sqrt_s", "m/√s", "its random walk"}, 0.05);
  for (std::size_t i = 1; i < systems_.size(); ++i)
    add("offset_" + std::to_string(systems_[i]) + "_m", offset, offset_walk);
  const double height =
      config.non_negative({"height_sigma_m", "m",
                           "planar motion: the height of the road above the map's plane as a state: its "
                           "first σ; 0: none"},
                          0.0);
  const double height_walk = config.non_negative({"height_walk_m_per_sqrt_m", "m/√m", "its walk with the way"}, 0.02);
  has_height_ = height > 0.0;
  if (has_height_) add("height_m", height, 0.0, height_walk);
}

int Receiver::find_system(int number) const {
  const auto found = std::ranges::find(systems_, number);
  return found == systems_.end() ? -1 : static_cast<int>(found - systems_.begin());
}

ExpectedRange Receiver::expect(const Transmitter& at, const Eigen::Vector3d& p_map_antenna,
                               const double* states) const {
  const int offset = 1 + at.system;       // behind clock and drift; the first system has none
  const int height = this->states() - 1;  // behind all others
  Eigen::Vector3d p = p_map_antenna;
  if (has_height_ && states != nullptr) p.z() += states[height];
  const Eigen::Vector3d d = p - at.p_map;
  ExpectedRange out;
  // |p − s| − |s| without the difference of two numbers of 2·10⁷ m.
  out.value = p.dot(d - at.p_map) / (d.norm() + at.p_map.norm());
  out.by_antenna = d.normalized().transpose();
  out.by_block.setZero(this->states());
  out.by_block[0] = 1.0;
  out.by_block[1] = at.since_s;
  if (at.system > 0) out.by_block[offset] = 1.0;
  if (has_height_) out.by_block[height] = out.by_antenna.z();
  if (states == nullptr) return out;
  out.value += states[0] + states[1] * at.since_s;
  if (at.system > 0) out.value += states[offset];
  return out;
}

LateSignal Receiver::noise(const Pseudoranges::One& one) const {
  const double sigma = use_reported_sigma_ && one.sigma_m > 0.0 ? one.sigma_m : sigma_;
  const double blocked = std::isfinite(one.cn0_dbhz) ? (open_cn0_ - one.cn0_dbhz) / (open_cn0_ - blocked_cn0_) : 0.0;
  return {sigma * sigma, kLeastShare + (kMostShare - kLeastShare) * std::clamp(blocked, 0.0, 1.0), late_excess_};
}

}  // namespace waymark::gnss
