// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <utility>

#include "waymark/base/api.hpp"

namespace waymark {

/// Names out of a YAML (of sensors, of maps) as file names without extension, on any system: characters other than
/// letters, digits, `_` and `-` become `_`. Of names that would become the same, or that are taken, later ones get a
/// number.
class WAYMARK_API FileStems {
 public:
  explicit FileStems(std::set<std::string> taken) : taken_(std::move(taken)) {}
  std::string of(const std::string& name);

 private:
  std::set<std::string> taken_;
};

}  // namespace waymark
