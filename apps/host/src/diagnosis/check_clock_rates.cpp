// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "checks.hpp"

namespace waymark::host::diagnosis {

namespace {

constexpr double kSpan = 0.5;  // [s] of the spans over which lags are sought
constexpr double kSigmas = 5.0;
constexpr double kLeastGrowth = 0.15;    // [s], from the first third of the log to the last
constexpr double kLeastRate = 0.002;     // no clock that is synchronised now and then is so wrong
constexpr double kLinear = 0.25;         // of the growth: as far may the middle of the log be off
constexpr double kLeastDuration = 90.0;  // [s]

/// The lag of one sensor's turns against another's that grows.
struct Drift {
  std::size_t sensor;
  std::size_t against;
  double rate;
  double sigma;
  double first;
  double last;
};

std::vector<Span> part_of(const std::vector<Span>& spans, double from, double to) {
  std::vector<Span> part;
  std::ranges::copy_if(spans, std::back_inserter(part),
                       [&](const Span& span) { return span.from >= from && span.to <= to; });
  return part;
}

/// The sensors of which one is in every drift.
std::vector<std::size_t> suspects_of(const std::vector<Drift>& drifts) {
  std::vector<std::size_t> suspects;
  for (const std::size_t tried : {drifts.front().sensor, drifts.front().against}) {
    const bool explains = std::ranges::all_of(
        drifts, [&](const Drift& drift) { return drift.sensor == tried || drift.against == tried; });
    if (explains) suspects.push_back(tried);
  }
  return suspects;
}

}  // namespace

void check_clock_rates(Case& c, const Agreement& yaw) {
  const double end = c.watch.newest();
  if (end < kLeastDuration) return;
  std::vector<Drift> drifts;
  std::set<std::size_t> steady;  // in a pair that does not drift
  for (std::size_t i = 0; i < yaw.observers.size(); ++i) {
    const Observer& observer = yaw.observers[i];
    if (observer.kind == Observer::Kind::chord || is_field(c, observer)) continue;
    for (std::size_t j = 0; j < yaw.observers.size(); ++j) {
      const Observer& reference = yaw.observers[j];
      const bool is_done = observer.track != nullptr && j < i;
      if (reference.track == nullptr || observer.sensor == reference.sensor || is_done) continue;
      if (is_field(c, reference) || c.is_blamed(observer.sensor) || c.is_blamed(reference.sensor)) continue;
      const std::vector<Span> spans =
          observer.track != nullptr ? spans_of(*observer.track, kSpan, end) : observer.spans;
      const Lag first = find_lag(part_of(spans, 0.0, end / 3.0), *reference.track, 1.0);
      const Lag middle = find_lag(part_of(spans, end / 3.0, 2.0 * end / 3.0), *reference.track, 1.0);
      const Lag last = find_lag(part_of(spans, 2.0 * end / 3.0, end), *reference.track, 1.0);
      if (!first.is_known || !middle.is_known || !last.is_known) continue;
      const double growth = last.value - first.value;
      const double sigma = std::hypot(first.sigma, last.sigma);
      const double bent = middle.value - 0.5 * (first.value + last.value);
      const double rate = growth / (2.0 * end / 3.0);
      const bool grows = std::abs(growth) > kLeastGrowth + kSigmas * sigma && std::abs(rate) > kLeastRate;
      if (grows && std::abs(bent) < kLinear * std::abs(growth) + 3.0 * middle.sigma) {
        drifts.push_back({observer.sensor, reference.sensor, rate, sigma / (2.0 * end / 3.0), first.value, last.value});
      } else if (!grows && std::abs(growth) < kLeastGrowth) {
        steady.insert({observer.sensor, reference.sensor});
      }
    }
  }
  if (drifts.empty()) return;
  std::vector<std::size_t> suspects = suspects_of(drifts);
  if (suspects.empty()) return;
  // What agrees with a third sensor all the time is not the one.
  if (suspects.size() == 2 && steady.contains(suspects[0]) != steady.contains(suspects[1]))
    suspects = {steady.contains(suspects[0]) ? suspects[1] : suspects[0]};
  const Drift& drift = *std::ranges::min_element(drifts, {}, &Drift::sigma);
  const bool is_own = drift.sensor == suspects.front();
  const std::string& other = c.sensor(is_own ? drift.against : drift.sensor).name;
  const double sign = is_own ? 1.0 : -1.0;
  const bool is_open = suspects.size() > 1;
  const std::string& name = c.sensor(suspects.front()).name;
  c.add(is_open ? Finding::Certainty::one_of : Finding::Certainty::named, "clock", suspects,
        fmt::format("{}its stamps are {:.2f} s behind those of {} at the begin and {:.2f} s at the end: its clock is "
                    "{:.2f} ± {:.2f} % {}",
                    is_open ? name + ": " : "", sign * drift.first, other, sign * drift.last,
                    100.0 * std::abs(drift.rate), 100.0 * drift.sigma, sign * drift.rate > 0.0 ? "fast" : "slow"),
        fmt::format("source: stamps of {}: by the clock of the computer, or synchronise the clocks", name),
        std::abs(drift.rate) / drift.sigma);
}

}  // namespace waymark::host::diagnosis
