// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <utility>

#include "waymark/base/api.hpp"

namespace waymark {

/// File names without extension, valid on any system, for names of the YAML (of sensors, of maps). Characters other
/// than letters, digits, `_` and `-` become `_`. A name that would be equal to an earlier or taken one gets a number.
class WAYMARK_API FileStems {
 public:
  explicit FileStems(std::set<std::string> taken) : taken_(std::move(taken)) {}
  std::string of(const std::string& name);

 private:
  std::set<std::string> taken_;
};

}  // namespace waymark
