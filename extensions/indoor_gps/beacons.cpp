// SPDX-License-Identifier: Apache-2.0
#include "beacons.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace waymark::indoor_gps {
namespace {

constexpr double kNearest = 1e-6;  // at the beacon itself a range has no direction [m]

std::vector<Beacon> read_beacons(const Config& config) {
  std::vector<Beacon> beacons;
  const auto items = config.items({"beacons", "the beacons whose places are known"});
  beacons.reserve(items.size());
  for (const Config& item : items) {
    const auto number = item.integer({"number", "number of the beacon, as the ranges give it"});
    const auto place = item.numbers({"map_p_beacon_m", "m",
                                     "its place in the map: [x, y, z], or [x, y] if its ranges are distances in the "
                                     "plane"});
    if (number < 0 || number > std::numeric_limits<int>::max())
      item.fail("number", std::to_string(number) + " is no number of a beacon; expected 0 or more");
    if (place.size() != 2 && place.size() != 3)
      item.fail("map_p_beacon_m", std::to_string(place.size()) + " numbers; expected [x, y] or [x, y, z]");
    if (std::ranges::find(beacons, number, &Beacon::number) != beacons.end())
      item.fail("number", "two beacons have the number " + std::to_string(number));
    const bool has_height = place.size() == 3;
    beacons.push_back({static_cast<int>(number), {place[0], place[1], has_height ? place[2] : 0.0}, has_height});
  }
  if (beacons.empty()) config.fail("beacons", "the list is empty; expected at least one beacon");
  return beacons;
}

bool per_beacon(const Config& config, const Config::Key& key) {
  return config.choice(key, {"common", "per_beacon"}, "common") == "per_beacon";
}

}  // namespace

Beacons::Beacons(const Config& config) {
  scale_.initial = config.positive({"scale", "measured range per true distance, at the start"}, 1.0);
  scale_.sigma =
      config.non_negative({"scale_sigma", "the scale as a state: its first σ; 0, and no walk: a constant"}, 0.0);
  scale_.walk_per_sqrt_s = config.non_negative({"scale_walk_per_sqrt_s", "1/√s", "random walk of the scale"}, 0.0);
  scale_.per_beacon = per_beacon(config, {"scale_of", "one scale for all beacons, or one of each"});
  offset_.initial = config.number({"offset_m", "m", "what every range is longer, at the start"}, 0.0);
  offset_.sigma = config.non_negative(
      {"offset_sigma_m", "m", "the offset as a state: its first σ; 0, and no walk: a constant"}, 0.0);
  offset_.walk_per_sqrt_s = config.non_negative({"offset_walk_m_per_sqrt_s", "m/√s", "random walk of the offset"}, 0.0);
  offset_.per_beacon = per_beacon(config, {"offset_of", "one offset for all beacons, or one of each"});
  beacons_ = read_beacons(config);
  block_size_ = states_of(scale_) + states_of(offset_);
  if (block_size_ > kMaxBlockStates) {
    config.fail("beacons", "scales and offsets are " + std::to_string(block_size_) + " states; at most " +
                               std::to_string(kMaxBlockStates) + " fit (scale_of: common, offset_of: common)");
  }
}

int Beacons::find(int number) const {
  const auto found = std::ranges::find(beacons_, number, &Beacon::number);
  return found == beacons_.end() ? -1 : static_cast<int>(found - beacons_.begin());
}

int Beacons::states_of(const SharedState& state) const {
  if (!state.is_estimated()) return 0;
  return state.per_beacon ? static_cast<int>(beacons_.size()) : 1;
}

int Beacons::scale_index(int beacon) const {
  if (!scale_.is_estimated()) return -1;
  return scale_.per_beacon ? beacon : 0;
}

int Beacons::offset_index(int beacon) const {
  if (!offset_.is_estimated()) return -1;
  return states_of(scale_) + (offset_.per_beacon ? beacon : 0);
}

StateBlock Beacons::block() const {
  StateBlock block;
  block.reserve(static_cast<std::size_t>(block_size_));
  const auto add = [&](const SharedState& shared, const char* name, const char* unit) {
    BlockState state;
    state.initial = shared.initial;
    state.initial_sigma = shared.sigma;
    state.walk_per_sqrt_s = shared.walk_per_sqrt_s;
    const int count = states_of(shared);
    for (int i = 0; i < count; ++i) {
      state.name = name;
      if (shared.per_beacon) {
        state.name += '_';
        state.name += std::to_string(beacons_[static_cast<std::size_t>(i)].number);
      }
      state.name += unit;
      block.push_back(state);
    }
  };
  add(scale_, "scale", "");
  add(offset_, "offset", "_m");
  return block;
}

void Beacons::add_leg(int beacon, double sign, const Eigen::Vector3d& p_map_antenna, const double* block,
                      ExpectedRange& out) const {
  const Beacon& from = beacons_[static_cast<std::size_t>(beacon)];
  Eigen::Vector3d d = p_map_antenna - from.p_map;
  if (!from.has_height) d.z() = 0.0;
  const double distance = std::max(d.norm(), kNearest);
  const int k = scale_index(beacon);
  const int o = offset_index(beacon);
  const double scale = k >= 0 && block != nullptr ? block[k] : scale_.initial;
  const double offset = o >= 0 && block != nullptr ? block[o] : offset_.initial;
  out.value += sign * (scale * distance + offset);
  out.by_point += sign * scale * d.transpose() / distance;
  if (k >= 0) out.by_block[k] += sign * distance;
  if (o >= 0) out.by_block[o] += sign;
}

ExpectedRange Beacons::expect(int beacon, int reference, const Eigen::Vector3d& p_map_antenna,
                              const double* block) const {
  ExpectedRange out;
  out.by_block.setZero(block_size_);
  add_leg(beacon, 1.0, p_map_antenna, block, out);
  if (reference >= 0) add_leg(reference, -1.0, p_map_antenna, block, out);
  return out;
}

}  // namespace waymark::indoor_gps
