// SPDX-License-Identifier: Apache-2.0
#include "gap_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

namespace waymark::host {
namespace {

constexpr std::size_t kMostSteps = 64;
constexpr std::size_t kFewestSteps = 10;  // from which on a period is known
constexpr int kComputeEvery = 8;
constexpr double kUsualFrom = 0.5;  // of the period
constexpr double kUsualTo = 1.5;
constexpr double kSteadyShare = 0.9;
constexpr double kGapPeriods = 5.0;
constexpr int kUsualAfterGap = 5;
constexpr double kQuietAfterGap = 1.0;  // [s]
/// A period that was not found again until then is another one now.
constexpr double kLongestSuspicion = 10.0;  // [s]
constexpr double kLongestSuspicionPeriods = 20.0;
constexpr double kFewestMissing = 4.0;
/// The period is not known better than so, in relation to it.
constexpr double kPeriodAccuracy = 0.02;
/// Stamps that lie further back are not only out of order.
constexpr double kBack = 2.0;  // [s]

}  // namespace

std::string describe(const Gap& gap) {
  const std::string what =
      gap.count == 1 ? fmt::format("no measurement for {:.3g} s", gap.longest_s)
                     : fmt::format("{} gaps, the longest of {:.3g} s without a measurement", gap.count, gap.longest_s);
  return fmt::format("{} (period {:.3g} s): some {} missing", what, gap.period_s, gap.missing);
}

void GapWatch::break_off() {
  newest_.reset();
  suspicion_.reset();
}

bool GapWatch::is_usual(double step_s) const {
  return step_s >= kUsualFrom * period_s_ && step_s <= kUsualTo * period_s_;
}

bool GapWatch::is_gap(double step_s) const { return step_s > kGapPeriods * period_s_; }

void GapWatch::learn(double step_s) {
  steps_.push_back(step_s);
  if (steps_.size() > kMostSteps) steps_.pop_front();
  ++unlearned_;
  if (steps_.size() < kFewestSteps || (steps_.size() == kMostSteps && unlearned_ < kComputeEvery)) return;
  unlearned_ = 0;
  std::array<double, kMostSteps> sorted{};
  const auto end = std::ranges::copy(steps_, sorted.begin()).out;
  const auto middle = sorted.begin() + std::ssize(steps_) / 2;
  std::nth_element(sorted.begin(), middle, end);
  period_s_ = *middle;
  double sum = 0.0;
  double usual = 0.0;
  for (const double step : steps_) {
    if (!is_usual(step)) continue;
    sum += step;
    ++usual;
  }
  is_steady_ = usual >= kSteadyShare * static_cast<double>(steps_.size());
  period_s_ = sum / usual;  // the median is usual
}

std::optional<Gap> GapWatch::add(Time stamp, Duration offset, std::optional<Duration> best_offset) {
  if (!is_stamp(stamp)) return std::nullopt;
  if (!newest_ || to_seconds(*newest_ - stamp) > kBack) {
    break_off();
    newest_ = stamp;
    return std::nullopt;
  }
  const double step_s = to_seconds(stamp - *newest_);
  if (step_s <= 0.0) {
    if (suspicion_) ++suspicion_->since;
    return std::nullopt;
  }
  const Time before = std::exchange(newest_, stamp).value();
  const bool may_be_gap = is_steady_ && is_gap(step_s);
  if (may_be_gap && (!best_offset || to_seconds(offset) > to_seconds(*best_offset) + 0.5 * step_s)) {
    suspicion_.reset();
    return std::nullopt;
  }
  if (suspicion_) return follow(stamp, step_s);
  if (may_be_gap) {
    suspicion_ = {
        .begin = before, .end = stamp, .first_end = stamp, .longest_s = step_s, .gaps = 1, .since = 1, .unusual = 1};
    return std::nullopt;
  }
  learn(step_s);
  return std::nullopt;
}

std::optional<Gap> GapWatch::follow(Time stamp, double step_s) {
  Suspicion& s = *suspicion_;
  ++s.since;
  if (is_usual(step_s)) {
    ++s.usual;
    ++s.usual_in_row;
  } else {
    s.usual_in_row = 0;
    if (step_s > kUsualTo * period_s_) ++s.unusual;
  }
  if (is_gap(step_s)) {
    ++s.gaps;
    s.end = stamp;
    s.longest_s = std::max(s.longest_s, step_s);
  }
  const bool is_over = s.usual_in_row >= kUsualAfterGap && to_seconds(stamp - s.end) >= kQuietAfterGap;
  const double longest_s = std::max(kLongestSuspicion, kLongestSuspicionPeriods * period_s_);
  if (!is_over && to_seconds(stamp - s.first_end) < longest_s) return std::nullopt;
  if (!is_over && s.usual < s.unusual) {
    steps_.clear();
    is_steady_ = false;
    suspicion_.reset();
    return std::nullopt;
  }
  return conclude();
}

std::optional<Gap> GapWatch::conclude() {
  const Suspicion s = *std::exchange(suspicion_, std::nullopt);
  const double expected = to_seconds(*newest_ - s.begin) / period_s_;
  const double missing = std::round(expected - static_cast<double>(s.since));
  const Gap gap{s.longest_s, period_s_, missing > 0.0 ? static_cast<std::uint64_t>(missing) : 0, s.gaps};
  learn(s.longest_s);  // a sensor that pauses again and again has no steady period
  if (missing < std::max(kFewestMissing, kPeriodAccuracy * expected)) return std::nullopt;
  missing_ += gap.missing;
  return gap;
}

}  // namespace waymark::host
