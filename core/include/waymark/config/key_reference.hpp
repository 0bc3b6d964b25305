// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/config/config.hpp"

namespace waymark {

/// One key that a reader of configurations may ask for.
struct DescribedKey {
  Config::Asked asked;
  /// Other keys without which it is not asked for, with their values: "model=ackermann"; empty: it always is.
  std::vector<std::string> given;
};

/// The one of `keys` with this path; null if there is none.
template <class Keys>
auto* find_key(Keys& keys, std::string_view path) {
  const auto at =
      std::ranges::find(keys, path, [](const DescribedKey& key) -> std::string_view { return key.asked.path; });
  return at == keys.end() ? nullptr : &*at;
}

/// What a reader is tried with.
struct KeyTrials {
  std::vector<Config::Override> given;     ///< in every trial: "inputs=[LaserScan]"
  std::vector<std::string> texts = {"x"};  ///< values of keys that take text; the first where one is required
  std::string file = "trial";              ///< of the configuration; relative paths count from its folder
  int most = 50'000;                       ///< trials
};

/// All keys that `read` asks a configuration for, in the order of the reads. Reads are conditional, so it runs many
/// times: with nothing, with each required key, each other word of a choice, each truth value turned, each optional key
/// given, and so on from what each of these reveals. Whatever `read` throws ends one trial only. Throws Error if
/// `trials.most` are not enough.
WAYMARK_API std::vector<DescribedKey> describe_keys(const std::function<void(const Config&)>& read,
                                                    const KeyTrials& trials = {});

}  // namespace waymark
