// SPDX-License-Identifier: Apache-2.0
#include "waymark/io/bad_record_list.hpp"

#include <fmt/format.h>

#include "waymark/base/error.hpp"

namespace waymark {
namespace {

constexpr std::size_t kMostRecords = 1000;

}  // namespace

void BadRecordList::add(const std::string& place, const std::string& reason) {
  ++count_;
  if (records_.size() < kMostRecords) records_.push_back({place, reason});
  if (count_ > limit_) {
    throw DataError(fmt::format("{}: {} (bad {} number {}; {} allows {}, a larger value {})", place, reason,
                                words_.record, count_, words_.key, limit_, words_.remedy));
  }
}

}  // namespace waymark
