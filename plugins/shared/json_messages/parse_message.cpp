// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "plugins/shared/json_messages/message.hpp"
#include "waymark/base/error.hpp"

namespace waymark::json_messages {
namespace {

using nlohmann::json;

/// Builds a message from what the parser reports, value by value; so a line cannot demand more memory than its own
/// length explains, and the stamp is read from its text. Throws BadMessage from any call.
class Builder final : public nlohmann::json_sax<json> {
 public:
  Message take() {
    if (!has_sensor_) throw BadMessage("it names no \"sensor\"");
    return std::move(message_);
  }

  bool null() override { return scalar(std::monostate()); }
  bool boolean(bool value) override { return scalar(value); }
  bool number_integer(std::int64_t value) override { return integer(value); }
  bool number_unsigned(std::uint64_t value) override {
    if (value > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
      if (is_top_key("stamp") || is_top_key("stamp_ns"))
        throw BadMessage(fmt::format("{} {} is beyond int64 nanoseconds", key_, value));
      return scalar(static_cast<double>(value));
    }
    return integer(static_cast<std::int64_t>(value));
  }
  bool number_float(double value, const std::string& text) override {
    if (is_top_key("stamp")) return stamp(text);
    return scalar(value);
  }
  bool string(std::string& value) override { return scalar(std::move(value)); }
  bool binary(json::binary_t&) override { throw BadMessage("binary values are not JSON"); }

  bool start_object(std::size_t) override {
    if (level_ == Level::list) {
      require_kind(Kind::elements);
      list().elements.emplace_back();
      level_ = Level::element;
    } else if (level_ == Level::outside) {
      level_ = Level::top;
    } else {
      throw BadMessage(fmt::format("\"{}\" is an object; a number, a word or a list is expected", printable(key_)));
    }
    return true;
  }
  bool key(std::string& name) override {
    key_ = std::move(name);
    const bool at_top = level_ == Level::top;
    const auto is_same = [this](const auto& field) { return field.first == key_; };
    const std::size_t count = at_top ? message_.fields.size() : list().elements.back().size();
    const bool repeated = at_top ? std::ranges::any_of(message_.fields, is_same) || (key_ == "sensor" && has_sensor_)
                                 : std::ranges::any_of(list().elements.back(), is_same);
    if (repeated) throw BadMessage(fmt::format("\"{}\" comes twice", printable(key_)));
    if (count >= kMostKeys) throw BadMessage(fmt::format("an object has more than {} keys", kMostKeys));
    return true;
  }
  bool end_object() override {
    level_ = level_ == Level::element ? Level::list : Level::outside;
    return true;
  }
  bool start_array(std::size_t) override {
    if (level_ == Level::list) {
      require_kind(Kind::points);
      list().holds_points = true;
      level_ = Level::point;
      point_start_ = list().numbers.size();
    } else if (level_ == Level::top && !is_reserved()) {
      message_.fields.emplace_back(std::exchange(key_, {}), List());
      level_ = Level::list;
      kind_ = Kind::any;
    } else if (level_ == Level::outside) {
      throw BadMessage("it is a list; an object {\"sensor\": …} is expected");
    } else {
      throw BadMessage("it is nested too deep");
    }
    return true;
  }
  bool end_array() override {
    if (level_ == Level::point) {
      constexpr std::size_t kAxes = 3;
      const std::size_t count = list().numbers.size() - point_start_;
      if (count != kAxes) throw BadMessage(fmt::format("a point has {} numbers; x, y, z are expected", count));
      level_ = Level::list;
    } else {
      level_ = Level::top;
    }
    return true;
  }
  [[noreturn]] bool parse_error(std::size_t position, const std::string&,
                                const nlohmann::detail::exception& error) override {
    // "[json.exception.parse_error.101] parse error at line 1, column 3: syntax error …"
    std::string_view text = error.what();
    const std::size_t place = text.find(": ");
    if (place != std::string_view::npos) text.remove_prefix(place + 2);
    constexpr std::size_t kLongest = 160;
    throw BadMessage(fmt::format("no JSON at byte {}: {}", position, printable(text, kLongest)));
  }

