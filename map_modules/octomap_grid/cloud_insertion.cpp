// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/cloud_insertion.hpp"

#include <array>
#include <cmath>

#include "waymark/base/error.hpp"

namespace waymark::octomap_grid {

namespace {

constexpr int kTileSide = VoxelOctree::kSide;
constexpr std::int32_t kUntouched = -1;

}  // namespace

/// Finds the box around the scan, and where in it the scan lies.
void CloudInsertion::open(VoxelMap& map, const OctomapGridSettings& settings) {
  Voxels low = hits_.front();
  Voxels high = low;
  for (const auto* points : {&hits_, &clear_to_}) {
    for (const Voxels& p : *points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  // Beams are followed in steps, so rounding may lead a voxel out of the box; distances reach farther.
  constexpr double kMargin = 2 * scan_matching::StoredDistance::kReach + 2;
  window_.open(map, settings.resolution * (low.head<2>().array() - kMargin).matrix(),
               settings.resolution * (high.head<2>().array() + kMargin).matrix(), settings.resolution);
  constexpr double kMost = double{TileIndex::kMost} * kTileSide;
  if (!(low.z() > -kMost && high.z() < kMost)) throw Error("the scan lies outside of what a grid can hold");
  low_z_ = tile_of(static_cast<std::int32_t>(std::floor(low.z())) - 1);
  const std::int32_t levels = tile_of(static_cast<std::int32_t>(std::floor(high.z())) + 1) - low_z_ + 1;
  levels_ = static_cast<std::size_t>(levels);
  slots_.assign(window_.rect().size() * levels_, kUntouched);
  n_touched_ = 0;
  constexpr double kTile = kTileSide;
  const Voxels origin(window_.origin().x, window_.origin().y, low_z_ * kTile);
  for (auto* points : {&hits_, &clear_to_}) {
    for (Voxels& p : *points) p -= origin;
  }
}

VoxelOctree::Marks& CloudInsertion::marks(std::int32_t x, std::int32_t y, std::int32_t z) {
  constexpr int kBits = VoxelOctree::kBits;
  const std::size_t column = window_.slot(x, y);
  std::int32_t& slot = slots_[column * levels_ + static_cast<std::size_t>(z >> kBits)];
  if (slot == kUntouched) {
    slot = static_cast<std::int32_t>(n_touched_);
    if (n_touched_ == touched_.size()) touched_.emplace_back();
    touched_[n_touched_++] = {column, low_z_ + (z >> kBits), {}};
  }
  return touched_[static_cast<std::size_t>(slot)].marks;
}

/// False if another end point lies in the same voxel.
bool CloudInsertion::mark_end(const Voxels& end) {
  const auto x = static_cast<std::int32_t>(end.x());
  const auto y = static_cast<std::int32_t>(end.y());
  const auto z = static_cast<std::int32_t>(end.z());
  const std::size_t place = VoxelOctree::place(x, y, z);
  std::uint64_t& word = marks(x, y, z).hit[place >> 6];
  const std::uint64_t bit = std::uint64_t{1} << (place & 63);
  const bool is_first = (word & bit) == 0;
  word |= bit;
  return is_first;
}

/// The voxels from the beam's beginning to before its end: one in every layer across its longest axis, where the beam
/// passes its middle.
template <int kMajor>
void CloudInsertion::mark_beam_along(const Voxels& from, const Voxels& to) {
  constexpr int kA = kMajor == 0 ? 1 : 0;
  constexpr int kB = kMajor == 2 ? 1 : 2;
  const auto first = static_cast<std::int32_t>(from(kMajor));
  const auto end = static_cast<std::int32_t>(to(kMajor));
  if (first == end) return;  // also where the beam has no length
  const std::int32_t step = end >= first ? 1 : -1;
  constexpr int kFraction = 16;
  constexpr double kOne = 1 << kFraction;
  const double length = to(kMajor) - from(kMajor);
  const double slope_a = (to(kA) - from(kA)) / length;
  const double slope_b = (to(kB) - from(kB)) / length;
  const double to_middle = first + 0.5 - from(kMajor);
  auto a = static_cast<std::int32_t>((from(kA) + to_middle * slope_a) * kOne);
  auto b = static_cast<std::int32_t>((from(kB) + to_middle * slope_b) * kOne);
  const auto step_a = static_cast<std::int32_t>(std::lround(step * slope_a * kOne));
  const auto step_b = static_cast<std::int32_t>(std::lround(step * slope_b * kOne));
  // Beams stay in a tile for several voxels, so its marks are looked up only when the tile changes.
  std::array<std::int32_t, 3> last{-1, -1, -1};
  VoxelOctree::Bits* free = nullptr;
  for (std::int32_t major = first; major != end; major += step, a += step_a, b += step_b) {
    std::array<std::int32_t, 3> at{};
    at[kMajor] = major;
    at[kA] = a >> kFraction;
    at[kB] = b >> kFraction;
    if ((((at[0] ^ last[0]) | (at[1] ^ last[1]) | (at[2] ^ last[2])) >> VoxelOctree::kBits) != 0) {
      last = at;
      free = &marks(at[0], at[1], at[2]).free;
    }
    const std::size_t place = VoxelOctree::place(at[0], at[1], at[2]);
    (*free)[place >> 6] |= std::uint64_t{1} << (place & 63);
  }
}

void CloudInsertion::mark_beam(const Voxels& from, const Voxels& to) {
  const Eigen::Array3d length = (to - from).array().abs();
  if (length.x() >= length.y() && length.x() >= length.z()) {
    mark_beam_along<0>(from, to);
  } else if (length.y() >= length.z()) {
    mark_beam_along<1>(from, to);
  } else {
    mark_beam_along<2>(from, to);
  }
}

void CloudInsertion::apply(std::size_t touched, const VoxelOdds& odds) {
  Touched& own = touched_[touched];
  for (std::size_t i = 0; i < own.marks.free.size(); ++i) own.marks.free[i] &= ~own.marks.hit[i];
  const VoxelTile* there = window_.column(own.column).find(own.z);
  static const VoxelOctree unknown;
  const std::uint64_t changing = (there == nullptr ? unknown : there->voxels).changing(own.marks, odds);
  if (changing == 0) return;  // the tile may stay shared
  VoxelTile& tile = window_.writable(own.column).write(own.z);
  tile_occupied_.clear();
  tile_freed_.clear();
  tile.voxels.apply(own.marks, changing, odds, tile_occupied_, tile_freed_);
  if (!keeps_layers_) return;
  const Cell corner = window_.corner(own.column);
  const auto note = [&](const std::vector<LocalVoxel>& changed, bool is_occupied, std::vector<LayerCell>& all) {
    for (const LocalVoxel v : changed) {
      tile.write_slab(v.z).set_occupied(v.x, v.y, is_occupied);
      all.push_back({own.z * kTileSide + v.z, {corner.x + v.x, corner.y + v.y}});
    }
  };
  note(tile_freed_, false, freed_);
  note(tile_occupied_, true, occupied_);
}

void CloudInsertion::insert(VoxelMap& map, const Pose& T_map_base, const CloudObservation& cloud,
                            const OctomapGridSettings& settings) {
  const Eigen::Matrix3d R = T_map_base.q.toRotationMatrix() / settings.resolution;
  const Voxels p = T_map_base.p / settings.resolution;
  hits_.clear();
  clear_to_.clear();
  hits_.emplace_back(R * cloud.p_base_sensor + p);  // the beginning of all beams comes along
  for (const Eigen::Vector3f& hit : cloud.hits) hits_.emplace_back(R * hit.cast<double>() + p);
  for (const Eigen::Vector3f& end : cloud.clear_to) clear_to_.emplace_back(R * end.cast<double>() + p);
  open(map, settings);
  keeps_layers_ = !settings.has_surfels();
  const Voxels from = hits_.front();
  // Ends first: where two points share a voxel of a dense cloud, their beams are as good as one.
  std::size_t kept = 0;
  for (std::size_t i = 1; i < hits_.size(); ++i) {
    const bool is_first = mark_end(hits_[i]);
    if (is_first || !cloud.is_dense) hits_[kept++] = hits_[i];
  }
  for (std::size_t i = 0; i < kept; ++i) mark_beam(from, hits_[i]);
  for (const Voxels& end : clear_to_) mark_beam(from, end);
  freed_.clear();
  occupied_.clear();
  const VoxelOdds odds(settings.odds);
  for (std::size_t i = 0; i < n_touched_; ++i) apply(i, odds);
  distances_.apply(window_, freed_, occupied_);
}

}  // namespace waymark::octomap_grid
