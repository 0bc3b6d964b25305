// SPDX-License-Identifier: Apache-2.0
#include "bad_records.hpp"

#include <fmt/format.h>

#include "waymark/error.hpp"

namespace waymark::kitti {
namespace {

constexpr std::size_t kMostRecords = 1000;

}  // namespace

void BadRecords::add(const std::string& place, const std::string& reason) {
  ++count_;
  if (records_.size() < kMostRecords) records_.push_back({place, reason});
  if (count_ > limit_) {
    throw DataError(
        fmt::format("{}: {} (bad record number {}; max_bad_records allows {}, a larger value goes on after such ones)",
                    place, reason, count_, limit_));
  }
}

void BadRecords::save(OutArchive& archive) const {
  archive.value(count_);
  archive.value(static_cast<std::uint64_t>(records_.size()));
  for (const BadRecord& record : records_) {
    archive.value(std::string_view(record.place));
    archive.value(std::string_view(record.reason));
  }
}

void BadRecords::load(InArchive& archive) {
  std::uint64_t records = 0;
  archive.value(count_);
  archive.value(records);
  if (records > kMostRecords) throw DataError("checkpoint: the list of bad records is too long");
  records_.resize(records);
  for (BadRecord& record : records_) {
    archive.value(record.place);
    archive.value(record.reason);
  }
}

}  // namespace waymark::kitti
