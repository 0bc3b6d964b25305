// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <variant>

#include "waymark/interface/measurement.hpp"

namespace waymark {
namespace {

/// Checks every field against its `FieldInfo`; stores the first violation.
class FieldCheck final : public FieldVisitor {
 public:
  void field(const FieldInfo& info, const FieldValue& value) override {
    if (!problem_.empty()) return;
    if (const auto* numbers = std::get_if<std::span<const double>>(&value)) {
      check_numbers(info, *numbers);
    } else if (const auto* list = std::get_if<std::span<const float>>(&value)) {
      const bool finite = std::ranges::all_of(*list, [](float v) { return std::isfinite(v); });
      if (info.unknown.empty() && !finite) problem_ = fmt::format("a value of {} is not finite", info.name());
    } else if (const auto* points = std::get_if<std::span<const Eigen::Vector3f>>(&value)) {
      const bool finite = std::ranges::all_of(*points, [](const Eigen::Vector3f& p) { return p.allFinite(); });
      if (!finite) problem_ = fmt::format("a point of {} is not finite", info.name());
    }
  }

  std::string take() { return std::move(problem_); }

 private:
  void check_numbers(const FieldInfo& info, std::span<const double> numbers) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const double v = numbers[i];
      const bool is_marked_unknown = std::isnan(v) && !info.unknown.empty();
      if (!std::isfinite(v) && !is_marked_unknown) {
        problem_ = fmt::format("{} is not finite", info.names[i]);
      } else if (info.limit > 0.0 && std::abs(v) > info.limit) {
        problem_ = fmt::format("{} is beyond ±{}", info.names[i], info.limit);
      }
      if (!problem_.empty()) return;
    }
  }

  std::string problem_;
};

}  // namespace

std::string Payload::problem() const {
  FieldCheck check;
  visit(check);
  std::string problem = check.take();
  return problem.empty() ? std::string(broken_rule()) : problem;
}

}  // namespace waymark
