// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "waymark/interface/source.hpp"
#include "waymark/testing/violations.hpp"

namespace waymark::testing {

/// Makes the source under test; every call must give a new one at the start of the same log.
using MakeSource = std::function<std::shared_ptr<Source>()>;

/// Under which circumstances a source is checked.
struct SourceSetting {
  std::size_t most = 100'000;  ///< a source that gives more measurements than this counts as endless
  /// Bytes that stand for the content of a payload that registers no fields; without it such payloads are compared by
  /// type only.
  std::function<std::string(const Payload&)> content = {};
};

/// Reads the whole log (a replay, not a live source) and checks
/// - the channels: names and payload types, the same in every instance;
/// - every measurement: payload of the channel's type whose values fit what its fields register, arrival not before the
///   stamp and never going back, sequence numbers that rise, progress within 0..1 that does not fall;
/// - the end: `next` stays empty;
/// - two instances give the same;
/// - reference and bad records: finite values, times in order, no empty texts.
Violations check_source(const MakeSource& make_source, const SourceSetting& setting = {});

}  // namespace waymark::testing
