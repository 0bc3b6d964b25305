// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "joint/joint_gaussian.hpp"
#include "joint/place_grid.hpp"
#include "waymark/base/api.hpp"
#include "waymark/host/filter_settings.hpp"

namespace waymark::joint {

/// Where a particle was when an anchor was added: the frame of all that it mapped from there.
struct AnchorPose {
  JointGaussian::NodeId anchor = 0;
  Eigen::Vector3d xyyaw = Eigen::Vector3d::Zero();  ///< [m, m, rad]
};

/// A match of a scan with a particle's map: the likelihood exp(ηᵀ d − ½ dᵀ Λ d) of d = (x, y, yaw) ⊟ `prior`.
struct PoseMatch {
  Eigen::Vector3d prior;        ///< [m, m, rad]
  Eigen::Matrix3d information;  ///< Λ
  Eigen::Vector3d gradient;     ///< η
};

/// Updates the pose with a match in a map that is not uncertain.
void relate_to_prior_map(JointGaussian& gaussian, const PoseMatch& match);

/// The anchors of dense maps: poses of the path from which the places around them were first mapped. A scan that
/// matches such places relates the pose to their anchors, whatever way led there. An anchor has noise of its own: what
/// was mapped from it lies wrong by so much, together, and no number of scans averages that.
class WAYMARK_API Anchors {
 public:
  /// `return_way`: a place that was not seen on so long a way [m] is met again. If the pose is uncertain against its
  /// anchor, matches with it wait for the graph of the path, which verifies loops. Nothing: they count at once.
  explicit Anchors(const JointSettings& settings, std::optional<double> return_way = {})
      : settings_(settings), return_way_(return_way), spacing_(settings.anchor_spacing) {}

  /// Relates the pose to the anchors of the places that `points` (in the particle's map) lie in, each by its share of
  /// the match's information. `poses`: where the particle has the anchors.
  void relate(JointGaussian& gaussian, const PoseMatch& match, std::span<const Eigen::Vector2d> points,
              std::span<const AnchorPose> poses);
  /// The places of `points` that have no anchor get the one of this pose, which is added where none is near: then its
  /// node is returned. `position`: of the pose in the particle's map.
  std::optional<JointGaussian::NodeId> claim(JointGaussian& gaussian, std::span<const Eigen::Vector2d> points,
                                             const Eigen::Vector2d& position);

  /// True if matches with most of `points`, of those in places that have an anchor, would wait for the graph; for half
  /// as long as they do.
  bool returns_uncertainly(const JointGaussian& gaussian, std::span<const Eigen::Vector2d> points) const;
  /// True if matches with places that were met again wait for the graph.
  bool awaits_graph() const { return waiting_since_.has_value(); }
  /// There is no graph any more.
  void count_returns_at_once() { return_way_.reset(); }
  /// Driven in matches so far [m]; with turns.
  double way() const { return way_; }
  /// One anchor for so much new ground [m].
  double spacing() const { return settings_.anchor_spacing; }
  /// The pose begins anew: the robot has not driven there. Where it is now is given, so it is no return either.
  void begin_way();

  /// The anchor that new places belong to.
  std::optional<JointGaussian::NodeId> active() const;
  /// Where the anchors are in a map that was drawn again; its places have none yet.
  void forget_places(std::span<const AnchorPose> poses);
  /// The same, and how they are known, too: `P` of what is wrong with `poses`, as motions of the whole map, and with
  /// the pose at last, three rows each. `belief`: the pose in this map, as certain as its last match. Anchors that are
  /// not in `poses` are gone.
  void begin_anew(JointGaussian& gaussian, const Belief& belief, std::span<const AnchorPose> poses,
                  const Eigen::MatrixXd& P);
  /// The places of `points` near `position` that have no anchor get this one, or if it was merged the nearest one.
  void claim_for(JointGaussian::NodeId node, std::span<const Eigen::Vector2d> points, const Eigen::Vector2d& position);

  /// What the places that localised last may have crept, as covariance of (x, y, yaw) at `position`, and the error that
  /// is the place's own: cells that were drawn from other poses lie wrong each in its own way.
  Eigen::Matrix3d local_error(const Eigen::Vector2d& position) const;
  void clear();
  bool empty() const { return anchors_.empty(); }

  template <class Archive>
  void serialize(Archive& archive, const JointGaussian& gaussian);

 private:
  struct Anchor {
    JointGaussian::NodeId node;
    Eigen::Vector3d mean;    // x, y, yaw
    Eigen::Vector2d in_map;  // position in the best particle's map
    Eigen::Matrix3d creep;   // of its places, as a motion of the map
    double seen;             // way driven when it was related last
  };
  struct Share {
    int anchor;
    int points;
  };

  std::optional<JointGaussian::NodeId> choose_active(JointGaussian& gaussian, const Eigen::Vector2d& position);
  void thin(JointGaussian& gaussian);
  /// Removes anchors that no place belongs to: no match would ever be related to them.
  void remove_idle(JointGaussian& gaussian);
  /// Its places go to `keeper`, an earlier one, or kNone if it has none. The numbers of later ones fall by one.
  void remove(JointGaussian& gaussian, std::size_t anchor, int keeper);
  /// Variances of (x [m], y [m], yaw [rad]) of an anchor's own error.
  Eigen::Vector3d noise() const {
    return Eigen::Vector3d(settings_.anchor_sigma, settings_.anchor_sigma, settings_.anchor_yaw_sigma).cwiseAbs2();
  }
  /// The same of an anchor at `position`, as covariance of a motion of the whole map.
  Eigen::Matrix3d own_error(const Eigen::Vector2d& position) const;
  double way_since_last(const Eigen::Vector3d& xyyaw);
  void share(std::span<const Eigen::Vector2d> points, std::vector<Share>& shares) const;
  /// True if the anchor was not seen for long, and the pose is uncertain against it.
  bool is_uncertain_return(const JointGaussian& gaussian, const Anchor& anchor) const;
  /// True if a return waits for so long [m].
  bool has_waited(double way) const;
  /// True if matches with the anchor have no effect for now; else it counts as seen.
  bool must_wait(const JointGaussian& gaussian, Anchor& anchor);
  void claim_within_reach(std::span<const Eigen::Vector2d> points, const Eigen::Vector2d& position, int anchor);
  int nearest(const Eigen::Vector2d& position, double within) const;

  std::vector<double> distances_;  // scratch
  JointSettings settings_;
  std::optional<double> return_way_;
  double way_ = 0.0;                     // driven [m]
  std::optional<double> waiting_since_;  // way driven then
  double spacing_;                       // grows as the anchors are thinned
  std::vector<Anchor> anchors_;
  std::optional<Eigen::Vector3d> last_;              // pose of the last match, in the particle's map
  Eigen::Matrix3d creep_ = Eigen::Matrix3d::Zero();  // of the places of the last match
  int active_ = PlaceGrid::kNone;                    // new places belong to it
  PlaceGrid places_;
  std::vector<Share> shares_;  // of the last scan: anchors by their number of points, the largest first
};

}  // namespace waymark::joint
