// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/payload_edit.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <tuple>
#include <variant>
#include <vector>

#include "waymark/interface/payloads.hpp"

namespace waymark {
namespace {

/// All values of a payload, in the order of its fields.
struct Values {
  std::deque<double> numbers;
  std::deque<std::vector<std::uint8_t>> bytes;
  std::deque<std::size_t> sizes;
};

struct Collect final : FieldVisitor {
  void field(const FieldInfo&, const FieldValue& value) override {
    const auto append = [&](auto begin, auto end) { values.numbers.insert(values.numbers.end(), begin, end); };
    if (const auto* numbers = std::get_if<std::span<const double>>(&value)) append(numbers->begin(), numbers->end());
    if (const auto* integer = std::get_if<std::int64_t>(&value))
      values.numbers.push_back(static_cast<double>(*integer));
    if (const auto* flag = std::get_if<bool>(&value)) values.numbers.push_back(*flag ? 1.0 : 0.0);
    if (const auto* word = std::get_if<FieldWord>(&value)) values.numbers.push_back(word->number);
    if (const auto* list = std::get_if<std::span<const float>>(&value)) {
      values.sizes.push_back(list->size());
      append(list->begin(), list->end());
    }
    if (const auto* points = std::get_if<std::span<const Eigen::Vector3f>>(&value)) {
      values.sizes.push_back(points->size());
      for (const Eigen::Vector3f& p : *points) append(p.data(), p.data() + 3);
    }
    if (const auto* data = std::get_if<std::span<const std::uint8_t>>(&value))
      values.bytes.emplace_back(data->begin(), data->end());
  }
  void list(const FieldInfo&, std::size_t size) override { values.sizes.push_back(size); }
  Values values;
};

struct Restore final : FieldEditor {
  explicit Restore(Values from) : values(std::move(from)) {}
  template <class T>
  T take(std::deque<T>& from) {
    T value = from.front();
    from.pop_front();
    return value;
  }
  void field(const FieldInfo&, const FieldSlot& slot) override {
    if (const auto* numbers = std::get_if<std::span<double>>(&slot)) {
      for (double& number : *numbers) number = take(values.numbers);
    } else if (auto* const* integer = std::get_if<int*>(&slot)) {
      **integer = static_cast<int>(take(values.numbers));
    } else if (auto* const* flag = std::get_if<bool*>(&slot)) {
      **flag = take(values.numbers) != 0.0;
    } else if (const auto* word = std::get_if<WordSlot>(&slot)) {
      word->assign(word->value, static_cast<int>(take(values.numbers)));
    } else if (auto* const* list = std::get_if<std::vector<float>*>(&slot)) {
      (*list)->resize(take(values.sizes));
      for (float& v : **list) v = static_cast<float>(take(values.numbers));
    } else if (auto* const* points = std::get_if<std::vector<Eigen::Vector3f>*>(&slot)) {
      (*points)->resize(take(values.sizes));
      for (Eigen::Vector3f& p : **points) {
        for (int i = 0; i < 3; ++i) p[i] = static_cast<float>(take(values.numbers));
      }
    } else if (auto* const* data = std::get_if<std::vector<std::uint8_t>*>(&slot)) {
      **data = take(values.bytes);
    }
  }
  std::size_t list(const FieldInfo&) override { return take(values.sizes); }
  Values values;
};

/// Sets every number to another value and every list to two elements.
struct FillUp final : FieldEditor {
  double next() { return counter += 0.25; }
  void field(const FieldInfo& info, const FieldSlot& slot) override {
    if (const auto* numbers = std::get_if<std::span<double>>(&slot)) {
      for (double& number : *numbers) number = next();
    } else if (auto* const* integer = std::get_if<int*>(&slot)) {
      **integer = 7;
    } else if (auto* const* flag = std::get_if<bool*>(&slot)) {
      **flag = !**flag;
    } else if (const auto* word = std::get_if<WordSlot>(&slot)) {
      word->assign(word->value, static_cast<int>(info.words.size()) - 1);
    } else if (auto* const* list = std::get_if<std::vector<float>*>(&slot)) {
      **list = {1.5f, 2.5f};
    } else if (auto* const* points = std::get_if<std::vector<Eigen::Vector3f>*>(&slot)) {
      **points = {{1.5f, 2.5f, 3.5f}, {4.5f, 5.5f, 6.5f}};
    } else if (auto* const* data = std::get_if<std::vector<std::uint8_t>*>(&slot)) {
      **data = {1, 2, 3};
    }
  }
  std::size_t list(const FieldInfo&) override { return 2; }
  double counter = 0.0;
};

Values values_of(const Payload& payload) {
  Collect collect;
  EXPECT_TRUE(payload.visit(collect)) << payload.type();
  return collect.values;
}

TEST(PayloadEdit, WhatAVisitorReadsAnEditorRestores) {
  const auto check = [](std::string_view type) {
    const auto original = make_payload(type);
    ASSERT_NE(original, nullptr) << type;
    FillUp fill_up;
    EXPECT_TRUE(original->edit(fill_up));
    const Values expected = values_of(*original);
    EXPECT_FALSE(expected.numbers.empty()) << type;

    const auto restored = make_payload(type);
    Restore restore(expected);
    restored->edit(restore);
    const Values actual = values_of(*restored);
    EXPECT_EQ(actual.numbers, expected.numbers) << type;
    EXPECT_EQ(actual.bytes, expected.bytes) << type;
    EXPECT_EQ(actual.sizes, expected.sizes) << type;
  };
  std::apply([&](const auto&... payload) { (check(payload.kType), ...); }, CorePayloads());
}

TEST(PayloadEdit, AnUnknownNameMakesNoPayload) { EXPECT_EQ(make_payload("waymark/LaserScan@2"), nullptr); }

}  // namespace
}  // namespace waymark
