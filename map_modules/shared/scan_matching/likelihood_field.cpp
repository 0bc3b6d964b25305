// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/likelihood_field.hpp"

#include <algorithm>
#include <cmath>

namespace waymark::scan_matching {

LikelihoodTable::LikelihoodTable(double sigma, double resolution) {
  for (std::size_t i = 0; i < values_.size(); ++i) {
    const double cells =
        std::min(static_cast<double>(i) / StoredDistance::kSteps, static_cast<double>(StoredDistance::kReach));
    values_[i] = static_cast<float>(std::exp(-0.5 * std::pow(cells * resolution / sigma, 2)));
  }
}

void PointBlock::add_to(FieldSums& sums) {
  // More factors of 0.1 than this in one product come near the smallest double.
  constexpr int kBlocks = 8;
  for (Eigen::Index i = size_; i < kPoints; ++i) l00_[i] = l10_[i] = l01_[i] = l11_[i] = 0.0f;
  const Values across = l10_ - l00_;
  const Values bottom = l00_ + fx_ * across;
  const Values top = l01_ + fx_ * (l11_ - l01_);
  const Values likelihood = bottom + fy_ * (top - bottom);
  const Values gx = across + fy_ * ((l11_ - l01_) - across);  // per cell
  const Values gy = top - bottom;
  const Values gt = gy * qx_ - gx * qy_;
  const Values rest = 1.0f - likelihood;
  const auto add = [](double& sum, const auto& values) { sum += static_cast<double>(values.sum()); };
  add(sums.sum, likelihood);
  add(sums.xx, gx * gx);
  add(sums.xy, gx * gy);
  add(sums.yy, gy * gy);
  add(sums.xt, gx * gt);
  add(sums.yt, gy * gt);
  add(sums.tt, gt * gt);
  add(sums.rx, gx * rest);
  add(sums.ry, gy * rest);
  add(sums.rt, gt * rest);
  Values factors = 0.9f * likelihood + 0.1f;
  for (Eigen::Index i = size_; i < kPoints; ++i) factors[i] = 1.0f;
  sums.product *= static_cast<double>(factors.prod());
  if (++sums.blocks == kBlocks) {
    sums.log_likelihood += std::log(sums.product);
    sums.product = 1.0;
    sums.blocks = 0;
  }
  size_ = 0;
}

FieldFit FieldSums::fit(double resolution) const {
  FieldFit fit;
  const auto new_points = static_cast<double>(unknown);
  const double known_points = static_cast<double>(points) - new_points;
  fit.log_likelihood = log_likelihood + std::log(product) + new_points * std::log(0.1);
  fit.JtJ << xx, xy, xt, xy, yy, yt, xt, yt, tt;
  fit.Jtr << rx, ry, rt;
  const Eigen::Vector3d per_unit(1.0 / resolution, 1.0 / resolution, 1.0);
  fit.JtJ = per_unit.asDiagonal() * fit.JtJ * per_unit.asDiagonal();
  fit.Jtr = per_unit.asDiagonal() * fit.Jtr;
  fit.score = known_points > 0.0 ? sum / known_points : 0.0;
  fit.unknown = points > 0 ? new_points / static_cast<double>(points) : 0.0;
  return fit;
}

}  // namespace waymark::scan_matching
