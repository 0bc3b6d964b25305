// SPDX-License-Identifier: Apache-2.0
#include "windows.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace waymark::simulator {

Windows::Windows(const Config& config, const Config::Key& key) {
  const std::vector<double> times = config.numbers(key, -1, {});
  if (times.size() % 2 != 0) {
    config.fail(key.name, fmt::format("{} numbers; begin and end of each window are expected", times.size()));
  }
  for (std::size_t i = 0; i < times.size(); i += 2) {
    if (!(times[i] >= 0.0 && times[i] < times[i + 1] && times[i + 1] < 1e9)) {
      config.fail(key.name, fmt::format("from {} to {} s; 0 <= begin < end is expected", times[i], times[i + 1]));
    }
    spans_.emplace_back(from_seconds(times[i]), from_seconds(times[i + 1]));
  }
}

std::optional<Duration> Windows::begin(Duration time) const {
  const auto span =
      std::ranges::find_if(spans_, [&](const auto& one) { return one.first <= time && time < one.second; });
  return span == spans_.end() ? std::nullopt : std::optional(span->first);
}

}  // namespace waymark::simulator
