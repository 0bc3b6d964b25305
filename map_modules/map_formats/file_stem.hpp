// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>

namespace waymark::map_formats {

/// What maps are called in the YAML, as file names without extension: characters other than letters, digits, `_` and
/// `-` become `_`. Names that would become the same get a number, in the order of the maps, and so does `config`, whose
/// YAML is the run's own.
class FileStems {
 public:
  std::string of(const std::string& map_name);

 private:
  std::set<std::string> taken_{"config"};
};

}  // namespace waymark::map_formats
