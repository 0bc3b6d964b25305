// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estimation/georeference.hpp"
#include "joint/anchors.hpp"
#include "joint/frame_node.hpp"
#include "joint/joint_gaussian.hpp"
#include "joint/landmark_nodes.hpp"
#include "loops/keyframes.hpp"
#include "waymark/base/api.hpp"
#include "waymark/host/filter_settings.hpp"
#include "waymark/interface/particle_map.hpp"
#include "waymark/interface/update.hpp"

namespace waymark::joint {

/// What one map of the best particle contributes to a mapping step.
struct MapEvidence {
  PoseMatch match;                                     ///< of surfaces, as the particle used it
  Pose T_map_base = {};                                ///< the particle's pose after the match
  double share = 1.0;                                  ///< exponent of the likelihood of landmarks
  bool writes = true;                                  ///< the observation will be added to the map
  bool is_prior = false;                               ///< the map was loaded: its places are not uncertain
  bool is_spatial = false;                             ///< a map that matches all six of the pose
  std::optional<SpatialMatch> spatial = std::nullopt;  ///< its match, if there was something to match
};

/// The belief that the filter reports where maps localise: one Gaussian over the navigation state and the places of the
/// map, with the particles' associations and matches. Particles forget at resampling how uncertain their common past
/// was; this Gaussian does not (docs/math/joint.md).
class WAYMARK_API JointBelief {
 public:
  /// `process` must outlive the object. Of more than `most_landmarks`, those of long ago are thinned out: joining and
  /// parting the distant ones takes a time that grows with the square of their number.
  /// `return_way` [m]: of Anchors.
  JointBelief(const estimation::ProcessModel& process, const JointSettings& settings,
              std::optional<double> return_way = {}, std::size_t most_landmarks = 250)
      : process_(process),
        most_landmarks_(most_landmarks),
        gaussian_(process.layout()),
        anchors_(settings, return_way) {}

  /// Begins with the navigation state alone. `frame`: covariance of (x, y, yaw) of the map's origin, where the
  /// particles take the start pose for it.
  void start(const Belief& prior, const Eigen::Matrix3d& frame);
  /// The pose begins anew; the map stays.
  void restart(const Belief& belief) {
    gaussian_.restart(belief);
    anchors_.begin_way();
  }

  void predict(Time to, bool standing) { gaussian_.predict(process_, to, standing); }
  /// An update that the particles have accepted. `owner`: of the model's own states. `georeference`: set if the model
  /// has the pose in ENU and the map's place on the Earth is a state.
  void update(const Update& model, int owner, const estimation::Georeference* georeference);
  /// One map's part of a mapping step, before the particles' poses are sampled. `anchors`: where the best particle has
  /// them. Returns a new anchor, if one was added: the particles must keep where they write the observation.
  std::optional<JointGaussian::NodeId> map(const MapEvidence& evidence, const Correspondences& correspondences,
                                           std::span<const AnchorPose> anchors);

  /// True if matches with what is seen there would wait for the graph (docs/math/joint.md): most of the points, in the
  /// base frame at that pose, lie in places that were not seen for long and may lie elsewhere.
  bool returns_uncertainly(std::span<const Eigen::Vector2d> points_base, const Pose& T_map_base) const;

  /// The anchor that new places belong to.
  std::optional<JointGaussian::NodeId> active_anchor() const { return anchors_.active(); }
  /// True if matches with places that were met again wait for `begin_anew`.
  bool awaits_graph() const { return anchors_.awaits_graph(); }
  /// There is no graph any more.
  void count_returns_at_once() { anchors_.count_returns_at_once(); }
  /// False if it was merged with another one.
  bool has_anchor(JointGaussian::NodeId anchor) const { return gaussian_.has_node(anchor); }
  /// The best particle's map was drawn again along another path: `anchors` are where they are now, and the places get
  /// their anchors anew. What the loop says about the poses enters by the next matches with its places.
  void draw_again(std::span<const loops::Keyframe> keyframes, std::span<const AnchorPose> anchors);
  /// The same, and the Gaussian begins anew with what the graph of the path says, `P`: of what is wrong with `anchors`
  /// and at last with the pose, as motions of the whole map, three rows each. `particle`: the best one's belief.
  /// Matches with places that were wrong beside one another are forgotten so; and landmarks, until they are seen again.
  void begin_anew(const Belief& particle, std::span<const loops::Keyframe> keyframes,
                  std::span<const AnchorPose> anchors, Eigen::MatrixXd P);

  /// Something that this Gaussian cannot represent.
  struct Failure {
    std::string why;              ///< empty: there is nothing
    bool has_begun_anew = false;  ///< else it must not be used any more
  };
  /// To be called after each mapping step. A scan may show more landmarks than there is room for. And after a wrong
  /// association the Gaussian may be far from `particles`, the same marginal by the particles. If it has landmarks
  /// only, it then begins anew, about the particles' mean, with the distance to it as uncertainty. A small distance is
  /// no failure: it is part of what is reported.
  Failure check(const Belief& particles);

  /// `change` makes velocity and rate uncorrelated with all else.
  template <class Change>
  void replace_twist(const Change& change) {
    gaussian_.replace_twist(change);
  }
  /// `change` adds variance to the navigation state.
  template <class Change>
  void add_noise(const Change& change) {
    gaussian_.add_noise(change);
  }

  /// Marginal of the navigation state, its pose in the map. Where surfaces localise, with the error of the place: cells
  /// that were drawn from other poses lie wrong each in its own way.
  Belief belief() const;
  /// Time of the belief.
  Time stamp() const { return gaussian_.belief().stamp; }
  /// A landmark's position, in ENU if `georeference` is not null, and its marginal covariance.
  struct LandmarkEstimate {
    Eigen::Vector2d p;
    Eigen::Matrix2d P;
  };
  /// The landmark of this birth; nothing if it has no node.
  std::optional<LandmarkEstimate> landmark(std::uint64_t birth, const estimation::Georeference* georeference) const;

  template <class Archive>
  void serialize(Archive& archive);

 private:
  void claim_places(std::span<const loops::Keyframe> keyframes);
  bool has_landmarks_about() const;

  const estimation::ProcessModel& process_;
  std::size_t most_landmarks_;
  Eigen::Matrix3d start_ = Eigen::Matrix3d::Zero();  // covariance of the start pose, as a motion of the whole map
  JointGaussian gaussian_;
  Anchors anchors_;
  LandmarkNodes landmarks_;
  FrameNode frame_;
  Linearization model_;                  // scratch
  estimation::StateJacobian H_;          // scratch
  int contradictions_ = 0;               // mapping steps in a row far from the particles
  std::uint64_t last_landmarks_ = 0;     // number in the last scan that showed any
  double way_at_landmarks_ = 0.0;        // of the anchors, then
  std::vector<Eigen::Vector2d> points_;  // scratch: in the map
};

}  // namespace waymark::joint
