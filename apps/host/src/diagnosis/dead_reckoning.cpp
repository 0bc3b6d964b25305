// SPDX-License-Identifier: Apache-2.0
#include "dead_reckoning.hpp"

namespace waymark::host::diagnosis {

DeadReckoning::DeadReckoning(const Track& yaw, const Way& way, double per_way, double per_s, double late) {
  points_.assign(Track::kEdges, {});
  stretch_.assign(Track::kEdges, 0);
  int stretch = 1;
  std::complex<double> p;
  double turned = 0.0;
  for (int k = 1; k < Track::kEdges; ++k) {
    const auto edge = static_cast<std::size_t>(k);
    const auto turn = yaw.change((k - 1) * Track::kStep, k * Track::kStep);
    const auto driven = way.forwards.change((k - 1) * Track::kStep + late, k * Track::kStep + late);
    // Before its first motion to the left a sensor may not give any.
    const auto left = way.left != nullptr ? way.left->change((k - 1) * Track::kStep + late, k * Track::kStep + late)
                                          : std::optional<double>();
    if (!turn || !driven) {
      ++stretch;
      continue;
    }
    const double corrected = *turn - per_way * *driven - per_s * Track::kStep;
    p += std::complex<double>(*driven, way.left_scale * left.value_or(0.0)) * std::polar(1.0, turned + 0.5 * corrected);
    turned += corrected;
    points_[edge] = {p, turned};
    stretch_[edge] = stretch;
  }
}

std::optional<std::pair<DeadReckoning::Point, DeadReckoning::Point>> DeadReckoning::step(double from, double to) const {
  const auto a = at(from);
  const auto b = at(to);
  if (!a || !b || stretch_[index(from)] != stretch_[index(to)]) return std::nullopt;
  return std::pair(*a, *b);
}

std::optional<DeadReckoning::Point> DeadReckoning::at(double t) const {
  if (!(t >= Track::kStep) || t >= Track::kLength - Track::kStep) return std::nullopt;
  const std::size_t k = index(t);
  if (stretch_[k] == 0 || stretch_[k] != stretch_[k + 1]) return std::nullopt;
  const double part = t / Track::kStep - static_cast<double>(k);
  return Point{points_[k].p + part * (points_[k + 1].p - points_[k].p),
               points_[k].yaw + part * (points_[k + 1].yaw - points_[k].yaw)};
}

}  // namespace waymark::host::diagnosis
