// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "plugins/shared/json_messages/base64.hpp"
#include "plugins/shared/json_messages/payload_text.hpp"
#include "waymark/config/nearest_name.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::json_messages {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

bool is_null(const Scalar& value) { return std::holds_alternative<std::monostate>(value); }

/// Fills the registered fields of a payload. A list of elements, if there is one, is its last field.
class Fill final : public FieldEditor {
 public:
  explicit Fill(const Message& message) : message_(message) {}

  void field(const FieldInfo& info, const FieldSlot& slot) override {
    if (const auto* numbers = std::get_if<std::span<double>>(&slot)) return fill_numbers(info, *numbers);
    if (auto* const* floats = std::get_if<std::vector<float>*>(&slot)) return fill_floats(info, **floats);
    if (auto* const* points = std::get_if<std::vector<Eigen::Vector3f>*>(&slot)) return fill_points(info, **points);
    const Scalar* value = scalar(info.name());
    if (value == nullptr || is_null(*value)) return require(info, info.name(), value != nullptr);
    if (auto* const* integer = std::get_if<int*>(&slot)) {
      **integer = integer_of(info, *value);
    } else if (auto* const* flag = std::get_if<bool*>(&slot)) {
      const auto* given = std::get_if<bool>(value);
      if (given == nullptr) fail(info, "is neither true nor false");
      **flag = *given;
    } else if (const auto* word = std::get_if<WordSlot>(&slot)) {
      word->assign(word->value, word_of(info, *value));
    } else if (auto* const* bytes = std::get_if<std::vector<std::uint8_t>*>(&slot)) {
      const auto* text = std::get_if<std::string>(value);
      auto decoded = text != nullptr ? from_base64(*text) : std::nullopt;
      if (!decoded) fail(info, "is not base64");
      **bytes = std::move(*decoded);
    }
  }

  std::size_t list(const FieldInfo& info) override {
    elements_ = nullptr;
    const List* list = list_of(info);
    if (list == nullptr) return 0;
    if (!list->numbers.empty()) fail(info, "is not a list of objects");
    elements_ = &list->elements;
    return elements_->size();
  }
  void element(std::size_t index) override {
    reject_unknown_in_element();
    element_ = &(*elements_)[index];
    names_of_element_.clear();
  }

  /// Throws BadMessage for a key that no field has asked for.
  void reject_unknown(std::string_view payload) {
    reject_unknown_in_element();
    for (const auto& [name, value] : message_.fields) reject_if_unknown(name, names_, payload);
  }

 private:
  [[noreturn]] static void fail(const FieldInfo& info, std::string_view what) {
    throw BadMessage(fmt::format("{} {}", info.name(), what));
  }

