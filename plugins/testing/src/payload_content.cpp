// SPDX-License-Identifier: Apache-2.0
#include "payload_content.hpp"

#include <cstddef>
#include <span>
#include <type_traits>
#include <variant>

namespace waymark::testing {
namespace {

/// Writes every value behind its size, so that different payloads never give the same bytes.
class Bytes final : public FieldVisitor {
 public:
  void field(const FieldInfo&, const FieldValue& value) override {
    std::visit([this](const auto& one) { add(one); }, value);
  }
  void list(const FieldInfo&, std::size_t size) override { add_raw(&size, sizeof size); }

  std::string take() { return std::move(bytes_); }

 private:
  void add_raw(const void* data, std::size_t size) { bytes_.append(static_cast<const char*>(data), size); }
  void add(std::int64_t value) { add_raw(&value, sizeof value); }
  void add(bool value) { add_raw(&value, sizeof value); }
  void add(const FieldWord& value) { add_raw(&value.number, sizeof value.number); }
  template <class T>
  void add(std::span<const T> values) {
    const std::size_t size = values.size_bytes();
    add_raw(&size, sizeof size);
    if (size > 0) add_raw(values.data(), size);
  }

  std::string bytes_;
};

}  // namespace

std::string content_of(const Payload& payload) {
  Bytes bytes;
  payload.visit(bytes);
  return bytes.take();
}

}  // namespace waymark::testing
