// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/report_of_fields.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <numbers>

namespace waymark::calibration {

namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

std::string hard_list(const Eigen::Vector3d& h) { return fmt::format("[{:.3g}, {:.3g}, {:.3g}]", h.x(), h.y(), h.z()); }

std::string soft_list(const Eigen::Matrix3d& A) {
  std::vector<std::string> numbers;
  numbers.reserve(9);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) numbers.push_back(fmt::format("{:.4f}", A(i, j)));
  }
  return fmt::format("[{}]", fmt::join(numbers, ", "));
}

/// What of z the drive left open.
const char* not_excited(const Magnetometer& magnetometer) {
  return magnetometer.iron.axes == 3 ? "" : "; up and down was not excited";
}

}  // namespace

std::string summary(const Magnetometer& m) {
  const std::string round =
      m.iron.axes == 3 ? std::string("in all attitudes")
                       : fmt::format("level, {:.0f}° of headings at most without a reading", m.iron.gap_rad * kDegrees);
  return fmt::format(
      "{}: {} readings of the field, {}; its strength varies by {:.1f} % as given, by {:.1f} % afterwards{}\n",
      m.sensor, m.readings, round, 100.0 * m.given_scatter, 100.0 * m.iron.scatter,
      m.is_determined() ? "" : ": hard and soft iron are not determined by this drive");
}

std::string yaml_lines(const Magnetometer& m) {
  if (!m.is_determined()) return {};
  const char* start = m.has_keys ? "    " : "    # its plugin has no key for it: ";
  return fmt::format("{}{}: {}  # ± {:.2g} T, was {}{}\n{}{}: {}  # ± {:.2g}, was {}{}\n", start, kHardIron,
                     hard_list(m.hard), m.hard_sigma.maxCoeff(), hard_list(m.given_hard), not_excited(m), start,
                     kSoftIron, soft_list(m.soft), m.iron.soft_sigma,
                     m.given_soft.isIdentity() ? std::string("none") : soft_list(m.given_soft), not_excited(m));
}

std::vector<Config::Override> overrides(const Magnetometer& m) {
  if (!m.is_determined() || !m.has_keys) return {};
  return {fmt::format("sensors.{}.{}={}", m.sensor, kHardIron, hard_list(m.hard)),
          fmt::format("sensors.{}.{}={}", m.sensor, kSoftIron, soft_list(m.soft))};
}

std::vector<IronElement> elements(const Magnetometer& m) {
  std::vector<IronElement> all;
  all.reserve(12);
  for (int i = 0; i < 3; ++i) {
    // An axis that stands upright has no σ: the drive says nothing of it.
    const bool is_determined = m.is_determined() && m.hard_sigma(i) > 0.0;
    all.push_back({fmt::format("{}.{}[{}]", m.sensor, kHardIron, i), "T", m.given_hard(i), m.hard(i), m.hard_sigma(i),
                   is_determined});
  }
  for (int i = 0; i < 9; ++i) {
    all.push_back({fmt::format("{}.{}[{}]", m.sensor, kSoftIron, i), "", m.given_soft(i / 3, i % 3),
                   m.soft(i / 3, i % 3), m.iron.soft_sigma, m.is_determined()});
  }
  return all;
}

}  // namespace waymark::calibration
