// SPDX-License-Identifier: Apache-2.0
// What a loop does to the particles: their maps are drawn again along the corrected path.
#include <algorithm>
#include <utility>

#include "particles/particle_filter.hpp"

namespace waymark::particles {

namespace {

/// The pose with another place in the plane.
Pose moved(const Pose& pose, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d relative = loops::between(from, loops::planar(pose));
  const Eigen::Vector3d planar = loops::compose(to, relative);
  Pose result = pose;
  result.p.head<2>() = planar.head<2>();
  result.q = (so3::exp({0.0, 0.0, so3::wrap(planar.z() - pose.yaw())}) * pose.q).normalized();
  return result;
}

}  // namespace

void ParticleFilter::keep_keyframe(std::span<const MappingInput> inputs, std::size_t slot, MappingFailures& failures) {
  loops::Keyframe keyframe;
  keyframe.stamp = stamp();
  const Particle& particle = set_[slot];
  correspondences_.landmarks.clear();
  correspondences_.points_base.clear();
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (!inputs[i].kept || !correspond(inputs, i, slot, failures)) continue;
    keyframe.observations.push_back({inputs[i].module, inputs[i].kept});
  }
  keyframe.points_base = loops::thinned(correspondences_.points_base);
  // What is sampled is what the path cannot take back.
  keyframe.P = settings_.sampling_fraction * pose_covariance(particle.belief, layout());
  keyframe.T_map_base = particle.belief.mean.T_map_base;
  keyframe.xyyaw = loops::planar(keyframe.T_map_base);
  if (joint_) keyframe.anchor = joint_->active_anchor();
  loops_->add(std::move(keyframe));
  if (!loops_->is_full()) return;
  loops_.reset();
  loops_failure_ = true;
}

void ParticleFilter::close_loops() {
  if (!loops_) return;
  std::vector<StampedPose> path;
  const auto best_path = [&]() -> const std::vector<StampedPose>& { return path = set_[set_.best()].path.poses(); };
  const std::size_t known = loops_->loops().size();
  const auto correction = loops_->search(best_path);
  if (loops_->loops().size() > known)
    std::erase_if(suspected_tears_, [&](Time stamp) { return loops_->is_bridged(stamp); });
  if (!correction) return;
  const std::span<const loops::Keyframe> keyframes = loops_->keyframes();
  Particle best = set_[set_.best()].clone();
  best.maps = draw_again(best);
  // The keyframe of a time: poses between two of them move with the earlier one.
  std::size_t i = 0;
  for (StampedPose& pose : path) {
    while (i + 1 < keyframes.size() && keyframes[i + 1].stamp <= pose.stamp) ++i;
    pose.T_map_base = moved(pose.T_map_base, correction->before[i], keyframes[i].xyyaw);
  }
  best.path.replace(path);
  best.belief.mean.T_map_base = moved(best.belief.mean.T_map_base, correction->before.back(), keyframes.back().xyyaw);
  std::vector<joint::AnchorPose> anchors = best.anchors.items();
  best.anchors = {};
  for (joint::AnchorPose& anchor : anchors) {
    const auto first = std::ranges::find(keyframes, anchor.anchor, &loops::Keyframe::anchor);
    if (first == keyframes.end()) continue;
    const Eigen::Vector3d& from = correction->before[static_cast<std::size_t>(first - keyframes.begin())];
    anchor.xyyaw = loops::compose(first->xyyaw, loops::between(from, anchor.xyyaw));
    best.anchors.append(anchor);
  }
  if (joint_) joint_->draw_again(keyframes, anchors);
  best.log_weight = 0.0;
  for (Particle& particle : set_) particle = best.clone();
  set_.normalize();
  recollection_.past().clear();
  has_changed();
  closed_loop_ = ClosedLoop{correction->way, correction->shift};
}

std::vector<std::unique_ptr<ParticleMap>> ParticleFilter::draw_again(const Particle& best) const {
  std::vector<std::unique_ptr<ParticleMap>> maps;
  maps.reserve(best.maps.size());
  for (const auto& map : best.maps) maps.push_back(map ? map->blank() : nullptr);
  for (const loops::Keyframe& keyframe : loops_->keyframes()) {
    const Pose pose = moved(keyframe.T_map_base, loops::planar(keyframe.T_map_base), keyframe.xyyaw);
    for (const loops::MapObservation& each : keyframe.observations) {
      const auto& map = maps[static_cast<std::size_t>(each.module)];
      if (map) map->insert({pose, Eigen::Matrix3d::Zero()}, *each.observation, nullptr);
    }
  }
  return maps;
}

}  // namespace waymark::particles
