// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/rig.hpp"

#include <fmt/format.h>

#include "waymark/base/error.hpp"

namespace waymark {

int Rig::find(std::string_view name) const {
  for (std::size_t i = 0; i < mountings_.size(); ++i) {
    if (mountings_[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

const Mounting& Rig::get(std::string_view name) const {
  const int index = find(name);
  if (index < 0) {
    std::string names;
    for (const Mounting& mounting : mountings_) names += (names.empty() ? "" : ", ") + mounting.name;
    throw ConfigError(
        fmt::format("sensors.{}: there is no such sensor; there are: {}", name, names.empty() ? "none" : names));
  }
  return mountings_[static_cast<std::size_t>(index)];
}

const Pose& Rig::T_base_sensor(std::string_view name) const {
  const auto& pose = get(name).T_base_sensor;
  if (!pose) throw ConfigError(fmt::format("sensors.{}: base_T_sensor is missing: where the sensor is mounted", name));
  return *pose;
}

const Intrinsics& Rig::intrinsics(std::string_view name) const {
  const auto& intrinsics = get(name).intrinsics;
  if (!intrinsics) throw ConfigError(fmt::format("sensors.{}: intrinsics are missing: of the camera", name));
  return *intrinsics;
}

}  // namespace waymark
