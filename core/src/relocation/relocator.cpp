// SPDX-License-Identifier: Apache-2.0
#include "relocation/relocator.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "loops/planar.hpp"
#include "waymark/io/archive.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::relocation {

namespace {

constexpr std::uint8_t kOccupied = 65;  // percent: as map_server has it
constexpr double kFast = 0.35;          // of the averages, per step
constexpr double kSlow = 0.01;
constexpr double kFirst = 0.72;          // the fit that is expected of a map that was not looked at yet
constexpr int kFirstSteps = 20;          // that this counts for
constexpr double kMisfit = 0.8;          // of the usual fit: below, the robot is lost
constexpr double kDoubt = 0.87;          // below, it is searched for
constexpr double kFits = 0.9;            // above, it is where it is believed to be
constexpr double kBetter = 0.05;         // than where it is believed to be
constexpr double kLongestWindow = 12.0;  // [m]
constexpr int kWindows = 3;              // lengths that take turns: the longest, a half and a quarter of it
constexpr double kSearchEvery = 0.4;     // [m], in a map of the usual size or less
constexpr double kUsualReach = 20.0;     // [m], half a side; the time of a search grows with the area
constexpr double kStands = 0.02;         // [m], a scan after less way takes the place of the last one
constexpr double kTurnStep = 0.02;       // [rad]: the whole map is searched, so not as finely as for a loop
constexpr std::size_t kPoints = 180;
constexpr double kSamePlace = 0.5;     // [m]
constexpr double kSameHeading = 0.15;  // [rad]
constexpr double kLeastShare = 0.4;    // of the points of a scan, which the map says something about
constexpr double kBehind = 0.3;        // [m], a surface that a point lies behind is nearer by this
constexpr std::size_t kLeastPoints = 20;
constexpr double kLeastUsual = 0.01;  // of a checkpoint
constexpr int kMostSteps = 1000;      // as many are counted

/// A way within a window, whose numbers are not too large for cells.
constexpr double kFarthest = 1e4;  // [m]
bool is_step(const Eigen::Vector3d& xyyaw) { return xyyaw.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() < kFarthest; }

bool is_occupied(std::uint8_t cell) { return cell >= kOccupied && cell != GridView::kUnknown; }

constexpr double kLargestCell = 0.2;  // [m], larger ones have gaps between their middles

}  // namespace

Relocator::Surfaces Relocator::surfaces_of(const GridView& map) {
  const auto cells =
      static_cast<std::size_t>(std::max(map.width, 0)) * static_cast<std::size_t>(std::max(map.height, 0));
  const bool is_sound = map.resolution_m > 0.0 && map.cells.size() == cells && map.T_map_grid.p.allFinite() &&
                        map.T_map_grid.q.coeffs().allFinite();
  if (!is_sound) throw Error("a map without size or place cannot be searched");
  if (map.resolution_m > kLargestCell) {
    throw Error(
        fmt::format("its cells have {:g} m; cells of up to {:g} m are searched", map.resolution_m, kLargestCell));
  }
  Surfaces surfaces;
  Eigen::AlignedBox2d box;
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      const std::uint8_t cell = map.cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(map.width) +
                                          static_cast<std::size_t>(column)];
      if (!is_occupied(cell)) continue;
      const Eigen::Vector3d p_grid(map.resolution_m * (column + 0.5), map.resolution_m * (row + 0.5), 0.0);
      surfaces.points.emplace_back((map.T_map_grid * p_grid).head<2>());
      box.extend(surfaces.points.back());
    }
  }
  if (surfaces.points.empty()) throw Error("it has no occupied cells");
  surfaces.middle = box.center();
  surfaces.reach = 0.5 * box.sizes().maxCoeff();
  if (!(surfaces.reach <= kLargestReach)) {
    throw Error(fmt::format("it is {:.0f} m long; a map of up to {:.0f} m is searched", 2.0 * surfaces.reach,
                            2.0 * kLargestReach));
  }
  return surfaces;
}

Relocator::Relocator(GridView map) : Relocator(surfaces_of(map), std::move(map)) {}

