// SPDX-License-Identifier: Apache-2.0
#include "path_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fit.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::host::diagnosis {

namespace {

using Complex = std::complex<double>;

constexpr double kBlock = 40.0;   // [s] in which dead reckoning bends little
constexpr double kThinned = 0.9;  // [s] from fix to fix
constexpr std::size_t kLeastFixes = 15;
constexpr std::size_t kLeastBlocks = 4;
constexpr double kLeastScale = 0.7;  // of a way by that of the fixes: other ones are found elsewhere
constexpr double kMostScale = 1.4;
constexpr double kFloor = 0.1;  // [m] of what is left: less proves nothing
constexpr double kSame = 0.3;   // of the size of a block: so much may be left where the path is the same
constexpr double kAlike = 0.1;  // the same, where turns cannot be off by a fifth
constexpr double kAlikeSigmas = 2.0;
constexpr double kBetter = 0.7;  // of the logarithm of what is left, as a mean over the blocks
constexpr double kSigmas = 4.0;
constexpr double kLeastSigma = 0.5 * std::numbers::pi / 180.0;  // [rad], of a direction
constexpr double kFarthest = 30.0;                              // [s]
constexpr double kStep = 0.5;                                   // [s]
constexpr double kFineStep = 0.1;                               // [s]
constexpr int kFineSteps = 15;
constexpr double kFarthestAntenna = 6.0;  // [m] from where the base is
constexpr double kLikelier = 0.1;         // by which a delay has to fit better than another place of the antenna
constexpr double kNear = 1.9;  // [s]: smaller delays, or antennas that stand elsewhere, are found by lever_fit.cpp

std::vector<Fix> thinned(const std::vector<Fix>& fixes) {
  std::vector<Fix> out;
  for (const Fix& fix : fixes) {
    if (out.empty() || fix.t - out.back().t >= kThinned) out.push_back(fix);
  }
  return out;
}

/// Stretches of fixes within which the path is known.
std::vector<PathFit::Block> blocks_of(const std::vector<Fix>& fixes, const DeadReckoning& path) {
  std::vector<PathFit::Block> blocks;
  auto begin = fixes.begin();
  for (auto fix = fixes.begin(); fix != fixes.end(); ++fix) {
    const bool is_known = path.step(begin->t, fix->t).has_value();
    if (is_known && fix->t - begin->t < kBlock && fix + 1 != fixes.end()) continue;
    if (fix - begin >= static_cast<std::ptrdiff_t>(kLeastFixes)) blocks.emplace_back(begin, fix);
    begin = fix;
  }
  return blocks;
}

Complex antenna_of(const WatchedSensor& receiver) {
  const Eigen::Vector2d lever = receiver.usual.p_base_point.head<2>();
  return lever.allFinite() ? Complex(lever.x(), lever.y()) : Complex();
}

}  // namespace

bool PathFit::OfBlock::is_same() const { return mean_square < kSame * kSame * size * size; }

bool PathFit::Gain::is_clear() const {
  return blocks >= kLeastBlocks && mean > kBetter && sigmas > kSigmas && left < kSame;
}

PathFit::PathFit(const WatchedSensor& receiver, const Track& yaw, const Way& way, WayOf of)
    : yaw_(yaw),
      way_(way),
      way_of_(of),
      path_(yaw, way, 0.0, 0.0, 0.0),
      fixes_(thinned(receiver.fixes)),
      blocks_(blocks_of(fixes_, path_)),
      antenna_(antenna_of(receiver)) {
  for (const Block& block : blocks_) as_given_.push_back(fit(path_, block, 0.0, false));
}

bool PathFit::is_known() const { return blocks_.size() >= kLeastBlocks; }

/// Dead reckoning if the fixes are behind it by so much [s].
DeadReckoning PathFit::path_if(double late) const {
  return way_of_ == WayOf::receiver && late != 0.0 ? DeadReckoning(yaw_, way_, 0.0, 0.0, late) : path_;
}

