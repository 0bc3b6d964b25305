// SPDX-License-Identifier: Apache-2.0
#include "payload_numbers.hpp"

#include <span>
#include <utility>
#include <variant>
#include <vector>

namespace waymark::testing {

namespace {

/// Sizes of the lists of elements with fields, in the order of their visits.
class ListSizes final : public FieldVisitor {
 public:
  void field(const FieldInfo&, const FieldValue&) override {}
  void list(const FieldInfo&, std::size_t size) override { sizes.push_back(size); }

  std::vector<std::size_t> sizes;
};

/// Counts numbers, and exchanges one of them.
class Exchange final : public FieldEditor {
 public:
  /// An index beyond all numbers exchanges none.
  Exchange(std::vector<std::size_t> sizes, std::size_t index, double value)
      : sizes_(std::move(sizes)), index_(index), value_(value) {}

  void field(const FieldInfo& info, const FieldSlot& slot) override {
    if (const auto* numbers = std::get_if<std::span<double>>(&slot)) {
      for (std::size_t i = 0; i < numbers->size(); ++i)
        number((*numbers)[i], info.names[i].empty() ? info.name() : info.names[i]);
    } else if (const auto* list = std::get_if<std::vector<float>*>(&slot)) {
      if (!(*list)->empty()) number((*list)->front(), info.name());
    } else if (const auto* points = std::get_if<std::vector<Eigen::Vector3f>*>(&slot)) {
      if (!(*points)->empty()) number((*points)->front().x(), info.name());
    }
  }
  std::size_t list(const FieldInfo&) override { return sizes_[next_list_++]; }

  std::size_t count = 0;
  double before = 0.0;
  std::string name;

 private:
  template <class T>
  void number(T& place, std::string_view its_name) {
    if (count++ != index_) return;
    name = its_name;
    before = std::exchange(place, static_cast<T>(value_));
  }

  std::vector<std::size_t> sizes_;
  std::size_t next_list_ = 0;
  std::size_t index_;
  double value_;
};

Exchange exchange(const Payload& payload, std::size_t index, double value) {
  ListSizes lists;
  payload.visit(lists);
  Exchange exchange(std::move(lists.sizes), index, value);
  const_cast<Payload&>(payload).edit(exchange);  // NOLINT(cppcoreguidelines-pro-type-const-cast): see NumberInPlace
  return exchange;
}

}  // namespace

std::size_t count_numbers(const Payload& payload) { return exchange(payload, static_cast<std::size_t>(-1), 0.0).count; }

NumberInPlace::NumberInPlace(const Payload& payload, std::size_t index, double value)
    : payload_(payload), index_(index), before_(0.0) {
  const Exchange done = exchange(payload, index, value);
  before_ = done.before;
  name_ = done.name;
}

void NumberInPlace::restore() const { exchange(payload_, index_, before_); }

}  // namespace waymark::testing
