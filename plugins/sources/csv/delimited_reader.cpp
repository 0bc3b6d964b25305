// SPDX-License-Identifier: Apache-2.0
#include "delimited_reader.hpp"

#include <algorithm>
#include <cstring>
#include <exception>
#include <utility>

#include "number_text.hpp"
#include "waymark/base/error.hpp"

namespace waymark::csv {
namespace {

constexpr std::size_t kBufferBytes = 1 << 18;
constexpr std::size_t kLongestLine = std::size_t{1} << 26;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool is_blank(char c) { return c == ' ' || c == '\t'; }

std::string_view trim(const char* begin, const char* end) {
  while (begin != end && is_blank(*begin)) ++begin;
  while (begin != end && is_blank(end[-1])) --end;
  if (end - begin >= 2 && *begin == '"' && end[-1] == '"') ++begin, --end;
  return {begin, static_cast<std::size_t>(end - begin)};
}

void split(std::string_view line, char delimiter, std::vector<std::string_view>& fields) {
  fields.clear();
  const char* at = line.data();
  const char* const end = at + line.size();
  if (delimiter == Format::kBlanks) {
    for (;;) {
      while (at != end && is_blank(*at)) ++at;
      if (at == end) return;
      const char* const begin = at;
      while (at != end && !is_blank(*at)) ++at;
      fields.push_back(trim(begin, at));
    }
  }
  for (;;) {
    const char* const begin = at;
    while (at != end && *at != delimiter) ++at;
    fields.push_back(trim(begin, at));
    if (at == end) return;
    ++at;
  }
}

char guess_delimiter(std::string_view line) {
  for (const char candidate : {',', ';'}) {
    if (line.find(candidate) != std::string_view::npos) return candidate;
  }
  const bool single_tabs = line.find('\t') != std::string_view::npos && line.find(' ') == std::string_view::npos &&
                           line.find("\t\t") == std::string_view::npos;
  return single_tabs ? '\t' : Format::kBlanks;
}

bool has_number(const std::vector<std::string_view>& fields) {
  return std::ranges::any_of(fields, [](std::string_view field) {
    double value = 0.0;
    return parse_number(field, value) == NumberText::ok;
  });
}

}  // namespace

LineReader::LineReader(const std::filesystem::path& file, std::string comment)
    : name_(file.string()), comment_(std::move(comment)), bytes_(file), buffer_(kBufferBytes) {}

std::string LineReader::place() const { return name_ + ":" + std::to_string(line_); }

double LineReader::used_bytes() const {
  if (bytes_.produced() == 0) return 0.0;
  const double ahead = static_cast<double>(end_ - begin_) / static_cast<double>(bytes_.produced());
  return static_cast<double>(bytes_.consumed()) * (1.0 - ahead);
}

bool LineReader::next(std::string_view& line) {
  while (next_raw(line)) {
    const auto first = line.find_first_not_of(" \t");
    if (first == std::string_view::npos) continue;
    if (!comment_.empty() && line.substr(first).starts_with(comment_)) continue;
    return true;
  }
  return false;
}

bool LineReader::next_raw(std::string_view& line) {
  std::size_t searched = begin_;
  for (;;) {
    const char* const data = buffer_.data();
    if (const void* found = std::memchr(data + searched, '\n', end_ - searched)) {
      const auto length = static_cast<std::size_t>(static_cast<const char*>(found) - (data + begin_));
      line = {data + begin_, length};
      begin_ += length + 1;
      break;
    }
    const std::size_t kept = end_ - begin_;
    std::memmove(buffer_.data(), data + begin_, kept);
    begin_ = 0;
    end_ = kept;
    searched = kept;
    if (end_ == buffer_.size()) {
      ++line_;
      if (buffer_.size() >= kLongestLine) throw DataError(place() + ": the line is longer than 64 MiB");
      --line_;
      buffer_.resize(2 * buffer_.size());
    }
    const std::size_t count = bytes_.read(buffer_.data() + end_, buffer_.size() - end_);
    end_ += count;
    if (count > 0) continue;
    if (!bytes_.problem().empty()) {
      // What is left of a damaged stream is not a whole line.
      throw DataError(name_ + ":" + std::to_string(line_ + 1) + ": " + std::string(bytes_.problem()));
    }
    if (kept == 0) return false;
    line = {buffer_.data(), kept};
    begin_ = end_;
    break;
  }
  ++line_;
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  if (line_ == 1 && line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  return true;
}

DelimitedReader::DelimitedReader(std::filesystem::path file, Format format)
    : file_(std::move(file)), format_(std::move(format)) {
  if (format_.records) {
    if (!RecordReader(file_, *format_.records).next()) throw DataError(file_.string() + ": no records");
    records_ = std::make_unique<RecordReader>(file_, *format_.records);
    return;
  }
  determine_layout();
  lines_ = std::make_unique<LineReader>(file_, format_.comment);
  std::string_view line;
  for (int i = 0; i < header_rows_; ++i) lines_->next(line);
}

void DelimitedReader::determine_layout() {
  LineReader lines(file_, format_.comment);
  const int stated_header_rows = format_.header_rows.value_or(1);
  std::vector<std::string> head;  // as many rows as a header may have, and the one after
  std::string_view line;
  std::exception_ptr damage;
  const auto fail_without_rows = [&] {
    if (damage) std::rethrow_exception(damage);
    throw DataError(file_.string() + ": no data rows");
  };
  try {
    while (static_cast<int>(head.size()) <= stated_header_rows && lines.next(line)) head.emplace_back(line);
  } catch (const DataError&) {
    if (head.empty() || format_.header_rows) throw;
    damage = std::current_exception();  // the caller reaches it, if there is a data row before it
  }
  if (head.empty()) fail_without_rows();

  delimiter_ = format_.delimiter.value_or(guess_delimiter(head.back()));
  split(head.front(), delimiter_, fields_);
  header_rows_ = format_.header_rows.value_or(has_number(fields_) ? 0 : 1);
  if (static_cast<int>(head.size()) <= header_rows_) fail_without_rows();
  if (header_rows_ > 0) header_.assign(fields_.begin(), fields_.end());
  fields_.clear();
}

bool DelimitedReader::next() {
  if (records_) return records_->next();
  std::string_view line;
  if (!lines_->next(line)) return false;
  split(line, delimiter_, fields_);
  return true;
}

}  // namespace waymark::csv
