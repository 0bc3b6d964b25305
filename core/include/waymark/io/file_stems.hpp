// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "waymark/base/api.hpp"

namespace waymark {

/// File name of the effective configuration of a run, among its results.
inline constexpr std::string_view kEffectiveConfigFile = "config.yaml";

/// File name of the manifest of the maps of a run, which names their files. Not `map.yaml`, which grids of map_server
/// often have.
inline constexpr std::string_view kMapManifestFile = "maps.yaml";

/// File names without extension, valid on any system, for names of the YAML (of sensors, of maps). Characters other
/// than letters, digits, `_` and `-` become `_`. A name that would be equal to an earlier or taken one gets a number.
class WAYMARK_API FileStems {
 public:
  explicit FileStems(std::set<std::string> taken) : taken_(std::move(taken)) {}
  /// For files among the results of a run, which writes the effective configuration and the manifest itself.
  static FileStems of_results();
  std::string of(const std::string& name);

 private:
  std::set<std::string> taken_;
};

}  // namespace waymark
