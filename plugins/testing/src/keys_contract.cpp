// SPDX-License-Identifier: Apache-2.0
#include "waymark/testing/keys_contract.hpp"

#include <string>

#include "findings.hpp"

namespace waymark::testing {

namespace {

constexpr const char* kUnknownKey = "waymark_testing_unknown";

/// What the host says to keys that nothing has read; empty if all were.
std::string unread(const Config& config) {
  try {
    config.reject_unread();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

void check_good_keys(const BuildPlugin& build, const std::string& yaml, Findings& findings) {
  for (int i = 0; i < 2; ++i) {
    const Config config = Config::parse(yaml);
    build(config);
    const std::string problem = unread(config);
    findings.require(problem.empty(), "a key of the YAML is not read", problem);
  }
}

void check_unknown_key(const BuildPlugin& build, const std::string& yaml, Findings& findings) {
  const Config config = Config::parse(yaml, "text", {std::string(kUnknownKey) + "=1"});
  build(config);
  findings.require(!unread(config).empty(), "a key that nobody knows is taken for read, so the host cannot refuse it");
}

/// A list within a list is no number, text, choice, flag, mapping or list of them.
void check_wrong_kind(const BuildPlugin& build, const std::string& yaml, const std::string& key, Findings& findings) {
  try {
    build(Config::parse(yaml, "text", {key + "=[[]]"}));
    findings.add("a value of a wrong kind is accepted", key);
  } catch (const ConfigError&) {
    return;
  } catch (const std::exception& error) {
    findings.add("a value of a wrong kind is not refused with ConfigError", key + ": " + error.what());
  } catch (...) {
    findings.add("a value of a wrong kind is not refused with ConfigError", key);
  }
}

}  // namespace

Violations check_keys(const BuildPlugin& build, const std::string& yaml) {
  Findings findings;
  findings.part("the constructor", [&] {
    check_good_keys(build, yaml, findings);
    check_unknown_key(build, yaml, findings);
    for (const std::string& key : Config::parse(yaml).keys()) check_wrong_kind(build, yaml, key, findings);
  });
  return findings.take();
}

}  // namespace waymark::testing
