// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "waymark/base/time.hpp"

namespace waymark::diagnostics {

/// Stamps as numbers in a JSON document, to the nanosecond. The JSON library has no number beside double and integer,
/// so a stamp is a text in the document, and becomes a number in the document's text.
class ExactStamp {
 public:
  static nlohmann::ordered_json json(Time stamp) { return kMark + format_time(stamp); }

  /// The text of a document whose stamps are numbers.
  static std::string dump(const nlohmann::ordered_json& document) {
    // A bad record may quote bytes of the log that are not UTF-8.
    const std::string text = document.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    std::string out;
    out.reserve(text.size());
    std::size_t from = 0;
    for (std::size_t at = text.find(kDumped); at != std::string::npos; at = text.find(kDumped, from)) {
      out.append(text, from, at - from);
      const std::size_t begin = at + kDumped.size();
      const std::size_t end = text.find('"', begin);
      const std::string_view digits(text.data() + begin, end - begin);
      if (digits.find_first_not_of("-0123456789.") == std::string_view::npos) {
        out.append(shortest(digits));
      } else {
        out.append(text, at, end + 1 - at);
      }
      from = end + 1;
    }
    out.append(text, from);
    return out;
  }

 private:
  /// A control character begins no other text of the document.
  inline static const std::string kMark = "\x02";
  static constexpr std::string_view kDumped = "\"\\u0002";

  /// Without the zeros that say nothing; one digit after the point stays.
  static std::string_view shortest(std::string_view decimal) {
    while (decimal.ends_with('0') && !decimal.ends_with(".0")) decimal.remove_suffix(1);
    return decimal;
  }
};

}  // namespace waymark::diagnostics