  static void reject_if_unknown(const std::string& name, const std::vector<std::string>& known,
                                std::string_view payload) {
    if (std::ranges::find(known, name) != known.end()) return;
    const std::string nearest = nearest_name(printable(name), known);
    throw BadMessage(fmt::format("{} has no field \"{}\"{}; its fields: {}", payload, printable(name),
                                 nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest),
                                 fmt::join(known, ", ")));
  }
  void reject_unknown_in_element() const {
    if (element_ == nullptr) return;
    for (const auto& [name, value] : *element_) reject_if_unknown(name, names_of_element_, "an element");
  }

  /// A required field must be there; null is enough if it may be unknown.
  static void require(const FieldInfo& info, std::string_view name, bool is_there) {
    if (!info.required || (is_there && !info.unknown.empty())) return;
    throw BadMessage(fmt::format("{} is {}", name, is_there ? "null" : "missing"));
  }

  const Message::Value* find_at_top(std::string_view name) {
    names_.emplace_back(name);
    const auto found = std::ranges::find_if(message_.fields, [&](const auto& field) { return field.first == name; });
    return found == message_.fields.end() ? nullptr : &found->second;
  }

  /// The value of a field that is not a list; null if it is not there.
  const Scalar* scalar(std::string_view name) {
    if (element_ != nullptr) {
      names_of_element_.emplace_back(name);
      const auto found = std::ranges::find_if(*element_, [&](const auto& field) { return field.first == name; });
      return found == element_->end() ? nullptr : &found->second;
    }
    const Message::Value* value = find_at_top(name);
    if (value == nullptr) return nullptr;
    const auto* single = std::get_if<Scalar>(value);
    if (single == nullptr) throw BadMessage(fmt::format("{} is a list", name));
    return single;
  }

  const List* list_of(const FieldInfo& info) {
    const Message::Value* value = find_at_top(info.name());
    const auto* single = value != nullptr ? std::get_if<Scalar>(value) : nullptr;
    if (single != nullptr && !is_null(*single)) fail(info, "is not a list");
    if (value == nullptr || single != nullptr) {
      require(info, info.name(), false);
      return nullptr;
    }
    return std::get_if<List>(value);
  }

  static double number_of(std::string_view name, const Scalar& value) {
    if (const auto* number = std::get_if<double>(&value)) return *number;
    if (const auto* number = std::get_if<std::int64_t>(&value)) return static_cast<double>(*number);
    throw BadMessage(fmt::format("{} is not a number", name));
  }

  void fill_numbers(const FieldInfo& info, std::span<double> numbers) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const Scalar* value = scalar(info.names[i]);
      if (value == nullptr || is_null(*value)) {
        require(info, info.names[i], value != nullptr);
        if (!info.unknown.empty()) numbers[i] = kNaN;
      } else {
        numbers[i] = number_of(info.names[i], *value);
      }
    }
    if (numbers.size() == 4) normalize(info, numbers);
  }

  /// A quaternion of a few digits is accepted.
  static void normalize(const FieldInfo& info, std::span<double> q) {
    constexpr double kLoose = 0.01;
    constexpr double kTight = 1e-9;  // what was normalised once stays as it is, bit by bit
    if (std::ranges::all_of(q, [](double v) { return std::isnan(v); })) return;
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(std::abs(norm - 1.0) < kLoose))
      throw BadMessage(fmt::format("{} to {} are not a unit quaternion: their norm is {:.4g}", info.names.front(),
                                   info.names.back(), norm));
    if (std::abs(norm - 1.0) < kTight) return;
    for (double& v : q) v /= norm;
  }

  static float float_of(const FieldInfo& info, double value) {
    if (std::isnan(value)) {
      if (info.unknown.empty()) fail(info, "holds null");
      return info.unknown == "∞" ? std::numeric_limits<float>::infinity() : std::numeric_limits<float>::quiet_NaN();
    }
    if (std::abs(value) > std::numeric_limits<float>::max()) fail(info, "holds a number that is too large");
    return static_cast<float>(value);
  }

  void fill_floats(const FieldInfo& info, std::vector<float>& floats) {
    const List* list = list_of(info);
    if (list == nullptr) return;
    if (list->holds_points || !list->elements.empty()) fail(info, "is not a list of numbers");
    floats.reserve(list->numbers.size());
    for (const double number : list->numbers) floats.push_back(float_of(info, number));
  }

  void fill_points(const FieldInfo& info, std::vector<Eigen::Vector3f>& points) {
    const List* list = list_of(info);
    if (list == nullptr) return;
    if ((!list->holds_points && !list->numbers.empty()) || !list->elements.empty())
      fail(info, "is not a list of points");
    points.reserve(list->numbers.size() / 3);
    for (std::size_t i = 0; i + 2 < list->numbers.size(); i += 3)
      points.emplace_back(float_of(info, list->numbers[i]), float_of(info, list->numbers[i + 1]),
                          float_of(info, list->numbers[i + 2]));
  }

  static int integer_of(const FieldInfo& info, const Scalar& value) {
    const auto* number = std::get_if<std::int64_t>(&value);
    if (number == nullptr) fail(info, "is not an integer");
    if (*number < std::numeric_limits<int>::min() || *number > std::numeric_limits<int>::max())
      fail(info, "is too large");
    return static_cast<int>(*number);
  }

  static int word_of(const FieldInfo& info, const Scalar& value) {
    const auto* word = std::get_if<std::string>(&value);
    const auto found = word != nullptr ? std::ranges::find(info.words, *word) : info.words.end();
    if (found == info.words.end()) fail(info, fmt::format("is not one of: {}", fmt::join(info.words, ", ")));
    return static_cast<int>(found - info.words.begin());
  }

  const Message& message_;
  std::vector<std::string> names_;  // of the fields
  const std::vector<Element>* elements_ = nullptr;
  const Element* element_ = nullptr;  // null: at the top
  std::vector<std::string> names_of_element_;
};

}  // namespace

std::shared_ptr<const Payload> read_payload(const Message& message, std::string_view payload_type) {
  auto payload = make_payload(payload_type);
  Fill fill(message);
  payload->edit(fill);
  fill.reject_unknown(short_type_name(payload_type));
  if (const std::string problem = payload->problem(); !problem.empty()) throw BadMessage(problem);
  return payload;
}

}  // namespace waymark::json_messages
