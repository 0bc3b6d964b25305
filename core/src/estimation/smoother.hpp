// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "estimation/process_model.hpp"
#include "waymark/base/api.hpp"
#include "waymark/interface/snapshot.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::estimation {

/// Fixed-interval smoother (H. E. Rauch, F. Tung, C. T. Striebel, "Maximum likelihood estimates of linear dynamic
/// systems", AIAA Journal 1965): stores the belief after every step, and smooths them backwards at the end of the log.
class WAYMARK_API Smoother {
 public:
  /// `process` must outlive it.
  explicit Smoother(const ProcessModel& process) : process_(process) {}

  /// Adds the belief after a step. `standing`: how the next prediction runs. `resets_twist`: the twist was reset in
  /// this step (`UpdateList::reset_twist`); nothing is carried back to the twist before it.
  void add(const Belief& posterior, bool standing, bool resets_twist = false);
  /// Replaces the belief of the last step: it was changed before the next prediction.
  void amend(const Belief& posterior, bool standing);
  /// The covariance was inflated: nothing is carried back from the next step.
  void cut_next() { cut_next_ = true; }

  std::size_t size() const { return nodes_.size(); }
  /// Removes all but the first `size` steps.
  void truncate(std::size_t size) { nodes_.resize(size); }
  /// The first `size` steps. Reading throws DataError if they are not so many, in order, up to `now`.
  template <class Archive>
  void serialize(Archive& archive, std::size_t size, Time now);

  /// The smoothed poses of all steps, in order.
  std::vector<SmoothedPose> smooth() const;

 private:
  struct Node {
    Time stamp;
    NavState mean;
    Eigen::MatrixXd P;  // its true size: a log has 10^5 of them
    bool standing = false;
    bool cut_before = false;
    bool resets_twist = false;
  };
  Belief belief_of(const Node& node) const;
  std::vector<int> carried_over(bool resets_twist) const;

  const ProcessModel& process_;
  std::vector<Node> nodes_;
  bool cut_next_ = false;
};

}  // namespace waymark::estimation