Relocator::Relocator(const Surfaces& surfaces, GridView&& map)
    : map_(std::move(map)),
      T_grid_map_(map_.T_map_grid.inverse()),
      middle_(surfaces.middle),
      reach_(surfaces.reach),
      search_every_(kSearchEvery * std::max(1.0, surfaces.reach * surfaces.reach / (kUsualReach * kUsualReach))),
      matcher_({.reach = std::numbers::sqrt2 * reach_ + 1.0, .turn_step = kTurnStep, .points = kPoints}) {
  std::vector<Eigen::Vector2f> points;
  points.reserve(surfaces.points.size());
  for (const Eigen::Vector2d& p : surfaces.points) points.emplace_back((p - middle_).cast<float>());
  matcher_.draw(points);
  begin_anew();
}

Eigen::Vector3d Relocator::in_raster(const Eigen::Vector3d& xyyaw) const {
  return {xyyaw.x() - middle_.x(), xyyaw.y() - middle_.y(), xyyaw.z()};
}

std::uint8_t Relocator::cell_at(const Eigen::Vector2d& p_grid) const {
  const double column = p_grid.x() / map_.resolution_m;
  const double row = p_grid.y() / map_.resolution_m;
  if (!(column >= 0.0 && row >= 0.0 && column < map_.width && row < map_.height)) return GridView::kUnknown;
  return map_
      .cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(map_.width) + static_cast<std::size_t>(column)];
}

/// False if the point lies on ground that the map does not know, and no surface is before it.
bool Relocator::says_something(const Eigen::Vector2d& from_grid, const Eigen::Vector2d& to_grid) const {
  const double cell = map_.resolution_m;
  // A surface at the rim of the known ground has unknown cells on one side.
  for (const double y : {-cell, 0.0, cell}) {
    for (const double x : {-cell, 0.0, cell}) {
      if (cell_at(to_grid + Eigen::Vector2d(x, y)) != GridView::kUnknown) return true;
    }
  }
  const Eigen::Vector2d ray = to_grid - from_grid;
  const double length = ray.norm();
  if (!(length < kFarthest)) return false;
  for (double s = 0.5 * cell; s < length - kBehind; s += 0.5 * cell) {
    if (is_occupied(cell_at(from_grid + s / length * ray))) return true;
  }
  return false;
}

/// Nothing if it is not on ground that the map has.
std::optional<double> Relocator::fit_of(const Look& look) {
  const auto grid = [&](const Eigen::Vector2d& p_map) -> Eigen::Vector2d {
    return (T_grid_map_ * Eigen::Vector3d(p_map.x(), p_map.y(), 0.0)).head<2>();
  };
  const Eigen::Matrix2d R = loops::rotation(look.xyyaw.z());
  const Eigen::Vector2d from = grid(look.xyyaw.head<2>());
  counted_.clear();
  for (const Eigen::Vector2f& p : look.points_base) {
    if (!look.is_written || says_something(from, grid(look.xyyaw.head<2>() + R * p.cast<double>())))
      counted_.push_back(p);
  }
  const auto least = kLeastShare * static_cast<double>(look.points_base.size());
  if (counted_.size() < kLeastPoints || static_cast<double>(counted_.size()) < least) return std::nullopt;
  return matcher_.score(counted_, in_raster(look.xyyaw));
}

void Relocator::begin_anew() {
  if (slow_ == 0.0) slow_ = kFirst;
  fast_ = slow_;
  is_lost_ = is_ambiguous_ = false;
  forget_window();
}

void Relocator::forget_window() {
  window_.clear();
  searched_way_ = 0.0;
  searches_ = 0;
}

bool Relocator::is_doubtful() const { return fast_ < kDoubt * slow_; }

Placement Relocator::placement() const {
  if (is_lost_) return is_ambiguous_ ? Placement::ambiguous : Placement::misplaced;
  return is_doubtful() ? Placement::doubtful : Placement::fits;
}

void Relocator::judge(double fit) {
  fast_ += kFast * (fit - fast_);
  if (is_lost_) {
    // Before the first steps that fitted, what is usual is only assumed: a wrong place may fit as well.
    is_lost_ = steps_ < kFirstSteps || fast_ < kFits * slow_;
  } else if (!is_doubtful()) {
    steps_ = std::min(steps_ + 1, kMostSteps);
    slow_ += std::max(kSlow, 1.0 / (kFirstSteps + steps_)) * (fit - slow_);
  }
}

