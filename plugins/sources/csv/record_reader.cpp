// SPDX-License-Identifier: Apache-2.0
#include "record_reader.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <string>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::csv {
namespace {

constexpr std::int64_t kLongestRecord = std::int64_t{1} << 26;  // bytes, as a line of text
constexpr std::int64_t kMostFields = 1'000'000;
static_assert(std::endian::native == std::endian::little);

template <class T>
void append_number(const char* bytes, std::string& text) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  text.append(digits.data(), end.ptr);
}

using Append = void (*)(const char*, std::string&);

Append append_of(const RecordLayout::Run& run) {
  switch (run.bytes) {
    case 1:
      return run.kind == 'i' ? append_number<std::int8_t> : append_number<std::uint8_t>;
    case 2:
      return run.kind == 'i' ? append_number<std::int16_t> : append_number<std::uint16_t>;
    case 4:
      return run.kind == 'f'   ? append_number<float>
             : run.kind == 'i' ? append_number<std::int32_t>
                               : append_number<std::uint32_t>;
    default:
      return run.kind == 'f'   ? append_number<double>
             : run.kind == 'i' ? append_number<std::int64_t>
                               : append_number<std::uint64_t>;
  }
}

/// "897 u2" or "f8".
RecordLayout::Run read_run(const Config& records, const std::string& word) {
  const auto fail = [&] {
    records.fail("fields", "\"" + word +
                               "\" is no field; i1, i2, i4, i8, u1, u2, u4, u8, f4 or f8 is expected, or how many of "
                               "them and one: 897 u2");
  };
  RecordLayout::Run run{'u', 1, 1};
  const char* at = word.data();
  const char* const end = at + word.size();
  if (const auto number = std::from_chars(at, end, run.count); number.ec == std::errc{}) {
    at = number.ptr;
    if (at == end || *at != ' ') fail();
    while (at != end && *at == ' ') ++at;
  } else if (number.ec == std::errc::result_out_of_range) {
    fail();
  }
  if (end - at != 2) fail();
  run.kind = at[0];
  run.bytes = static_cast<std::size_t>(at[1] - '0');
  const std::string_view sizes = run.kind == 'f' ? "48" : run.kind == 'i' || run.kind == 'u' ? "1248" : "";
  if (sizes.find(at[1]) == std::string_view::npos || run.count == 0) fail();
  return run;
}

}  // namespace

std::size_t RecordLayout::bytes() const {
  std::size_t sum = 0;
  for (const Run& run : runs) sum += run.bytes * run.count;
  return sum;
}

RecordLayout RecordLayout::read(const Config& records) {
  RecordLayout layout;
  layout.skip_bytes = static_cast<std::size_t>(
      records.integer_in({"skip_bytes", "before the first record: a header"}, 0, kLongestRecord, 0));
  const std::vector<std::string> words = records.texts(
      {"fields",
       "the numbers of a record in their order: `i1` to `i8` and `u1` to `u8` (whole numbers with and without a sign), "
       "`f4`, `f8`, with the bytes of each; several of one kind: `897 u2`"});
  std::size_t fields = 0;
  for (const std::string& word : words) {
    const Run run = read_run(records, word);
    if (run.count > static_cast<std::size_t>(kMostFields) - fields)
      records.fail("fields", "more than " + std::to_string(kMostFields) + " numbers in a record");
    fields += run.count;
    layout.runs.push_back(run);
  }
  if (layout.runs.empty()) records.fail("fields", "is empty; the numbers of a record are expected");
  records.reject_unread();
  return layout;
}

RecordReader::RecordReader(const std::filesystem::path& file, RecordLayout layout)
    : name_(file.string()), layout_(std::move(layout)), bytes_(file) {
  record_.resize(std::max(layout_.bytes(), std::size_t{1} << 12));
}

std::string RecordReader::place() const { return name_ + ":record " + std::to_string(number_); }

/// Reads up to `size` bytes into the record: fewer only at the end.
std::size_t RecordReader::fill(std::size_t size) {
  std::size_t filled = 0;
  while (filled < size) {
    const std::size_t count = bytes_.read(record_.data() + filled, size - filled);
    if (count == 0) {
      if (bytes_.problem().empty()) break;
      throw DataError(name_ + ":record " + std::to_string(number_ + 1) + ": " + std::string(bytes_.problem()));
    }
    filled += count;
  }
  return filled;
}

bool RecordReader::next() {
  if (!std::exchange(is_begun_, true)) {
    for (std::size_t left = layout_.skip_bytes; left > 0;) {
      const std::size_t skipped = fill(std::min(left, record_.size()));
      if (skipped == 0)
        throw DataError(name_ + ": ends within the " + std::to_string(layout_.skip_bytes) +
                        " bytes before the first record");
      left -= skipped;
    }
  }
  const std::size_t size = layout_.bytes();
  const std::size_t filled = fill(size);
  if (filled == 0) return false;
  ++number_;
  if (filled < size) {
    throw DataError(place() + ": the file ends after " + std::to_string(filled) + " of its " + std::to_string(size) +
                    " bytes");
  }
  text_.clear();
  ends_.clear();
  const char* at = record_.data();
  for (const RecordLayout::Run& run : layout_.runs) {
    const Append append = append_of(run);
    for (std::size_t i = 0; i < run.count; ++i, at += run.bytes) {
      append(at, text_);
      ends_.push_back(text_.size());
    }
  }
  fields_.clear();
  std::size_t begin = 0;
  for (const std::size_t end : ends_) {
    fields_.emplace_back(text_.data() + begin, end - begin);
    begin = end;
  }
  return true;
}

}  // namespace waymark::csv
