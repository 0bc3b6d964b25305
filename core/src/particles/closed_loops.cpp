// SPDX-License-Identifier: Apache-2.0
// Loops and the particles: what a loop is searched by, tears that it may mend, and the maps that are drawn again along
// the corrected path.
#include <algorithm>
#include <utility>

#include "particles/particle_filter.hpp"
#include "waymark/interface/map_module.hpp"

namespace waymark::particles {

/// Loops move maps that this run has begun, and no others.
bool ParticleFilter::can_close_loops() const {
  return settings_.loops.enabled && !modules_.empty() && std::ranges::all_of(modules_, [](const auto& module) {
           return module && module->can_draw_again() && !module->has_prior_map();
         });
}

/// A match that is not expected, in a place that was not seen for long, says that the path to it was wrong, and not
/// that this step was. While the maps are drawn again the particles are in a map of their last way alone.
bool ParticleFilter::may_jump(std::span<const Eigen::Vector2d> points_base, const Pose& T_map_base) const {
  return !joint_ || redrawing_ || !joint_->returns_uncertainly(points_base, T_map_base);
}

std::optional<double> ParticleFilter::return_way() const {
  return can_close_loops() && has_graph() ? std::make_optional(settings_.loops.least_way) : std::nullopt;
}

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
  keyframe.points = correspondences_.points_base.size();
  // What is sampled is what the path cannot take back.
  keyframe.P = settings_.sampling_fraction * pose_covariance(particle.belief, layout());
  keyframe.T_map_base = particle.belief.mean.T_map_base;
  keyframe.xyyaw = loops::planar(keyframe.T_map_base);
  if (joint_) keyframe.anchor = joint_->active_anchor();
  if (redrawing_) {
    // Keyframes lie in the corrected map already.
    const std::size_t last = redrawing_->keyframes() - 1;
    const Eigen::Vector3d& to = loops_->keyframes()[last].xyyaw;
    const Eigen::Vector3d& from = redrawing_->correction().before[last];
    const Eigen::Matrix3d R = loops::turn(to.z() - from.z());
    keyframe.xyyaw = loops::compose(to, loops::between(from, keyframe.xyyaw));
    keyframe.P = R * keyframe.P * R.transpose();
  }
  loops_->add(std::move(keyframe));
}

void ParticleFilter::close_loops() { redrawing_ ? go_on_drawing() : search_loop(); }

void ParticleFilter::go_on_drawing() {
  if (redrawing_->is_drawn()) {
    take_corrected_maps();
  } else {
    redrawing_->draw_piece(loops_->keyframes());
  }
}

void ParticleFilter::finish_correction() {
  while (redrawing_) go_on_drawing();
}

const ParticleMaps& ParticleFilter::whole_maps(const Particle& particle) const {
  return redrawing_ ? redrawing_->old_maps() : particle.maps;
}

void ParticleFilter::give_up_loops() {
  loops_.reset();
  if (joint_) joint_->count_returns_at_once();
}

void ParticleFilter::search_loop() {
  loops_->bound();
  if (loops_->is_full()) {
    give_up_loops();
    loops_failure_ = true;
    return;
  }
  const Particle& best = set_[set_.best()];
  const std::size_t known = loops_->loops().size();
  const bool had_accepted = loops_->has_accepted();
  // What two paths share the keyframes have already, and a path is long.
  auto correction = loops_->search([&] {
    std::vector<StampedPose> path = best.path.poses_since(followed_);
    followed_ = best.path;
    return path;
  });
  if (loops_->loops().size() > known)
    std::erase_if(suspected_tears_, [&](Time stamp) { return loops_->is_bridged(stamp); });
  if (!correction) {
    const bool is_settled = !loops_->has_accepted() && (had_accepted || loops_->loops().size() > known);
    // It left the path where it was: the place that was met again is the right one.
    if (is_settled && joint_ && joint_->awaits_graph()) {
      draw_joint_again(best);
      has_changed();
    }
    return;
  }
  followed_ = {};  // the keyframes lie along the corrected path
  Particle only = best.clone();
  redrawing_.emplace(std::move(*correction), std::move(only.maps));
  only.maps = redrawing_->recent_maps(loops_->keyframes());
  become(only);
}

void ParticleFilter::become(Particle& only) {
  only.log_weight = 0.0;
  for (Particle& particle : set_) particle = only.clone();
  set_.normalize();
  recollection_.past().clear();
  has_changed();
}

