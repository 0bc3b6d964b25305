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

FieldFit FieldSums::fit(double resolution) const {
  FieldFit fit;
  fit.log_likelihood = log_likelihood + std::log(product);
  fit.JtJ << xx, xy, xt, xy, yy, yt, xt, yt, tt;
  fit.Jtr << rx, ry, rt;
  const Eigen::Vector3d per_unit(1.0 / resolution, 1.0 / resolution, 1.0);
  fit.JtJ = per_unit.asDiagonal() * fit.JtJ * per_unit.asDiagonal();
  fit.Jtr = per_unit.asDiagonal() * fit.Jtr;
  fit.score = points == 0 ? 0.0 : sum / static_cast<double>(points);
  return fit;
}

}  // namespace waymark::scan_matching
