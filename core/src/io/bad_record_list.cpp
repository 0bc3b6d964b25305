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

void BadRecordList::save(OutArchive& archive) const {
  archive.value(count_);
  archive.value(static_cast<std::uint64_t>(records_.size()));
  for (const BadRecord& record : records_) {
    archive.value(std::string_view(record.place));
    archive.value(std::string_view(record.reason));
  }
}

void BadRecordList::load(InArchive& archive) {
  std::uint64_t records = 0;
  archive.value(count_);
  archive.value(records);
  if (records > kMostRecords)
    throw DataError(fmt::format("checkpoint: the list of bad {}s is too long", words_.record));
  records_.resize(records);
  for (BadRecord& record : records_) {
    archive.value(record.place);
    archive.value(record.reason);
  }
}

}  // namespace waymark
