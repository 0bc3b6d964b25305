// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/surfels/surfel_tile.hpp"

#include <algorithm>

#include "waymark/base/error.hpp"

namespace waymark::octomap_grid {

bool SurfelTile::takes(const Addition& addition) const {
  const Surfel* const own = find(addition.column, addition.surfel.z);
  return own == nullptr || own->count < Surfel::kEnough;
}

bool SurfelTile::takes(std::span<const Addition> additions) const {
  return std::ranges::any_of(additions, [this](const Addition& addition) { return takes(addition); });
}

void SurfelTile::add(std::span<const Addition> additions, float cell) {
  std::vector<Surfel> merged;
  merged.reserve(surfels_.size() + additions.size());
  std::array<std::uint32_t, kColumns + 1> begin{};
  auto addition = additions.begin();
  for (std::size_t column = 0; column < kColumns; ++column) {
    begin[column] = static_cast<std::uint32_t>(merged.size());
    std::size_t own = begin_[column];
    const std::size_t end = begin_[column + 1];
    const auto adds = [&] { return addition != additions.end() && addition->column == column; };
    while (own < end || adds()) {
      if (!adds() || (own < end && surfels_[own].z < addition->surfel.z)) {
        merged.push_back(surfels_[own++]);
        continue;
      }
      if (own < end && surfels_[own].z == addition->surfel.z) {
        merged.push_back(surfels_[own++]);
        if (merged.back().count >= Surfel::kEnough) {
          ++addition;
          continue;
        }
        merged.back().add(addition->surfel);
      } else {
        merged.push_back(addition->surfel);
      }
      merged.back().fit(cell);
      ++addition;
    }
  }
  begin[kColumns] = static_cast<std::uint32_t>(merged.size());
  begin_ = begin;
  surfels_ = std::move(merged);
}

std::size_t SurfelTile::bytes(std::set<const void*>& /*seen*/) const {
  return sizeof(SurfelTile) + surfels_.capacity() * sizeof(Surfel);
}

void SurfelTile::save(OutArchive& out) const {
  for (std::size_t column = 0; column < kColumns; ++column) {
    out.value(begin_[column + 1] - begin_[column]);
    for (std::size_t i = begin_[column]; i < begin_[column + 1]; ++i) {
      const Surfel& surfel = surfels_[i];
      out(surfel.z, surfel.count, surfel.sum, surfel.products, surfel.middle, surfel.normal, surfel.variance);
    }
  }
}

void SurfelTile::load(InArchive& in) {
  // Beyond any cell [m].
  const auto is_near = [](const Eigen::Vector3f& p) { return p.cwiseAbs().maxCoeff() < 1e3f; };
  surfels_.clear();
  for (std::size_t column = 0; column < kColumns; ++column) {
    begin_[column] = static_cast<std::uint32_t>(surfels_.size());
    std::uint32_t count = 0;
    in.value(count);
    for (std::uint32_t i = 0; i < count; ++i) {
      Surfel surfel;
      in(surfel.z, surfel.count, surfel.sum, surfel.products, surfel.middle, surfel.normal, surfel.variance);
      const bool ascends = i == 0 || surfels_.back().z < surfel.z;
      const bool is_plane = !surfel.is_plane() || std::abs(surfel.normal.norm() - 1.0f) < 1e-3f;
      if (!ascends || !is_plane || surfel.count == 0 || !(surfel.variance >= 0.0f) || !is_near(surfel.middle))
        throw DataError("checkpoint: tiles: surfels that are not valid");
      surfels_.push_back(surfel);
    }
  }
  begin_[kColumns] = static_cast<std::uint32_t>(surfels_.size());
}

}  // namespace waymark::octomap_grid
