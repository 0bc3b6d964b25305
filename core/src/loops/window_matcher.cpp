// SPDX-License-Identifier: Apache-2.0
#include "loops/window_matcher.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace waymark::loops {

namespace {

constexpr double kCoarseSigma = 0.25;  // [m]
constexpr double kFineSigma = 0.12;
constexpr std::size_t kLeastPoints = 60;
constexpr double kLeastCoarseScore = 0.55;
constexpr double kLeastScore = 0.55;
/// A place so far from the best one is another one [m, rad]; it rivals the best one with such a share of its score.
constexpr double kOtherPlace = 1.0;
constexpr double kOtherTurn = 0.1;
constexpr double kRival = 0.95;
/// exp(kSharpness · score) is the likelihood of a window: its points are far from independent.
constexpr double kSharpness = 60.0;
constexpr double kFloor = 0.05;                                 // σ that is added [m]
constexpr double kTurnFloor = 0.35 * std::numbers::pi / 180.0;  // [rad]

/// A match that slides along a corridor as far as its moments look says nothing about that direction.
void open_weak_direction(Eigen::Matrix3d& P, double weak_sigma) {
  constexpr double kSlides = 0.2;  // σ [m]; 0.4 is all of the grid
  const double angle = 0.5 * std::atan2(2.0 * P(0, 1), P(0, 0) - P(1, 1));
  const Eigen::Vector3d along(std::cos(angle), std::sin(angle), 0.0);
  if (along.dot(P * along) > kSlides * kSlides) P += weak_sigma * weak_sigma * along * along.transpose();
}

}  // namespace

void WindowMatcher::draw(std::span<const Eigen::Vector2f> points) {
  coarse_.draw(points, kCoarseSigma, ScoreRaster::kLevels);
  fine_.draw(points, kFineSigma, 1);
}

WindowSearch WindowMatcher::match(std::span<const Eigen::Vector2f> points, const Eigen::Vector3d& prior,
                                  const SearchRange& range) {
  points_.clear();
  const std::size_t step = 1 + points.size() / settings_.points;
  for (std::size_t i = 0; i < points.size(); i += step) points_.push_back(points[i]);
  if (points_.size() < kLeastPoints) return {.match = std::nullopt, .is_ambiguous = true};
  turn_points(prior, range);
  const auto full = static_cast<double>(255 * points_.size());
  const Place best = search(static_cast<int>(kLeastCoarseScore * full), [](const Place&) { return true; });
  if (best.turn < 0) return {};
  const auto is_other = [&](const Place& place) {
    const double d = ScoreRaster::kCell * std::hypot(place.x - best.x, place.y - best.y);
    return d > kOtherPlace || std::abs(so3::wrap(settings_.turn_step * (place.turn - best.turn))) > kOtherTurn;
  };
  if (search(static_cast<int>(kRival * best.sum), is_other).turn >= 0)
    return {.match = std::nullopt, .is_ambiguous = true};
  const int turns = static_cast<int>(turned_.size()) / 2;
  const Eigen::Vector3d at(prior.x() + ScoreRaster::kCell * best.x, prior.y() + ScoreRaster::kCell * best.y,
                           so3::wrap(prior.z() + settings_.turn_step * (best.turn - turns)));
  const WindowMatch match = refine(at, range.distance);
  if (match.score < kLeastScore) return {};
  return {.match = match};
}

double WindowMatcher::score(std::span<const Eigen::Vector2f> points, const Eigen::Vector3d& at) const {
  const Eigen::Matrix2d R = rotation(at.z());
  ShiftedSums<0> sums;
  for (const Eigen::Vector2f& point : points) {
    const Eigen::Vector2d p = at.head<2>() + R * point.cast<double>();
    if (!(p.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() < settings_.reach)) continue;
    fine_.add_shifted(fine_.in_cells(p.x()), fine_.in_cells(p.y()), sums);
  }
  return static_cast<double>(sums.at(0, 0)) / (255.0 * static_cast<double>(points.size()));
}

void WindowMatcher::turn_points(const Eigen::Vector3d& prior, const SearchRange& range) {
  reach_ = std::max(1, static_cast<int>(range.distance / ScoreRaster::kCell));
  const int turns = static_cast<int>(range.angle / settings_.turn_step);
  turned_.resize(2 * static_cast<std::size_t>(turns) + 1);
  auto of_turn = turned_.begin();
  for (int turn = -turns; turn <= turns; ++turn) {
    std::vector<Eigen::Vector2i>& cells = *of_turn++;
    cells.clear();
    cells.reserve(points_.size());
    const Eigen::Matrix2d R = rotation(prior.z() + settings_.turn_step * turn);
    for (const Eigen::Vector2f& p : points_) {
      const Eigen::Vector2d at = prior.head<2>() + R * p.cast<double>();
      cells.emplace_back(static_cast<int>(std::floor(coarse_.in_cells(at.x()))),
                         static_cast<int>(std::floor(coarse_.in_cells(at.y()))));
    }
  }
}

int WindowMatcher::sum(const Place& place) const {
  int sum = 0;
  for (const Eigen::Vector2i& cell : turned_[static_cast<std::size_t>(place.turn)])
    sum += coarse_.at(place.level, cell.x() + place.x, cell.y() + place.y);
  return sum;
}

