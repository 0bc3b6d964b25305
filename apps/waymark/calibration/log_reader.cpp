// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/log_reader.hpp"

#include <fmt/format.h>

#include "waymark/base/error.hpp"

namespace waymark::calibration {

LogReader::LogReader(const std::filesystem::path& yaml, const std::vector<Config::Override>& overrides,
                     std::optional<double> until_s)
    : robot_(host::Robot::load(yaml, overrides)), until_s_(until_s) {
  if (robot_.source == nullptr || robot_.live_input != nullptr)
    throw Error(fmt::format("{}: calibration needs a log", yaml.string()));
}

std::optional<Measurement> LogReader::next() {
  while (std::optional<Measurement> m = robot_.source->next()) {
    m->sequence = number_++;
    if (!first_) first_ = m->arrival;
    if (until_s_ && to_seconds(m->arrival - *first_) > *until_s_) break;
    if (robot_.assign(*m)) return m;
  }
  return std::nullopt;
}

}  // namespace waymark::calibration
