// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/dds/domain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string_view>

namespace waymark::dds {
namespace {

/// As ROS 2 has it: ports of higher ones are beyond what UDP has.
constexpr std::int64_t kLastDomain = 232;

std::int64_t domain_of_environment(const Config& config) {
  const char* const text = std::getenv("ROS_DOMAIN_ID");
  if (text == nullptr || *text == '\0') return 0;
  const std::string_view word(text);
  std::int64_t id = -1;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), id);
  if (error != std::errc() || end != word.data() + word.size() || id < 0 || id > kLastDomain) {
    config.fail("domain", fmt::format("the environment variable ROS_DOMAIN_ID is \"{}\"; a number from 0 to {} is "
                                      "expected",
                                      word.substr(0, 40), kLastDomain));
  }
  return id;
}

bool is_name_of_interface(std::string_view name) {
  constexpr std::size_t kLongest = 15;  // of Linux
  return !name.empty() && name.size() <= kLongest && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("._-@").find(c) != std::string_view::npos;
  });
}

std::string interfaces(const DomainSettings& settings) {
  if (settings.interface == "auto") return R"(<NetworkInterface autodetermine="true"/>)";
  // The loopback interface does not say that it can multicast, but it can.
  return fmt::format(R"(<NetworkInterface name="{}"{}/>)", settings.interface,
                     settings.interface == "lo" ? R"( multicast="true")" : "");
}

}  // namespace

DomainSettings read_domain_settings(const Config& config) {
  DomainSettings settings;
  const Config::Key domain{"domain", "", "domain of DDS, which ROS 2 calls ROS_DOMAIN_ID",
                           "that of the environment variable ROS_DOMAIN_ID, else 0"};
  settings.id = static_cast<std::uint32_t>(config.has(domain) ? config.integer_in(domain, 0, kLastDomain, 0)
                                                              : domain_of_environment(config));
  if (!config.has(domain)) config.integer_in(domain, 0, kLastDomain, settings.id);
  settings.interface = config.text(
      {"interface",
       "network that topics are exchanged through: `lo`: this machine itself; a name such as `eth0`; `auto`: the one "
       "that DDS chooses; `environment`: what CYCLONEDDS_URI says. Whoever is in that network can read what is "
       "published, and send measurements"},
      "lo");
  if (!is_name_of_interface(settings.interface))
    config.fail("interface", "the name of a network interface is expected: lo, eth0, auto or environment");
  return settings;
}

std::string domain_configuration(const DomainSettings& settings) {
  if (settings.interface == "environment") {
    const char* const uri = std::getenv("CYCLONEDDS_URI");
    return uri == nullptr ? "" : uri;
  }
  // Nodes that use this machine only, too, may be found by unicast (ROS_LOCALHOST_ONLY), so both are used on lo.
  const std::string_view peers = settings.interface == "lo" ? R"(<Peers><Peer address="127.0.0.1"/></Peers>)" : "";
  return fmt::format(
      R"(<CycloneDDS><Domain Id="any">
<General><Interfaces>{}</Interfaces><AllowMulticast>true</AllowMulticast></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>40</MaxAutoParticipantIndex>{}</Discovery>
<Internal><MaxSampleSize>{} B</MaxSampleSize><Watermarks><WhcHigh>8 MB</WhcHigh></Watermarks></Internal>
<SharedMemory><Enable>false</Enable></SharedMemory>
</Domain></CycloneDDS>)",
      interfaces(settings), peers, kMostBytes);
}

}  // namespace waymark::dds
