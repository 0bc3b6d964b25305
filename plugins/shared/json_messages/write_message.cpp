// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "plugins/shared/json_messages/base64.hpp"
#include "plugins/shared/json_messages/payload_text.hpp"

namespace waymark::json_messages {
namespace {

/// Writes fields as `"name":value`. A list of elements, if there is one, is the payload's last field.
class Writer final : public FieldVisitor {
 public:
  explicit Writer(std::string& text) : text_(text) {}

  void field(const FieldInfo& info, const FieldValue& value) override {
    if (const auto* numbers = std::get_if<std::span<const double>>(&value)) {
      for (std::size_t i = 0; i < numbers->size(); ++i) {
        if (!info.required && std::isnan((*numbers)[i])) continue;
        name(info.names[i]);
        number((*numbers)[i]);
      }
    } else if (const auto* floats = std::get_if<std::span<const float>>(&value)) {
      if (!info.required && floats->empty()) return;
      name(info.name());
      list(*floats, [this](float v) { number(v); });
    } else if (const auto* points = std::get_if<std::span<const Eigen::Vector3f>>(&value)) {
      name(info.name());
      list(*points, [this](const Eigen::Vector3f& p) { list(std::span(p.data(), 3), [this](float v) { number(v); }); });
    } else {
      name(info.name());
      single(value);
    }
  }
  void list(const FieldInfo& info, std::size_t size) override {
    name(info.name());
    text_ += size == 0 ? "[]" : "[";
  }
  void element(std::size_t index) override {
    if (index > 0) text_ += "},";
    text_ += '{';
    is_first_ = true;
    closing_ = "}]";
  }
  void finish() { text_ += closing_; }

 private:
  void name(std::string_view name) {
    if (!is_first_) text_ += ',';
    is_first_ = false;
    fmt::format_to(std::back_inserter(text_), "\"{}\":", name);
  }
  template <class Number>
  void number(Number value) {
    if (std::isfinite(value)) {
      fmt::format_to(std::back_inserter(text_), "{}", value);
    } else {
      text_ += "null";
    }
  }
  template <class T, class Write>
  void list(std::span<const T> values, const Write& write) {
    char before = '[';
    for (const T& value : values) {
      text_ += before;
      write(value);
      before = ',';
    }
    text_ += values.empty() ? "[]" : "]";
  }
  void single(const FieldValue& value) {
    if (const auto* integer = std::get_if<std::int64_t>(&value)) {
      fmt::format_to(std::back_inserter(text_), "{}", *integer);
    } else if (const auto* flag = std::get_if<bool>(&value)) {
      text_ += *flag ? "true" : "false";
    } else if (const auto* word = std::get_if<FieldWord>(&value)) {
      text_ += json_text(word->word);
    } else if (const auto* bytes = std::get_if<std::span<const std::uint8_t>>(&value)) {
      text_ += '"' + to_base64(*bytes) + '"';
    }
  }

  std::string& text_;
  bool is_first_ = false;
  std::string_view closing_;
};

}  // namespace

std::string json_text(std::string_view text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string write_message(std::string_view sensor, std::optional<Time> stamp, const Payload& payload) {
  std::string text = "{\"sensor\":" + json_text(sensor);
  if (stamp) fmt::format_to(std::back_inserter(text), ",\"stamp_ns\":{}", stamp->time_since_epoch().count());
  Writer writer(text);
  payload.visit(writer);
  writer.finish();
  return text + '}';
}

}  // namespace waymark::json_messages
