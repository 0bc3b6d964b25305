// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "loops/keyframes.hpp"
#include "loops/pose_graph.hpp"
#include "loops/window_matcher.hpp"
#include "waymark/base/api.hpp"
#include "waymark/host/filter_settings.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark {
class MapModule;
}

namespace waymark::loops {

/// A loop that moved the path.
struct Correction {
  std::vector<Eigen::Vector3d> before;  ///< poses of all keyframes, which have the corrected ones now
  double way = 0.0;                     ///< of the loop [m]
  double shift = 0.0;                   ///< of a keyframe, at most [m]
};

/// Recognises places that the robot meets again, and corrects the path between: windows of scans about places of the
/// path are searched in older windows; matches that agree with one another become loops of a pose graph
/// (docs/math/loops.md). The path is that of the best particle.
class WAYMARK_API LoopCloser {
 public:
  LoopCloser(const LoopSettings& settings, const JointSettings& noise) : settings_(settings), noise_(noise) {}

  void clear();
  /// A mapping step, after all those before. Of a robot that stands the first ones are kept.
  void add(Keyframe keyframe);
  /// Searches the last place whose window is complete, if a search is due, in one older place for each call; in more,
  /// if the next search is due already. `path`: of the best particle, read if one is: all of it, or from a pose on
  /// before which it is as it was read last. The call after one that found loops returns the correction instead, if
  /// they move the path farther than `least_shift`; it counts as applied.
  template <class Path>
  std::optional<Correction> search(const Path& path) {
    if (!accepted_ && candidates_.empty() && !is_next_due()) return std::nullopt;
    follow(keyframes_, path());
    if (accepted_) return correct();
    search_some();
    return std::nullopt;
  }
  /// Sets keyframes to the poses of `path`, moved as `last` was: the one at which a correction was found that is
  /// carried out now. Those before `last` stay as they are. Returns the poses on the path, from `last` on.
  std::vector<Eigen::Vector3d> carry(std::size_t last, std::span<const StampedPose> path);
  /// Covariance of what is wrong with keyframes, as motions of the whole map, by the path and its loops: three rows for
  /// each. The first keyframe of all is certain; one between two nodes is as the earlier of them. Empty if the graph
  /// has no solution.
  Eigen::MatrixXd covariance(std::span<const std::size_t> keyframes) const;
  /// Drops keyframes that are no nodes if there are too many. Not while a correction is carried out.
  void bound();
  /// Forgets what came after `stamp`.
  void rewind(Time stamp);

  /// True if loops were found by which the path is still to be corrected.
  bool has_accepted() const { return accepted_.has_value(); }
  std::span<const Keyframe> keyframes() const { return keyframes_; }
  /// Of the graph.
  std::span<const Loop> loops() const { return loops_; }
  /// True if a loop relates a place before that time to one after it.
  bool is_bridged(Time stamp) const;
  /// True if places that must be those of before do not look so: the map may be torn.
  bool fails_to_recognise() const { return missed_ >= kManyMissed; }
  /// True if there are more keyframes than are kept, until the next `bound`; after it, if there are too many places.
  bool is_full() const { return keyframes_.size() > kMostKeyframes; }
  static constexpr std::size_t kMostKeyframes = 20'000;

  /// Observations are written and read by `modules`. Reading throws DataError if what is read does not fit together.
  template <class Archive>
  void serialize(Archive& archive, std::span<const std::shared_ptr<MapModule>> modules);

 private:
  static constexpr int kManyMissed = 3;
  static constexpr int kMostMissed = 100;  // as many are counted

  /// Loops that were accepted, by which the path is still to be corrected.
  struct Accepted {
    std::size_t old_loops;   // that were there before
    std::size_t recognised;  // node, before
    bool path_is_doubted;
  };

  bool is_next_due() const;
  void search_some();
  void begin_node(std::span<const Relation> from_node);
  void search_candidate(std::span<const Relation> from_node, std::span<const Relation> steps);
  void conclude_node();
  std::vector<Relation> steps() const;
  Relation step(std::size_t from_keyframe, std::size_t to_keyframe) const;
  const Keyframe& keyframe(std::size_t node) const { return keyframes_[nodes_[node]]; }
  std::vector<std::size_t> candidates(std::size_t node, std::span<const Relation> from_node) const;
  bool is_expected(std::size_t old_node, std::size_t node, const Relation& to_old) const;
  struct Search {
    std::optional<Loop> loop;
    bool misses = false;  // the place is expected to look alike, and does not
  };
  Search match(std::size_t old_node, std::size_t node, const Relation& to_old);
  /// The path may be torn.
  bool is_doubted() const { return missed_ >= 2; }
  std::size_t last_recognised() const;
  void doubt(std::vector<Relation>& steps, std::size_t since, std::size_t old_loops) const;
  bool accept(const Loop& loop, std::span<const Eigen::Vector3d> poses, std::span<const Relation> steps);
  std::vector<Eigen::Vector3d> poses() const;
  std::optional<Correction> correct();
  void thin(std::size_t end);
  bool stands_at(const Eigen::Vector3d& xyyaw) const;

  LoopSettings settings_;
  JointSettings noise_;
  std::vector<Keyframe> keyframes_;
  std::vector<std::size_t> nodes_;  // of the graph: places in keyframes_
  std::size_t searched_ = 0;        // nodes up to here
  std::vector<Relation> frozen_;    // the first steps, as they were before a correction
  std::vector<Loop> loops_;
  std::vector<Loop> pending_;  // not yet enough that agree
  std::optional<Accepted> accepted_;
  std::vector<std::size_t> candidates_;  // older nodes in which the last one that is searched has still to be searched
  bool misses_ = false;                  // of its search: a place that is expected does not look alike
  bool found_ = false;                   // a place fits the path
  std::size_t again_from_ = 0;           // nodes from here on may be searched again after a correction
  int missed_ = 0;                       // searches in a row that should have found a place
  WindowMatcher matcher_;
};

}  // namespace waymark::loops
