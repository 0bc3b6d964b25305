// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/interface/source.hpp"

namespace waymark {

/// What a source skipped, up to a limit that the YAML sets.
class WAYMARK_API BadRecordList {
 public:
  /// How the message of the one too many speaks of a record, of the key of the limit, and of what a larger value does.
  struct Words {
    std::string record;
    std::string key;
    std::string remedy;
  };

  BadRecordList(std::uint64_t limit, Words words) : limit_(limit), words_(std::move(words)) {}

  /// Counts one. Throws DataError with its place and reason if it is one too many.
  void add(const std::string& place, const std::string& reason);

  const std::vector<BadRecord>& records() const { return records_; }  ///< the first 1000

 private:
  std::uint64_t limit_;
  Words words_;
  std::uint64_t count_ = 0;
  std::vector<BadRecord> records_;
};

}  // namespace waymark
