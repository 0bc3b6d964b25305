// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "waymark/config/config.hpp"

namespace waymark::dds {

/// Which topics are seen, and through which network.
struct DomainSettings {
  std::uint32_t id = 0;
  /// "lo": programs of this machine only; "auto": the interface that DDS chooses; "environment": what `CYCLONEDDS_URI`
  /// says; or the name of an interface.
  std::string interface = "lo";
};

/// Reads `domain` and `interface`. Throws ConfigError, also for an `ROS_DOMAIN_ID` that is no number if that counts.
DomainSettings read_domain_settings(const Config& config);

/// Larger samples are not put together from their fragments.
inline constexpr std::size_t kMostBytes = std::size_t{1} << 25;

/// Configuration of CycloneDDS for a domain, as XML.
std::string domain_configuration(const DomainSettings& settings);

}  // namespace waymark::dds