/// `late`: by so much the fixes are behind dead reckoning [s].
std::optional<PathFit::OfBlock> PathFit::fit(const DeadReckoning& path, const Block& block, double late,
                                             bool is_mirrored) const {
  Complex sum_z;
  Complex sum_w;
  double zz = 0.0;
  double ww = 0.0;
  Complex wz;
  double n = 0.0;
  const double first = block.first->t - late;
  for (auto fix = block.first; fix != block.second; ++fix) {
    const auto step = path.step(first, fix->t - late);
    if (!step) return std::nullopt;
    const Eigen::Vector2d moved = fix->p - block.first->p;
    const Complex z(moved.x(), is_mirrored ? -moved.y() : moved.y());
    const Complex w = step->second.p - step->first.p + antenna_ * std::polar(1.0, step->second.yaw);
    sum_z += z;
    sum_w += w;
    zz += std::norm(z);
    ww += std::norm(w);
    wz += std::conj(w) * z;
    n += 1.0;
  }
  zz -= std::norm(sum_z) / n;
  ww -= std::norm(sum_w) / n;
  wz -= std::conj(sum_w) * sum_z / n;
  if (!(ww > 0.0) || std::abs(wz) == 0.0) return std::nullopt;
  const double scale = std::clamp(std::abs(wz) / ww, kLeastScale, kMostScale);
  OfBlock found;
  found.turn = scale * wz / std::abs(wz);
  found.mean_square = std::max(zz - 2.0 * scale * std::abs(wz) + scale * scale * ww, 0.0) / n;
  found.size = std::sqrt(zz / n);
  return found;
}

PathFit::Gain PathFit::gain(double late, bool is_mirrored) const {
  std::vector<std::optional<OfBlock>> others;
  others.reserve(blocks_.size());
  const DeadReckoning path = path_if(late);
  for (const Block& block : blocks_) others.push_back(fit(path, block, late, is_mirrored));
  return gain_of(others, as_given_);
}

PathFit::Gain PathFit::gain_over(const PathFit& other) const { return gain_of(as_given_, other.as_given_); }

PathFit::Gain PathFit::gain_of(const std::vector<std::optional<OfBlock>>& ours,
                               const std::vector<std::optional<OfBlock>>& theirs) {
  std::vector<double> gains;
  std::vector<double> left;
  for (std::size_t k = 0; k < ours.size(); ++k) {
    const auto& one = ours[k];
    const auto& other = theirs[k];
    if (!one || !other || one->size < kFloor) continue;
    gains.push_back(std::log((other->mean_square + kFloor * kFloor) / (one->mean_square + kFloor * kFloor)));
    left.push_back(std::sqrt(one->mean_square) / one->size);
  }
  Gain result;
  result.blocks = gains.size();
  if (result.blocks < kLeastBlocks) return result;
  const auto n = static_cast<double>(gains.size());
  for (const double one : gains) result.mean += one / n;
  double squares = 0.0;
  for (const double one : gains) squares += (one - result.mean) * (one - result.mean);
  result.sigmas = result.mean / std::max(std::sqrt(squares / (n * (n - 1.0))), 1e-3);
  result.left = median(left);
  return result;
}

std::optional<double> PathFit::left_with_antenna(const Block& block) const {
  using Vector3 = Eigen::Vector3cd;
  Vector3 sum = Vector3::Zero();
  Eigen::Matrix3cd products = Eigen::Matrix3cd::Zero();
  double n = 0.0;
  for (auto fix = block.first; fix != block.second; ++fix) {
    const auto step = path_.step(block.first->t, fix->t);
    if (!step) return std::nullopt;
    const Eigen::Vector2d moved = fix->p - block.first->p;
    const Vector3 row(Complex(moved.x(), moved.y()), step->second.p - step->first.p, std::polar(1.0, step->second.yaw));
    sum += row;
    products += row.conjugate() * row.transpose();
    n += 1.0;
  }
  products -= sum.conjugate() * sum.transpose() / n;
  // z = c w + q u: the way turned, and the antenna turned with the robot.
  const Eigen::Matrix2cd A = products.bottomRightCorner<2, 2>();
  const Eigen::Vector2cd b = products.block<2, 1>(1, 0);
  const Eigen::Vector2cd x = A.ldlt().solve(b);
  if (!x.allFinite() || !(std::abs(x(0)) > kLeastScale) || !(std::abs(x(1) / x(0)) < kFarthestAntenna))
    return std::nullopt;
  return std::max((products(0, 0) - b.dot(x)).real(), 0.0) / n;
}

