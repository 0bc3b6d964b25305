// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "plugins/shared/run_views/thinned.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark::run_views {

/// The GNSS fixes of a run, for pictures of it: at most 4096 of each kind.
class FixTrack {
 public:
  enum class Kind { used, rejected, held_out };
  static constexpr std::array kKinds{Kind::used, Kind::rejected, Kind::held_out};

  /// Takes the snapshot's measurement, if it is a fix with a position.
  void add(const Snapshot& snapshot);

  /// Number of fixes, those that were thinned out included.
  std::size_t count(Kind kind) const { return of(kind).count(); }
  /// East and north in the map [m]. Geodetic fixes need the datum, the map's origin: without it they are left out.
  std::vector<Eigen::Vector2d> positions(Kind kind, const std::optional<Datum>& datum) const;

 private:
  /// East and north [m], or latitude and longitude [°] and the height [m].
  struct Fix {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    bool is_geodetic = false;
  };
  using Fixes = Thinned<Fix, 4096>;
  const Fixes& of(Kind kind) const { return fixes_[static_cast<std::size_t>(kind)]; }

  std::array<Fixes, kKinds.size()> fixes_;
};

}  // namespace waymark::run_views