void ParticleFilter::take_corrected_maps() {
  Particle best = set_[set_.best()].clone();
  std::vector<StampedPose> path = best.path.poses();
  loops::Correction correction = redrawing_->correction();
  // What came after the correction was found goes along with the place where it was.
  const std::size_t drawn = redrawing_->keyframes();
  const std::vector<Eigen::Vector3d> later = loops_->carry(drawn - 1, path);
  correction.before.pop_back();
  correction.before.insert(correction.before.end(), later.begin(), later.end());
  const std::span<const loops::Keyframe> keyframes = loops_->keyframes();
  ParticleMaps maps = redrawing_->take_maps();
  redrawing_.reset();
  draw(keyframes.subspan(drawn), maps);
  for (std::size_t i = 0; i < maps.size(); ++i) {
    if (maps[i]) maps[i]->take_figures(*best.maps[i]);
  }
  best.maps = std::move(maps);
  // The keyframe of a time: poses between two of them move with the earlier one.
  std::size_t i = 0;
  for (StampedPose& pose : path) {
    while (i + 1 < keyframes.size() && keyframes[i + 1].stamp <= pose.stamp) ++i;
    pose.T_map_base = moved(pose.T_map_base, correction.before[i], keyframes[i].xyyaw);
  }
  best.path.replace(path);
  best.belief.mean.T_map_base = moved(best.belief.mean.T_map_base, correction.before.back(), keyframes.back().xyyaw);
  carry_anchors(best, correction.before);
  if (joint_) draw_joint_again(best);
  become(best);
  closed_loop_ = ClosedLoop{correction.way, correction.shift};
}

void ParticleFilter::suspect_tear(std::size_t slot) {
  constexpr double kDistance = 5.0;  // [m]
  // One that may lie wrong by more than this leaves what comes after it without a right place beside what was before.
  constexpr double kTear = 1.5;        // [m]
  constexpr std::size_t kMost = 1000;  // so that memory is bounded where no loops are searched
  const auto is_uncertain = [&] {
    const Eigen::Matrix3d P = pose_covariance(mapping_.prior(slot), layout());
    return P(0, 0) + P(1, 1) + kDistance * kDistance * P(2, 2) > kTear * kTear;
  };
  if (!jumps_.is_one_sided() && !(mapping_.failed() && is_uncertain())) return;
  if (suspected_tears_.size() == kMost) suspected_tears_.pop_back();
  suspected_tears_.push_back(stamp());
}

void ParticleFilter::watch_jump(std::span<const MappingInput> inputs, std::size_t slot) {
  if (!mapping_.localized()) return;
  // σ that no match is better than, so that a prior without noise makes no jump of what rounds.
  const Eigen::Vector3d floor(0.01, 0.01, 0.005);  // [m], [m], [rad]
  Eigen::Vector3d jump = Eigen::Vector3d::Zero();
  for (const MappingInput& input : inputs) {
    const Refinement& refinement = mapping_.refinement(slot, input.module);
    if (!input.localize || !refinement.jump) continue;
    const Eigen::Matrix3d R_base_map = loops::turn(-mapping_.refined_from(slot, input.module).yaw());
    const Eigen::Matrix3d P = R_base_map * pose_covariance(mapping_.prior(slot), layout()) * R_base_map.transpose();
    const Eigen::Vector3d sigma = (P.diagonal() + floor.cwiseAbs2()).cwiseSqrt();
    jump = (R_base_map * refinement.jump->d).cwiseQuotient(sigma);
  }
  jumps_.add(jump);
}

std::optional<std::size_t> ParticleFilter::keyframe_of(joint::JointGaussian::NodeId anchor) const {
  const std::span<const loops::Keyframe> keyframes = loops_->keyframes();
  const auto first = std::ranges::find(keyframes, anchor, &loops::Keyframe::anchor);
  if (first == keyframes.end()) return std::nullopt;
  return static_cast<std::size_t>(first - keyframes.begin());
}

void ParticleFilter::carry_anchors(Particle& particle, std::span<const Eigen::Vector3d> before) {
  const std::vector<joint::AnchorPose> anchors = particle.anchors.items();
  particle.anchors = {};
  for (joint::AnchorPose anchor : anchors) {
    const auto first = keyframe_of(anchor.anchor);
    if (!first) continue;
    anchor.xyyaw = loops::compose(loops_->keyframes()[*first].xyyaw, loops::between(before[*first], anchor.xyyaw));
    particle.anchors.append(anchor);
  }
}

/// The graph has neither the map's place on the Earth nor height and tilt.
void ParticleFilter::draw_joint_again(const Particle& best) {
  std::vector<joint::AnchorPose> anchors;
  std::vector<std::size_t> places;  // keyframes: the first of each anchor, and the last of all
  for (const joint::AnchorPose& anchor : best.anchors.items()) {
    const auto first = keyframe_of(anchor.anchor);
    if (!first || !joint_->has_anchor(anchor.anchor)) continue;
    anchors.push_back(anchor);
    places.push_back(*first);
  }
  const std::span<const loops::Keyframe> keyframes = loops_->keyframes();
  places.push_back(keyframes.size() - 1);
  Eigen::MatrixXd P;
  if (has_graph()) P = loops_->covariance(places);
  if (P.size() > 0) {
    joint_->begin_anew(best.belief, keyframes, anchors, std::move(P));
  } else {
    joint_->draw_again(keyframes, anchors);
  }
}

}  // namespace waymark::particles
