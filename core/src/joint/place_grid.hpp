// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "waymark/base/error.hpp"

namespace waymark::joint {

/// Which anchor each place of the plane was first mapped from, in squares. A place keeps its anchor.
class PlaceGrid {
 public:
  static constexpr double kSide = 1.0;  ///< of a square [m]
  static constexpr int kNone = -1;

  using Place = std::pair<std::int32_t, std::int32_t>;
  static Place place_of(const Eigen::Vector2d& p_map) {
    static constexpr double kFarthest = 1e9;  // of 32 bits
    const auto index = [](double x) {
      return static_cast<std::int32_t>(std::clamp(std::floor(x / kSide), -kFarthest, kFarthest));
    };
    return {index(p_map.x()), index(p_map.y())};
  }

  /// Number of the anchor, or kNone.
  int find(Place place) const {
    const auto found = anchor_of_.find(place);
    return found == anchor_of_.end() ? kNone : found->second;
  }
  void claim(Place place, int anchor) { anchor_of_.try_emplace(place, anchor); }
  /// The anchor `removed` gives its places to `keeper`; the numbers of later ones fall by one. keeper < removed; kNone
  /// if there are no places to give.
  void remove(int removed, int keeper) {
    for (auto& [place, anchor] : anchor_of_) {
      if (anchor == removed) anchor = keeper;
      if (anchor > removed) --anchor;
    }
  }
  void clear() { anchor_of_.clear(); }
  /// The anchor of each place.
  template <class Function>
  void for_each_anchor(const Function& function) const {
    for (const auto& [place, anchor] : anchor_of_) function(static_cast<int>(anchor));
  }
  /// The largest number of an anchor.
  int largest() const {
    int most = kNone;
    for (const auto& [place, anchor] : anchor_of_) most = std::max(most, static_cast<int>(anchor));
    return most;
  }

  template <class Archive>
  void serialize(Archive& archive) {
    std::vector<std::int32_t> flat;
    flat.reserve(3 * anchor_of_.size());
    for (const auto& [place, anchor] : anchor_of_) flat.insert(flat.end(), {place.first, place.second, anchor});
    archive(flat);
    if constexpr (Archive::kReads) {
      if (flat.size() % 3 != 0) throw DataError("the checkpoint has a place without an anchor");
      anchor_of_.clear();
      for (std::size_t i = 0; i < flat.size(); i += 3) {
        if (flat[i + 2] < 0) throw DataError("the checkpoint has a place without an anchor");
        anchor_of_.try_emplace({flat[i], flat[i + 1]}, flat[i + 2]);
      }
    }
  }

 private:
  std::map<Place, std::int32_t> anchor_of_;
};

}  // namespace waymark::joint
