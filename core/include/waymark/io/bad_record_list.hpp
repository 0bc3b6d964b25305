// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/interface/source.hpp"

namespace waymark {

/// The records that a source skipped, up to a limit that the YAML sets.
class WAYMARK_API BadRecordList {
 public:
  /// Words of the error message: for a record, for the key of the limit, and for the effect of a larger value.
  struct Words {
    std::string record;
    std::string key;
    std::string remedy;
  };

  BadRecordList(std::uint64_t limit, Words words) : limit_(limit), words_(std::move(words)) {}

  /// Adds one. Throws DataError with its place and reason if it exceeds the limit.
  void add(const std::string& place, const std::string& reason);

  const std::vector<BadRecord>& records() const { return records_; }  ///< the first 1000

 private:
  std::uint64_t limit_;
  Words words_;
  std::uint64_t count_ = 0;
  std::vector<BadRecord> records_;
};

}  // namespace waymark
