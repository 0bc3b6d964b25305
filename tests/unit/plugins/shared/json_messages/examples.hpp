// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "waymark/interface/payloads.hpp"

namespace waymark::json_messages {

/// Gives every field a value of its own, and every list two elements.
class ExampleValues final : public FieldEditor {
 public:
  void field(const FieldInfo& info, const FieldSlot& slot) override {
    if (const auto* numbers = std::get_if<std::span<double>>(&slot)) {
      for (double& number : *numbers) number = next();
      if (numbers->size() == 4) {
        (*numbers)[0] = 1.0;  // a rotation
        for (double& axis : numbers->subspan(1)) axis = 0.0;
      }
    } else if (auto* const* integer = std::get_if<int*>(&slot)) {
      **integer = next_integer_++;
    } else if (auto* const* flag = std::get_if<bool*>(&slot)) {
      **flag = true;
    } else if (const auto* word = std::get_if<WordSlot>(&slot)) {
      word->assign(word->value, static_cast<int>(info.words.size()) - 1);
    } else if (auto* const* floats = std::get_if<std::vector<float>*>(&slot)) {
      **floats = {static_cast<float>(next()), static_cast<float>(next())};
    } else if (auto* const* points = std::get_if<std::vector<Eigen::Vector3f>*>(&slot)) {
      **points = {{1.0f, 2.0f, 3.0f}, {4.0f, 5.0f, 6.0f}};
    } else if (auto* const* bytes = std::get_if<std::vector<std::uint8_t>*>(&slot)) {
      **bytes = {0xff, 0xd8, 0xff, 0xe0};
    }
  }
  std::size_t list(const FieldInfo&) override { return 2; }

 private:
  double next() { return value_ += 0.25; }
  double value_ = 0.0;
  int next_integer_ = 7;
};

inline std::shared_ptr<Payload> example_of(std::string_view payload_type) {
  auto payload = make_payload(payload_type);
  ExampleValues values;
  payload->edit(values);
  return payload;
}

/// All core payloads, by their versioned names.
inline std::vector<std::string_view> core_payload_types() {
  return std::apply([]<class... P>(const P&...) { return std::vector<std::string_view>{P::kType...}; }, CorePayloads());
}

}  // namespace waymark::json_messages
