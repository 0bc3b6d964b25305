// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "loops/keyframes.hpp"
#include "loops/loop_closer.hpp"
#include "waymark/base/api.hpp"
#include "waymark/interface/particle_map.hpp"

namespace waymark::particles {

/// Maps of one particle, one per module; null where the module is out of service.
using ParticleMaps = std::vector<std::unique_ptr<ParticleMap>>;

/// A pose in the map with another place and heading in the plane: what lay at `from` is moved to `to`.
WAYMARK_API Pose moved(const Pose& pose, const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// The initial maps of the modules again, with the figures of these.
ParticleMaps blank_maps(const ParticleMaps& maps);
/// Writes the observations of keyframes at their poses.
void draw(std::span<const loops::Keyframe> keyframes, ParticleMaps& maps);

/// A correction by a loop that is being carried out. The maps are drawn again along the corrected path, a piece in each
/// mapping step. Meanwhile the particles go on in a map of what was seen last: in the whole one the robot would be
/// found in either of the two places that the loop shows to be one.
class WAYMARK_API Redrawing {
 public:
  /// `old`: the maps before the correction.
  Redrawing(loops::Correction correction, ParticleMaps old);
  /// On a checkpoint: `drawn` of these keyframes had been drawn.
  Redrawing(loops::Correction correction, ParticleMaps old, std::span<const loops::Keyframe> keyframes,
            std::size_t drawn);
  Redrawing(Redrawing&&) = default;
  Redrawing& operator=(Redrawing&&) = default;

  /// The maps to go on in: of the last keyframes before the correction, at their poses of then.
  ParticleMaps recent_maps(std::span<const loops::Keyframe> keyframes) const;
  /// Draws the next keyframes, about `kPiece` points.
  void draw_piece(std::span<const loops::Keyframe> keyframes);
  /// True if all that the correction moved are drawn.
  bool is_drawn() const { return drawn_ == keyframes(); }
  void drop_module(std::size_t module) {
    maps_[module] = nullptr;
    old_[module] = nullptr;
  }

  /// Poses before the correction, of all keyframes at its time; they have the corrected ones.
  const loops::Correction& correction() const { return correction_; }
  /// How many keyframes it moved: those that came later lie in the map of what was seen last.
  std::size_t keyframes() const { return correction_.before.size(); }
  std::size_t drawn() const { return drawn_; }
  /// The whole maps before the correction.
  const ParticleMaps& old_maps() const { return old_; }
  ParticleMaps take_maps() { return std::move(maps_); }

 private:
  static constexpr std::size_t kPiece = 60'000;   // points: some 14 ms
  static constexpr std::size_t kRecent = 15'000;  // points of the map to go on in, at most
  static constexpr double kRecentWay = 20.0;      // [m]

  loops::Correction correction_;
  ParticleMaps old_;
  ParticleMaps maps_;
  std::size_t drawn_ = 0;
};

}  // namespace waymark::particles
