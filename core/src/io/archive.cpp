// SPDX-License-Identifier: Apache-2.0
#include "waymark/io/archive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "waymark/base/error.hpp"

static_assert(std::endian::native == std::endian::little, "archives are written in the machine's order");

namespace waymark {
namespace {

constexpr std::uint64_t kMaxNameLength = 4096;
constexpr std::uint32_t kSectionMark = 0x54434553u;  // "SECT"

}  // namespace

std::uint32_t OutArchive::section(std::string_view name, std::uint32_t version) {
  value(kSectionMark);
  value(name);
  value(version);
  return version;
}

void OutArchive::bytes(const void* data, std::size_t size) {
  if (size == 0) return;
  stream_.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
  if (!stream_) throw Error("checkpoint: writing failed");
}

bool OutArchive::first_sight(const void* object) {
  const auto [it, is_new] = seen_.try_emplace(object, seen_.size());
  value(it->second);
  return is_new;
}

InArchive::InArchive(std::istream& stream) : stream_(stream) {
  const std::istream::pos_type here = stream_.tellg();
  if (here != std::istream::pos_type(-1)) {
    stream_.seekg(0, std::ios::end);
    const std::istream::pos_type end = stream_.tellg();
    stream_.clear();
    stream_.seekg(here);
    if (end != std::istream::pos_type(-1)) left_ = static_cast<std::uint64_t>(end - here);
  }
  stream_.clear();
}

std::uint32_t InArchive::section(std::string_view name, std::uint32_t newest) {
  std::uint32_t mark = 0;
  value(mark);
  if (mark != kSectionMark) fail(fmt::format("section \"{}\" was expected, but no section starts here", name));
  std::uint64_t length = 0;
  value(length);
  if (length > kMaxNameLength) fail(fmt::format("section \"{}\" was expected, but its name is damaged", name));
  std::string found(length, '\0');
  bytes(found.data(), found.size());
  std::uint32_t version = 0;
  value(version);
  if (found != name) fail(fmt::format("section \"{}\" was expected, but \"{}\" is there", name, found));
  if (version > newest) {
    fail(fmt::format("section \"{}\" has version {}, but {} is the newest known here", name, version, newest));
  }
  return version;
}

void InArchive::bytes(void* data, std::size_t size) {
  if (size == 0) return;
  stream_.read(static_cast<char*>(data), static_cast<std::streamsize>(size));
  if (!stream_) fail("the stream ends early");
  if (left_ != kUnknown) left_ -= std::min<std::uint64_t>(left_, size);
}

std::size_t InArchive::count(std::size_t element_size) {
  std::uint64_t elements = 0;
  value(elements);
  require_left(elements, element_size);
  return static_cast<std::size_t>(elements);
}

void InArchive::require_left(std::uint64_t elements, std::size_t element_size) const {
  if (elements > left_ / element_size) fail("the stream ends early");
}

std::shared_ptr<void> InArchive::shared_of(std::type_index type, std::uint64_t& number) {
  value(number);
  if (number > objects_.size()) fail("a shared object was skipped");
  if (number == objects_.size()) {
    objects_.emplace_back();
    return nullptr;
  }
  const Object& known = objects_[static_cast<std::size_t>(number)];
  if (known.object == nullptr) fail("a shared object is a part of itself");
  if (known.type != type) fail("a shared object has another type");
  return known.object;
}

void InArchive::fail(std::string_view what) const { throw DataError(fmt::format("checkpoint: {}", what)); }

}  // namespace waymark
