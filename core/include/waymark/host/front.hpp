// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "waymark/base/api.hpp"
#include "waymark/interface/measurement.hpp"
#include "waymark/interface/nav_state.hpp"

namespace waymark {

class Fusion;

/// One Gaussian ahead of the filter, for the pose of the present moment: the mixture's moments, updated with the
/// measurements that the filter has not committed yet. Independent of the filter: another thread may use it while the
/// filter maps. Valid as long as the host that made it.
class WAYMARK_API Front {
 public:
  ~Front();
  Front(const Front&) = delete;
  Front& operator=(const Front&) = delete;

  /// Predicts and updates with one measurement, as passed to `Fusion::add`; without maps. One stamped before `stamp`
  /// is ignored: the filter processes it.
  void add(const Measurement& measurement);
  Time stamp() const;
  /// The measurement's stamp less the delay that the YAML gives for its sensor; the earliest time if that is not a
  /// stamp.
  Time corrected_stamp(const Measurement& measurement) const;
  /// The belief predicted to `at`; at `stamp` if that is later.
  Belief at(Time at) const;

 private:
  friend class Fusion;
  struct Impl;
  explicit Front(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace waymark