/// Adds the scan to the window, of which the oldest scans go.
void Relocator::keep(const Look& look) {
  Seen seen{Eigen::Vector3d::Zero(), 0.0, counted_};
  if (!is_step(look.moved) || (!window_.empty() && !is_step(2.0 * window_.back().xyyaw))) forget_window();
  if (!window_.empty()) {
    const Seen& last = window_.back();
    seen.xyyaw = loops::compose(last.xyyaw, look.moved);
    seen.way = last.way + look.moved.head<2>().norm() + loops::kArm * std::abs(look.moved.z());
  }
  if (!window_.empty() && seen.way - window_.back().way < kStands) window_.pop_back();
  window_.push_back(std::move(seen));
  while (window_.back().way - window_.front().way > kLongestWindow) window_.erase(window_.begin());
}

std::optional<Place> Relocator::search(const Eigen::Vector3d& believed) {
  searched_way_ = window_.back().way;
  // A long window shows more, but dead reckoning may have bent it.
  const double longest = kLongestWindow / (1 << searches_);
  searches_ = (searches_ + 1) % kWindows;
  std::vector<Eigen::Vector2f> points;  // in the axes of the last scan
  for (const Seen& seen : window_) {
    if (window_.back().way - seen.way > longest) continue;
    const Eigen::Vector3d at = loops::between(window_.back().xyyaw, seen.xyyaw);
    const Eigen::Matrix2d R = loops::rotation(at.z());
    for (const Eigen::Vector2f& p : seen.points)
      points.emplace_back((at.head<2>() + R * p.cast<double>()).cast<float>());
  }
  const loops::WindowSearch result =
      matcher_.match(points, Eigen::Vector3d::Zero(), {reach_, std::numbers::pi - 0.5 * kTurnStep});
  const std::optional<loops::WindowMatch>& found = result.match;
  is_ambiguous_ = result.is_ambiguous;
  const bool is_found = found && found->score > kMisfit * slow_;
  is_lost_ = is_lost_ || (!is_found && fast_ < kMisfit * slow_);
  if (!is_found) return std::nullopt;
  Place place{found->relation.z, found->relation.P};
  place.xyyaw.head<2>() += middle_;
  const Eigen::Vector3d off = loops::difference(place.xyyaw, believed);
  if (off.head<2>().norm() < kSamePlace && std::abs(off.z()) < kSameHeading) {
    is_lost_ = false;
    slow_ = std::min(slow_, fast_);  // the map looks so here
    return std::nullopt;
  }
  if (found->score < std::max(fast_, matcher_.score(points, in_raster(believed))) + kBetter) return std::nullopt;
  begin_anew();
  return place;
}

std::optional<Place> Relocator::add(const Look& look) {
  if (const std::optional<double> fit = fit_of(look)) {
    judge(*fit);
    // The window begins where the misfit does.
    if (!is_lost_ && *fit > kFits * slow_) {
      forget_window();
      return std::nullopt;
    }
  } else if (window_.empty()) {
    return std::nullopt;
  }
  keep(look);
  if (!is_lost_ && !is_doubtful()) return std::nullopt;
  if (window_.size() > 1 && window_.back().way - searched_way_ < search_every_) return std::nullopt;
  return search(look.xyyaw);
}

template <class Archive>
void Relocator::serialize(Archive& archive) {
  archive.section("relocation", 1);
  archive.within(fast_, 0.0, 1.0);
  archive.within(slow_, kLeastUsual, 1.0);
  archive.within(steps_, 0, kMostSteps);
  archive(is_lost_, is_ambiguous_, searched_way_);
  archive.within(searches_, 0, kWindows - 1);
  archive.each(window_, [](auto& each, Seen& seen) {
    each(seen.xyyaw, seen.way);
    each.each(seen.points, [](auto& points, Eigen::Vector2f& p) { points(p); });
  });
  if constexpr (Archive::kReads) {
    const auto is_near = [](const Seen& seen) {
      return is_step(seen.xyyaw) && std::ranges::all_of(seen.points, [](const Eigen::Vector2f& p) {
               return p.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() < static_cast<float>(kFarthest);
             });
    };
    const double way = window_.empty() ? 0.0 : window_.back().way;
    if (!(searched_way_ >= 0.0 && searched_way_ <= way) || !std::ranges::is_sorted(window_, {}, &Seen::way) ||
        !std::ranges::all_of(window_, is_near))
      throw DataError("the checkpoint has scans of a search that do not fit together");
  }
}
template void Relocator::serialize(OutArchive& archive);
template void Relocator::serialize(InArchive& archive);

}  // namespace waymark::relocation
