// SPDX-License-Identifier: Apache-2.0
#include "joint/joint_belief.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstddef>

#include "estimation/ekf.hpp"
#include "loops/twist.hpp"
#include "waymark/base/error.hpp"

namespace waymark::joint {

namespace {

/// So many points of a scan show which places it sees.
constexpr std::size_t kPoints = 90;
std::size_t stride(std::size_t points) { return points == 0 ? 1 : 1 + (points - 1) / kPoints; }

/// Some of the points, in the map.
void place_points(std::span<const Eigen::Vector2d> points_base, const Pose& T_map_base,
                  std::vector<Eigen::Vector2d>& out) {
  const std::size_t step = stride(points_base.size());
  out.clear();
  for (std::size_t i = 0; i < points_base.size(); i += step)
    out.emplace_back((T_map_base * Eigen::Vector3d(points_base[i].x(), points_base[i].y(), 0.0)).head<2>());
}

/// A scan with so many landmarks ties the pose to them: the cells' own errors do not count then.
constexpr std::size_t kEnoughLandmarks = 3;

/// Squared distance of the particles' mean, in σ of this Gaussian, that no noise explains; and for so many mapping
/// steps.
constexpr double kFar = 50.0;
/// What is reported is the second moment about the particles' mean: it covers a distance up to this.
constexpr double kCovered = 1.0;         // [m]
constexpr double kCoveredTurn = 0.1;     // [rad]
constexpr double kLeastVariance = 1e-8;  // [m², rad²]
constexpr int kOften = 20;

}  // namespace

void JointBelief::start(const Belief& prior, const Eigen::Matrix3d& frame) {
  Belief belief = prior;
  estimation::ekf::add_pose_covariance(belief, process_.layout(), frame);
  gaussian_.start(belief);
  const Eigen::Matrix3d G = loops::twist_of_error(belief.mean.T_map_base.p.head<2>());
  start_ = G * pose_covariance(belief, process_.layout()) * G.transpose();
  anchors_.clear();
  landmarks_.clear();
  frame_.clear();
  contradictions_ = 0;
  last_landmarks_ = 0;
}

void JointBelief::update(const Update& model, int owner, const estimation::Georeference* georeference) {
  const StateLayout& layout = process_.layout();
  const int block_offset = layout.block_offset(owner);
  const NavState& mean = gaussian_.belief().mean;
  const NavState state = georeference != nullptr ? georeference->in_enu(mean) : mean;
  model.linearize({state, state.block.data() + block_offset}, model_);
  H_.reset(model_.rows(), layout.size());
  if (georeference != nullptr) {
    georeference->scatter(mean, block_offset, model_, H_);
  } else {
    estimation::scatter(layout, block_offset, model_, H_);
  }
  gaussian_.update(model_, H_);
}

std::optional<JointGaussian::NodeId> JointBelief::map(const MapEvidence& evidence,
                                                      const Correspondences& correspondences,
                                                      std::span<const AnchorPose> anchors) {
  if (evidence.is_spatial && !evidence.is_prior && evidence.writes && !frame_.has_begun()) frame_.begin(gaussian_);
  if (evidence.spatial) frame_.relate(gaussian_, *evidence.spatial);
  if (evidence.is_prior) {
    relate_to_prior_map(gaussian_, evidence.match);
    return std::nullopt;
  }
  if (!correspondences.landmarks.empty()) {
    landmarks_.observe(gaussian_, correspondences.landmarks, evidence.share, evidence.writes);
    landmarks_.make_room(gaussian_, most_landmarks_);
    last_landmarks_ = correspondences.landmarks.size();
    way_at_landmarks_ = anchors_.way();
  }
  if (correspondences.points_base.empty()) return std::nullopt;
  place_points(correspondences.points_base, evidence.T_map_base, points_);
  anchors_.relate(gaussian_, evidence.match, points_, anchors);
  if (!evidence.writes) return std::nullopt;
  return anchors_.claim(gaussian_, points_, evidence.T_map_base.p.head<2>());
}

bool JointBelief::returns_uncertainly(std::span<const Eigen::Vector2d> points_base, const Pose& T_map_base) const {
  std::vector<Eigen::Vector2d> points;
  place_points(points_base, T_map_base, points);
  return anchors_.returns_uncertainly(gaussian_, points);
}

void JointBelief::draw_again(std::span<const loops::Keyframe> keyframes, std::span<const AnchorPose> anchors) {
  anchors_.forget_places(anchors);
  claim_places(keyframes);
}

void JointBelief::begin_anew(const Belief& particle, std::span<const loops::Keyframe> keyframes,
                             std::span<const AnchorPose> anchors, Eigen::MatrixXd P) {
  P += start_.replicate(P.rows() / 3, P.cols() / 3);
  const Eigen::Matrix3d T = loops::error_of_twist(particle.mean.T_map_base.p.head<2>());
  Belief belief = particle;
  estimation::ekf::add_pose_covariance(belief, process_.layout(), T * P.bottomRightCorner<3, 3>() * T.transpose());
  anchors_.begin_anew(gaussian_, belief, anchors, P);
  landmarks_.clear();
  last_landmarks_ = 0;
  contradictions_ = 0;
  claim_places(keyframes);
}

void JointBelief::claim_places(std::span<const loops::Keyframe> keyframes) {
  for (const loops::Keyframe& keyframe : keyframes) {
    if (!keyframe.anchor) continue;
    points_.clear();
    const std::size_t step = stride(keyframe.points_base.size());
    for (std::size_t i = 0; i < keyframe.points_base.size(); i += step) {
      const Eigen::Vector2d p = keyframe.points_base[i].cast<double>();
      points_.emplace_back(loops::compose(keyframe.xyyaw, {p.x(), p.y(), 0.0}).head<2>());
    }
    anchors_.claim_for(*keyframe.anchor, points_, keyframe.xyyaw.head<2>());
  }
}

JointBelief::Failure JointBelief::check(const Belief& particles) {
  if (landmarks_.size() > most_landmarks_) return {fmt::format("a scan shows more than {} landmarks", most_landmarks_)};
  const StateLayout& layout = process_.layout();
  const Belief own = belief();
  const ErrorVector off = boxminus(particles.mean, own.mean, layout);
  // A start without variance has no inverse.
  const Eigen::Matrix3d P = pose_covariance(own, layout) + kLeastVariance * Eigen::Matrix3d::Identity();
  const Eigen::Vector3d d(off[layout.pose_indices()[0]], off[layout.pose_indices()[1]], off[layout.pose_indices()[2]]);
  const Eigen::LLT<Eigen::Matrix3d> factor(P);
  const bool is_covered = d.head<2>().norm() <= kCovered && std::abs(d.z()) <= kCoveredTurn;
  const bool is_far = !is_covered && factor.info() == Eigen::Success && d.dot(factor.solve(d)) > kFar;
  contradictions_ = is_far ? contradictions_ + 1 : 0;
  if (contradictions_ < kOften) return {};
  // Contradicting surfaces are a torn map, which stays so.
  const bool begins_anew = anchors_.empty();
  if (begins_anew) {
    Belief anew = gaussian_.belief();
    anew.mean = particles.mean;
    start(anew, d * d.transpose());
  }
  return {fmt::format("it contradicts the particles by {:.3g} m and {:.2g} rad", d.head<2>().norm(), std::abs(d.z())),
          begins_anew};
}

/// A scan with enough of them holds for the way to the next anchor: surfaces and landmarks can come from two sensors.
bool JointBelief::has_landmarks_about() const {
  return last_landmarks_ >= kEnoughLandmarks && anchors_.way() - way_at_landmarks_ <= anchors_.spacing();
}

Belief JointBelief::belief() const {
  Belief belief = gaussian_.belief();
  if (has_landmarks_about()) return belief;
  estimation::ekf::add_pose_covariance(belief, process_.layout(),
                                       anchors_.local_error(belief.mean.T_map_base.p.head<2>()));
  return belief;
}

std::optional<JointBelief::LandmarkEstimate> JointBelief::landmark(std::uint64_t birth,
                                                                   const estimation::Georeference* georeference) const {
  const auto found = landmarks_.find(birth);
  if (!found) return std::nullopt;
  const Eigen::Vector2d mean = found->mean + gaussian_.pending_correction(found->node);
  const Eigen::Matrix2d P = gaussian_.node_covariance(found->node);
  if (georeference == nullptr) return LandmarkEstimate{mean, P};
  const NavState& state = gaussian_.belief().mean;
  const Eigen::Vector3d p_enu = georeference->T_enu_map(state) * Eigen::Vector3d(mean.x(), mean.y(), 0.0);
  return LandmarkEstimate{p_enu.head<2>(), georeference->point_covariance(gaussian_.belief(), state, mean, P,
                                                                          gaussian_.cross_covariance(found->node))};
}

template <class Archive>
void JointBelief::serialize(Archive& archive) {
  if (archive.section("joint_belief", 4) < 4) throw DataError("the checkpoint has an older version");
  archive(gaussian_, start_, last_landmarks_, way_at_landmarks_);
  if (!start_.allFinite()) throw DataError("the checkpoint has a start whose covariance is not finite");
  archive.within(contradictions_, 0, kOften);
  anchors_.serialize(archive, gaussian_);
  landmarks_.serialize(archive, gaussian_);
  frame_.serialize(archive, gaussian_);
}
template void JointBelief::serialize(OutArchive& archive);
template void JointBelief::serialize(InArchive& archive);

}  // namespace waymark::joint