 private:
  enum class Level { outside, top, list, point, element };
  enum class Kind { any, numbers, points, elements };

  List& list() { return std::get<List>(message_.fields.back().second); }
  bool is_top_key(std::string_view name) const { return level_ == Level::top && key_ == name; }
  bool is_reserved() const { return key_ == "sensor" || key_ == "stamp" || key_ == "stamp_ns"; }

  void require_kind(Kind kind) {
    if (kind_ == Kind::any) kind_ = kind;
    if (kind_ != kind)
      throw BadMessage(fmt::format("\"{}\" is a list of different things", printable(message_.fields.back().first)));
  }

  void set_stamp(Time stamp) {
    if (message_.stamp) throw BadMessage("it has two stamps");
    message_.stamp = stamp;
  }
  bool stamp(std::string_view seconds) {
    try {
      set_stamp(parse_time(seconds));
    } catch (const DataError& error) {
      throw BadMessage(fmt::format("stamp {}", printable(error.what(), 100)));
    }
    return true;
  }

  bool integer(std::int64_t value) {
    if (is_top_key("stamp")) return stamp(std::to_string(value));
    if (is_top_key("stamp_ns")) {
      const auto stamp = moved(Time{}, Duration(value));
      if (!stamp) throw BadMessage(fmt::format("stamp_ns {} lies more than 146 years from the epoch", value));
      set_stamp(*stamp);
      return true;
    }
    return scalar(value);
  }

  bool scalar(Scalar value) {
    switch (level_) {
      case Level::outside:
        throw BadMessage("it is a single value; an object {\"sensor\": …} is expected");
      case Level::top:
        if (!take_reserved(value)) message_.fields.emplace_back(std::exchange(key_, {}), std::move(value));
        break;
      case Level::element:
        list().elements.back().emplace_back(std::exchange(key_, {}), std::move(value));
        break;
      case Level::list:
        require_kind(Kind::numbers);
        [[fallthrough]];
      case Level::point:
        list().numbers.push_back(number_of(value));
    }
    return true;
  }

  bool take_reserved(Scalar& value) {
    if (!is_reserved()) return false;
    if (key_ == "sensor") {
      if (!std::holds_alternative<std::string>(value)) throw BadMessage("\"sensor\" is not text");
      message_.sensor = std::move(std::get<std::string>(value));
      has_sensor_ = true;
    } else if (!std::holds_alternative<std::monostate>(value)) {
      throw BadMessage(fmt::format("{} is not {}", key_, key_ == "stamp" ? "a number" : "an integer"));
    }
    return true;
  }

  double number_of(const Scalar& value) const {
    if (const auto* number = std::get_if<double>(&value)) return *number;
    if (const auto* number = std::get_if<std::int64_t>(&value)) return static_cast<double>(*number);
    if (std::holds_alternative<std::monostate>(value)) return std::numeric_limits<double>::quiet_NaN();
    throw BadMessage(fmt::format("an element of \"{}\" is not a number", printable(message_.fields.back().first)));
  }

  Message message_;
  Level level_ = Level::outside;
  Kind kind_ = Kind::any;
  std::string key_;
  std::size_t point_start_ = 0;
  bool has_sensor_ = false;
};

}  // namespace

std::string printable(std::string_view text, std::size_t longest) {
  constexpr char kFirst = ' ';
  constexpr char kLast = '~';
  std::string result(text.substr(0, longest));
  std::ranges::replace_if(
      result, [](char c) { return c < kFirst || c > kLast; }, '?');
  if (text.size() > longest) result += "...";
  return result;
}

Message parse_message(std::string_view line) {
  Builder builder;
  json::sax_parse(line.begin(), line.end(), &builder);
  return builder.take();
}

}  // namespace waymark::json_messages