template <class IsAllowed>
WindowMatcher::Place WindowMatcher::search(int least, const IsAllowed& is_allowed) const {
  constexpr int kTop = ScoreRaster::kLevels - 1;
  std::vector<Place> places;
  for (int turn = 0; turn < static_cast<int>(turned_.size()); ++turn) {
    for (int y = -reach_; y <= reach_; y += 1 << kTop) {
      for (int x = -reach_; x <= reach_; x += 1 << kTop) {
        Place place{turn, x, y, kTop, 0};
        place.sum = sum(place);
        if (place.sum > least) places.push_back(place);
      }
    }
  }
  std::ranges::stable_sort(places, std::greater{}, &Place::sum);
  Place best{-1, 0, 0, 0, least};
  for (const Place& place : places) descend(place, best, is_allowed);
  return best;
}

template <class IsAllowed>
void WindowMatcher::descend(const Place& place, Place& best, const IsAllowed& is_allowed) const {
  if (place.sum <= best.sum) return;
  if (place.level == 0) {
    if (std::abs(place.x) <= reach_ && std::abs(place.y) <= reach_ && is_allowed(place)) best = place;
    return;
  }
  const int half = 1 << (place.level - 1);
  std::array<Place, 4> parts{};
  for (int i = 0; i < 4; ++i) {
    Place& part = parts[static_cast<std::size_t>(i)];
    part = {place.turn, place.x + (i % 2) * half, place.y + (i / 2) * half, place.level - 1, 0};
    part.sum = sum(part);
  }
  std::ranges::stable_sort(parts, std::greater{}, &Place::sum);
  for (const Place& part : parts) descend(part, best, is_allowed);
}

/// Adds what the points score at the places about `at`, with `turn` added: whole cells apart, and parts of a cell.
template <int kShifts, int kParts>
void WindowMatcher::score_around(const Eigen::Vector3d& at, double turn, std::vector<ScoredShift>& scores) const {
  const auto c = static_cast<float>(std::cos(at.z() + turn) / ScoreRaster::kCell);
  const auto s = static_cast<float>(std::sin(at.z() + turn) / ScoreRaster::kCell);
  constexpr int kMiddle = kParts / 2;
  for (int part_y = -kMiddle; part_y <= kMiddle; ++part_y) {
    for (int part_x = -kMiddle; part_x <= kMiddle; ++part_x) {
      const Eigen::Vector2d part = ScoreRaster::kCell / kParts * Eigen::Vector2d(part_x, part_y);
      const float x = fine_.in_cells(at.x() + part.x());
      const float y = fine_.in_cells(at.y() + part.y());
      ShiftedSums<kShifts> sums;
      for (const Eigen::Vector2f& p : points_)
        fine_.add_shifted(c * p.x() - s * p.y() + x, s * p.x() + c * p.y() + y, sums);
      for (int row = 0; row < sums.kSide; ++row) {
        for (int column = 0; column < sums.kSide; ++column) {
          const Eigen::Vector2d shift = part + ScoreRaster::kCell * Eigen::Vector2d(column - kShifts, row - kShifts);
          scores.push_back({{shift.x(), shift.y(), turn},
                            static_cast<double>(sums.at(row, column)) / static_cast<double>(255 * points_.size())});
        }
      }
    }
  }
}

/// Mean and covariance of exp(kSharpness · score). Returns the best score.
double WindowMatcher::moments(std::span<const ScoredShift> scores, Eigen::Vector3d& mean, Eigen::Matrix3d& P) {
  const double most = std::ranges::max_element(scores, {}, &ScoredShift::score)->score;
  double total = 0.0;
  mean.setZero();
  P.setZero();
  for (const auto& [shift, score] : scores) {
    const double weight = std::exp(kSharpness * (score - most));
    total += weight;
    mean += weight * shift;
    P += weight * shift * shift.transpose();
  }
  mean /= total;
  P = P / total - mean * mean.transpose();
  return most;
}

/// Two grids of places: the first shows how long the match is along a corridor, the second where its middle is.
WindowMatch WindowMatcher::refine(const Eigen::Vector3d& around, double weak_sigma) const {
  constexpr int kTurns = 5;            // to both sides
  constexpr double kWideTurn = 0.005;  // [rad]
  constexpr double kNarrowTurn = 0.002;
  WindowMatch match{{around, Eigen::Matrix3d::Zero()}, 0.0};
  std::vector<ScoredShift> scores;
  scores.reserve(2500);
  for (int turn = -kTurns; turn <= kTurns; ++turn) score_around<7, 1>(around, turn * kWideTurn, scores);
  Eigen::Vector3d mean;
  moments(scores, mean, match.relation.P);
  const Eigen::Vector3d middle = around + mean;
  scores.clear();
  for (int turn = -kTurns; turn <= kTurns; ++turn) score_around<1, 3>(middle, turn * kNarrowTurn, scores);
  Eigen::Matrix3d narrow;
  match.score = moments(scores, mean, narrow);
  match.relation.z = middle + mean;
  match.relation.z.z() = so3::wrap(match.relation.z.z());
  open_weak_direction(match.relation.P, weak_sigma);
  match.relation.P.diagonal() += Eigen::Vector3d(kFloor, kFloor, kTurnFloor).cwiseAbs2();
  return match;
}

}  // namespace waymark::loops
