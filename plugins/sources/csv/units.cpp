// SPDX-License-Identifier: Apache-2.0
#include "units.hpp"

#include <algorithm>
#include <array>
#include <numbers>

#include "number_text.hpp"

namespace waymark::csv {
namespace {

constexpr double kStandardGravity = 9.80665;  // m/s², CGPM 1901

struct Unit {
  std::string_view kind;    // the unit of the payload's fields
  std::string_view word;    // in texts, and of the key `unit`
  std::string_view suffix;  // of names
  double factor;            // to the payload's
};

constexpr std::array kUnits{
    Unit{"m", "m", "m", 1.0},
    Unit{"m", "cm", "cm", 1e-2},
    Unit{"m", "mm", "mm", 1e-3},
    Unit{"m", "km", "km", 1e3},
    Unit{"m", "ft", "ft", 0.3048},
    Unit{"m/s", "m/s", "mps", 1.0},
    Unit{"m/s", "cm/s", "cmps", 1e-2},
    Unit{"m/s", "mm/s", "mmps", 1e-3},
    Unit{"m/s", "km/h", "kmh", 1.0 / 3.6},
    Unit{"m/s", "kn", "kn", 1852.0 / 3600.0},
    Unit{"m/s", "mph", "mph", 0.44704},
    Unit{"rad", "rad", "rad", 1.0},
    Unit{"rad", "deg", "deg", kRadPerDeg},
    Unit{"rad", "mrad", "mrad", 1e-3},
    Unit{"rad/s", "rad/s", "radps", 1.0},
    Unit{"rad/s", "deg/s", "degps", kRadPerDeg},
    Unit{"rad/s", "mrad/s", "mradps", 1e-3},
    Unit{"rad/s", "rpm", "rpm", std::numbers::pi / 30.0},
    Unit{"m/s²", "m/s2", "mps2", 1.0},
    Unit{"m/s²", "g", "g", kStandardGravity},
    Unit{"m/s²", "mg", "mg", 1e-3 * kStandardGravity},
    Unit{"T", "T", "t", 1.0},
    Unit{"T", "mT", "mt", 1e-3},
    Unit{"T", "uT", "ut", 1e-6},
    Unit{"T", "nT", "nt", 1e-9},
    Unit{"T", "G", "gauss", 1e-4},
    Unit{"T", "mG", "mgauss", 1e-7},
    Unit{"deg", "deg", "deg", 1.0},
    Unit{"deg", "rad", "rad", 1.0 / kRadPerDeg},
    Unit{"s", "s", "s", 1.0},
    Unit{"s", "ms", "ms", 1e-3},
    Unit{"s", "us", "us", 1e-6},
    Unit{"s", "ns", "ns", 1e-9},
};

/// The name without its unit; the name itself if it ends in none.
std::string_view stem_of(const FieldName& field) {
  for (const Unit& unit : kUnits) {
    if (unit.kind != field.unit || unit.factor != 1.0) continue;
    const std::size_t length = unit.suffix.size() + 1;
    if (field.name.size() > length && field.name.ends_with(unit.suffix) &&
        field.name[field.name.size() - length] == '_')
      return field.name.substr(0, field.name.size() - length);
  }
  return field.name;
}

/// `key` as a name of the field.
std::optional<GivenKey> as_name(std::string_view key, const FieldName& field) {
  if (key == field.name) return GivenKey{std::string(key), 1.0, true, true};
  const std::string_view stem = stem_of(field);
  if (!key.starts_with(stem)) return std::nullopt;
  if (key == stem) return GivenKey{std::string(key), 1.0, false, false};
  if (key[stem.size()] != '_') return std::nullopt;
  const std::string_view suffix = key.substr(stem.size() + 1);
  for (const Unit& unit : kUnits) {
    if (unit.kind == field.unit && unit.suffix == suffix) return GivenKey{std::string(key), unit.factor, true, false};
  }
  return std::nullopt;
}

}  // namespace

std::optional<GivenKey> given_key(const Config& columns, const FieldName& field) {
  std::optional<GivenKey> found;
  for (const std::string& key : columns.keys()) {
    auto name = as_name(key, field);
    if (!name) continue;
    if (found) columns.fail(key, "give either " + found->key + " or " + key + ": both are the same field");
    found = std::move(name);
  }
  return found;
}

bool names_field(std::string_view key, const FieldName& field) { return as_name(key, field).has_value(); }

double unit_factor(const Config& settings, const Config::Key& key, std::string_view unit) {
  const std::string word = settings.text(key);
  for (const Unit& one : kUnits) {
    if (one.kind == unit && (one.word == word || one.suffix == word)) return one.factor;
  }
  const std::string units = units_like(unit);
  if (units.empty()) settings.fail(key.name, "this field has no unit that could be another one");
  settings.fail(key.name, in_quotes(word) + " is not a unit of this field; one of " + units + " is expected");
}

std::string units_like(std::string_view unit) {
  std::string list;
  for (const Unit& one : kUnits) {
    if (one.kind == unit) list.append(list.empty() ? "" : ", ").append(one.word);
  }
  return list;
}

}  // namespace waymark::csv
