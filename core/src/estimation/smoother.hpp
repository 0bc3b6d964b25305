// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "estimation/process_model.hpp"
#include "waymark/base/api.hpp"
#include "waymark/interface/snapshot.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::estimation {

/// Fixed-interval smoothing of one belief (Rauch, Tung, Striebel, "Maximum likelihood estimates of linear dynamic
/// systems", AIAA Journal 1965): what the filter believed after every measurement, and at the end, backwards, what it
/// would have believed had it known all that came later.
class WAYMARK_API Smoother {
 public:
  /// `process` must outlive it.
  explicit Smoother(const ProcessModel& process) : process_(process) {}

  /// The belief after a step. `standing`: how the next prediction goes. `forgot_twist`: the twist up to this step says
  /// nothing about the one from here on (`UpdateList::forget_twist`).
  void add(const Belief& posterior, bool standing, bool forgot_twist = false);
  /// Replaces what `add` said last: the belief was changed before the next prediction.
  void amend(const Belief& posterior, bool standing);
  /// The belief is widened by hand: nothing that comes later tells about what was before the next step.
  void cut_next() { cut_next_ = true; }

  std::size_t size() const { return nodes_.size(); }
  /// Forgets all but the first `size` steps.
  void truncate(std::size_t size) { nodes_.resize(size); }
  /// The first `size` steps; all that are read.
  template <class Archive>
  void serialize(Archive& archive, std::size_t size);

  /// All steps, from the first to the last.
  std::vector<SmoothedPose> smooth() const;

 private:
  struct Node {
    Time stamp;
    NavState mean;
    Eigen::MatrixXd P;  // its true size: a log has 10^5 of them
    bool standing = false;
    bool cut_before = false;
    bool forgot_twist = false;
  };
  Belief belief_of(const Node& node) const;
  std::vector<int> carried_over(bool forgot_twist) const;

  const ProcessModel& process_;
  std::vector<Node> nodes_;
  bool cut_next_ = false;
};

}  // namespace waymark::estimation
