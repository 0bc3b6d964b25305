// SPDX-License-Identifier: Apache-2.0
#include "particles/redrawing.hpp"

#include <algorithm>
#include <utility>

namespace waymark::particles {

Pose moved(const Pose& pose, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d relative = loops::between(from, loops::planar(pose));
  const Eigen::Vector3d planar = loops::compose(to, relative);
  Pose result = pose;
  result.p.head<2>() = planar.head<2>();
  result.q = (so3::exp({0.0, 0.0, so3::wrap(planar.z() - pose.yaw())}) * pose.q).normalized();
  return result;
}

ParticleMaps blank_maps(const ParticleMaps& maps) {
  ParticleMaps blank;
  blank.reserve(maps.size());
  for (const auto& map : maps) blank.push_back(map ? map->blank() : nullptr);
  return blank;
}

void draw(std::span<const loops::Keyframe> keyframes, ParticleMaps& maps) {
  for (const loops::Keyframe& keyframe : keyframes) {
    const Pose pose = moved(keyframe.T_map_base, loops::planar(keyframe.T_map_base), keyframe.xyyaw);
    for (const loops::MapObservation& each : keyframe.observations) {
      const auto& map = maps[static_cast<std::size_t>(each.module)];
      if (map) map->insert({pose, Eigen::Matrix3d::Zero()}, *each.observation, nullptr);
    }
  }
}

Redrawing::Redrawing(loops::Correction correction, ParticleMaps old)
    : correction_(std::move(correction)), old_(std::move(old)), maps_(blank_maps(old_)) {}

Redrawing::Redrawing(loops::Correction correction, ParticleMaps old, std::span<const loops::Keyframe> keyframes,
                     std::size_t drawn)
    : Redrawing(std::move(correction), std::move(old)) {
  drawn_ = drawn;
  draw(keyframes.first(drawn), maps_);
}

ParticleMaps Redrawing::recent_maps(std::span<const loops::Keyframe> keyframes) const {
  const std::size_t end = this->keyframes();
  std::size_t first = end;
  for (std::size_t points = 0; first > 0 && points < kRecent; points += 1 + keyframes[first].points) {
    if (keyframes[end - 1].way - keyframes[first - 1].way > kRecentWay) break;
    --first;
  }
  std::vector<loops::Keyframe> recent(keyframes.begin() + static_cast<std::ptrdiff_t>(first),
                                      keyframes.begin() + static_cast<std::ptrdiff_t>(end));
  for (std::size_t i = 0; i < recent.size(); ++i) recent[i].xyyaw = correction_.before[first + i];
  ParticleMaps maps = blank_maps(old_);
  draw(recent, maps);
  return maps;
}

void Redrawing::draw_piece(std::span<const loops::Keyframe> keyframes) {
  const std::size_t first = drawn_;
  for (std::size_t points = 0; drawn_ < this->keyframes() && points < kPiece; ++drawn_)
    points += 1 + keyframes[drawn_].points;
  draw(keyframes.subspan(first, drawn_ - first), maps_);
}

}  // namespace waymark::particles
