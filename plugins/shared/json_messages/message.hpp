// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "plugins/shared/json_messages/bad_message.hpp"
#include "waymark/base/time.hpp"

namespace waymark::json_messages {

/// A value that is not a list. Null is `std::monostate`.
using Scalar = std::variant<std::monostate, bool, std::int64_t, double, std::string>;
/// An element of a list with fields of its own.
using Element = std::vector<std::pair<std::string, Scalar>>;

/// A list of numbers, of points, or of elements; empty: any of them.
struct List {
  std::vector<double> numbers;  ///< null is NaN; of points x, y, z in turn
  std::vector<Element> elements;
  bool holds_points = false;
};

/// One message, as it was written: `{"sensor": "wheels", "stamp": 1700000000.25, "left_mps": 1.0, …}`.
struct Message {
  using Value = std::variant<Scalar, List>;

  std::string sensor;
  std::optional<Time> stamp;  ///< nothing: unknown
  std::vector<std::pair<std::string, Value>> fields;
};

/// Most keys of an object.
inline constexpr std::size_t kMostKeys = 64;

/// Reads a line. Takes memory in proportion to the line. Throws BadMessage.
Message parse_message(std::string_view line);

}  // namespace waymark::json_messages
