// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/innovations.hpp"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "waymark/base/error.hpp"
#include "waymark/math/gaussian.hpp"

namespace waymark::evaluation {

std::vector<InnovationScore> read_innovations(const std::filesystem::path& diagnostics) {
  std::ifstream in(diagnostics);
  if (!in) throw DataError(fmt::format("{}: cannot be read", diagnostics.string()));
  std::vector<InnovationScore> out;
  try {
    const auto document = nlohmann::json::parse(in);
    for (const auto& sensor : document.at("sensors")) {
      InnovationScore one;
      one.sensor = sensor.at("name").get<std::string>();
      one.updates = sensor.at("nis_count").get<std::uint64_t>();
      one.dof = sensor.at("nis_dof").get<std::uint64_t>();
      if (one.updates == 0 || one.dof == 0 || sensor.at("mean_nis").is_null()) continue;
      const auto updates = static_cast<double>(one.updates);
      one.mean = sensor.at("mean_nis").get<double>();
      one.expected = static_cast<double>(one.dof) / updates;
      one.low = gaussian::chi_squared_quantile(0.025, static_cast<int>(one.dof)) / updates;
      one.high = gaussian::chi_squared_quantile(0.975, static_cast<int>(one.dof)) / updates;
      out.push_back(std::move(one));
    }
  } catch (const nlohmann::json::exception& error) {
    throw DataError(
        fmt::format("{}: not the file of a diagnostics sink of this version: {}", diagnostics.string(), error.what()));
  }
  return out;
}

}  // namespace waymark::evaluation
