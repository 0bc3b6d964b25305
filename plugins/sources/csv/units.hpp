// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/config/config.hpp"

/// Units of columns. A field's name ends in its unit (`heading_rad`, `range_m`); the YAML may name it with another unit
/// of the same kind (`heading_deg`, `range_mm`), or without one (`heading`), where the key `unit` says which it is.
namespace waymark::csv {

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;

/// A field as the YAML may name it.
struct FieldName {
  std::string_view name;  ///< "heading_rad"
  std::string_view unit;  ///< "rad", one that can be converted or any other; empty: none
};

/// The key that the YAML has for a field.
struct GivenKey {
  std::string key;          ///< "heading_deg"
  double factor = 1.0;      ///< the field's value of 1 in the unit of the key
  bool states_unit = true;  ///< false: the key `unit` must
  bool is_own_name = true;  ///< the field's name itself
};

/// The key of `columns` that names `field`; nothing if none does. Does not count as a read. Throws ConfigError if two
/// do.
std::optional<GivenKey> given_key(const Config& columns, const FieldName& field);

/// True if `key` names the field, in any of its units.
bool names_field(std::string_view key, const FieldName& field);

/// What a value in the unit that `key` of `settings` names ("deg/s" or "degps") is multiplied by, to be in `unit`.
/// Throws ConfigError for a unit of another kind.
double unit_factor(const Config& settings, const Config::Key& key, std::string_view unit);

/// The units that can be converted to `unit`, as a text: "rad, deg, mrad"; empty if there are none.
std::string units_like(std::string_view unit);

}  // namespace waymark::csv