double PathFit::gain_of_antenna() const {
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t k = 0; k < blocks_.size(); ++k) {
    const auto& as_given = as_given_[k];
    if (!as_given) continue;
    const auto left = left_with_antenna(blocks_[k]);
    if (left) sum += std::log((as_given->mean_square + kFloor * kFloor) / (*left + kFloor * kFloor));
    count += 1.0;
  }
  return count > 0.0 ? sum / count : 0.0;
}

std::optional<Lag> PathFit::late() const {
  Gain best;
  double late = 0.0;
  for (double tried = -kFarthest; tried <= kFarthest; tried += kStep) {
    const Gain one = gain(tried, false);
    // Positions that are far off in time cover less of the path.
    if (one.blocks < kLeastBlocks || 2 * one.blocks < blocks_.size() || one.mean <= best.mean) continue;
    best = one;
    late = tried;
  }
  if (std::abs(late) < kNear || !best.is_clear() || best.mean < gain_of_antenna() + kLikelier) return std::nullopt;
  std::vector<std::vector<double>> costs(blocks_.size());
  for (int k = -kFineSteps; k <= kFineSteps; ++k) {
    const DeadReckoning path = path_if(late + k * kFineStep);
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      const auto found = fit(path, blocks_[b], late + k * kFineStep, false);
      if (found) costs[b].push_back(std::log(found->mean_square + kFloor * kFloor));
    }
  }
  std::erase_if(costs, [](const auto& of_block) { return of_block.size() < 2 * kFineSteps + 1; });
  Lag lag = lag_of(costs, kFineStep);
  if (!lag.is_known) return std::nullopt;
  lag.value += late;
  return lag;
}

bool PathFit::turns_alike() const {
  if (!is_known()) return false;
  const Gain as_given = gain(0.0, false);
  const Gain other_side = mirrored();
  return as_given.blocks >= kLeastBlocks && as_given.left < kAlike && other_side.mean < -kBetter &&
         other_side.sigmas < -kAlikeSigmas;
}

std::optional<Angle> PathFit::beside(const Track& heading) const {
  std::vector<double> angles;
  Complex directions;
  for (std::size_t k = 0; k < blocks_.size(); ++k) {
    const auto& found = as_given_[k];
    if (!found || !found->is_same()) continue;
    const Block& block = blocks_[k];
    Complex sum;
    bool is_whole = true;
    for (auto fix = block.first; fix != block.second && is_whole; ++fix) {
      const auto step = path_.step(block.first->t, fix->t);
      const auto yaw = heading.at(fix->t);
      is_whole = step && yaw;
      if (is_whole) sum += std::polar(1.0, step->second.yaw - *yaw);
    }
    if (!is_whole) continue;
    angles.push_back(std::arg(found->turn) + std::arg(sum));
    directions += std::polar(1.0, angles.back());
  }
  const auto n = static_cast<double>(angles.size());
  if (angles.size() < kLeastBlocks || std::abs(directions) < 0.5 * n) return std::nullopt;
  const double middle = std::arg(directions);
  double squares = 0.0;
  for (const double angle : angles) squares += std::pow(so3::wrap(angle - middle), 2);
  return Angle{middle, std::max(std::sqrt(squares / (n * (n - 1.0))), kLeastSigma)};
}

}  // namespace waymark::host::diagnosis
