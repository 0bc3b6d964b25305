// SPDX-License-Identifier: Apache-2.0
#include "payload_builders.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <vector>

#include "field_columns.hpp"
#include "image_builder.hpp"
#include "motion_builder.hpp"
#include "number_text.hpp"
#include "registered_builder.hpp"
#include "scan_builder.hpp"
#include "waymark/config/source_config.hpp"
#include "waymark/interface/payload_registry.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::csv {
namespace {

constexpr std::array<std::string_view, 14> kTypes = {
    WheelSpeeds::kType,    WheelSteering::kType, BodyTwist::kType, PoseIncrement::kType,
    GnssFix::kType,        LaserScan::kType,     Image::kType,     ImuSample::kType,
    CompassHeading::kType, MagneticField::kType, Height::kType,    LandmarkObservations::kType,
    Ranges::kType,         RadarTargets::kType};

/// Those of `kTypes`, and all that plugins have registered.
std::vector<std::string_view> readable_types() {
  std::vector<std::string_view> types(kTypes.begin(), kTypes.end());
  for (const KnownPayload& known : known_payloads()) {
    if (!is_of_core(known.type)) types.push_back(known.type);
  }
  return types;
}

/// Payloads of which one row holds all fields.
template <class T>
class FieldsBuilder final : public PayloadBuilder {
 public:
  /// What a row holds: values of one instant; or rates, which may be the mean of an interval; or such rates alone, of
  /// which a log may hold the totals instead.
  enum class Kind { instant, rates, speeds };
  FieldsBuilder(const Config& columns, ColumnFinder& finder, Kind kind = Kind::instant)
      : fields_(columns, short_type_name(T::kType), finder), kind_(kind) {}

  std::shared_ptr<Payload> build(Row row) const override {
    auto payload = std::make_shared<T>();
    fields_.read(row, *payload);
    return payload;
  }

  Totals totals() const override { return kind_ == Kind::speeds ? Totals::speed : Totals::none; }
  bool has_interval() const override { return kind_ != Kind::instant; }
  /// A mean is true in the middle.
  std::optional<Duration> stamp_before_end(Payload&, std::optional<Duration> since_last) const override {
    return since_last ? std::optional(*since_last / 2) : std::nullopt;
  }

  std::shared_ptr<Payload> growth(const Payload& before, const Payload& after, double seconds,
                                  double wraps_at) const override {
    auto payload = std::make_shared<T>();
    fields_.growth(static_cast<const T&>(before), static_cast<const T&>(after), seconds, wraps_at, *payload);
    return payload;
  }

 private:
  FieldColumns<T> fields_;
  Kind kind_;
};

void require_position(const Config& columns) {
  FieldColumns<GnssFix>::check_names(columns, short_type_name(GnssFix::kType));
  const auto has = [&](std::string_view name, std::string_view unit) {
    return columns.has(name) || given_key(columns, {name, unit}).has_value();
  };
  const bool local = has("east_m", "m") && has("north_m", "m");
  const bool geodetic = has("latitude_deg", "deg") && has("longitude_deg", "deg");
  if (!local && !geodetic) {
    columns.fail("GnssFix needs the columns \"east_m\" and \"north_m\", or \"latitude_deg\" and \"longitude_deg\"");
  }
}

/// Motions that are given as such.
class IncrementBuilder final : public PayloadBuilder {
 public:
  /// `at_end`: the stamp is that of the interval's end, whose length need not be a column.
  IncrementBuilder(const Config& columns, ColumnFinder& finder, bool at_end)
      : fields_(columns, short_type_name(PoseIncrement::kType), finder, at_end ? "interval_s" : ""),
        has_length_(given_key(columns, {"interval_s", "s"}).has_value()) {}

  std::shared_ptr<Payload> build(Row row) const override {
    auto motion = std::make_shared<PoseIncrement>();
    fields_.read(row, *motion);
    return motion;
  }
  bool has_interval() const override { return true; }
  std::optional<Duration> stamp_before_end(Payload& payload, std::optional<Duration> since_last) const override {
    auto& motion = static_cast<PoseIncrement&>(payload);
    if (!has_length_) {
      if (!since_last) return std::nullopt;
      motion.interval_s = to_seconds(*since_last);
    }
    return from_seconds(motion.interval_s);
  }

 private:
  FieldColumns<PoseIncrement> fields_;
  bool has_length_;
};

/// Payloads that are a set, of which a row holds one element.
template <class T, auto list>
class SetBuilder final : public PayloadBuilder {
 public:
  SetBuilder(const Config& columns, ColumnFinder& finder)
      : fields_(columns, short_type_name(T::kType), finder), sets_may_be_empty_(finder.allows_empty()) {}

  std::shared_ptr<Payload> build(Row row) const override {
    auto set = std::make_shared<T>();
    append(row, *set);
    return set;
  }

  void append(Row row, Payload& payload) const override {
    if (sets_may_be_empty_ && fields_.required_are_empty(row)) return;
    typename T::One one;
    fields_.read(row, one);
    (static_cast<T&>(payload).*list).push_back(one);
  }

  bool can_append() const override { return true; }

 private:
  FieldColumns<typename T::One> fields_;
  bool sets_may_be_empty_;
};

/// A truth value, or a mapping for totals that begin anew.
Config::Key cumulative_key() {
  return {"cumulative",
          "the columns hold totals since the start, of `PoseIncrement`, `WheelSpeeds` or `BodyTwist`; `{ wraps_at: "
          "65536 }`: raw totals begin anew there"};
}

}  // namespace

void PayloadBuilder::append(Row, Payload&) const { assert(false && "only a builder with can_append() forms sets"); }

std::shared_ptr<Payload> PayloadBuilder::growth(const Payload&, const Payload&, double, double) const {
  assert(false && "only for a builder that has totals()");
  return nullptr;
}

std::optional<Duration> PayloadBuilder::stamp_before_end(Payload&, std::optional<Duration>) const {
  assert(false && "only for a builder that has_interval()");
  return std::nullopt;
}

std::string_view payload_type(const Config& entry) {
  std::string meaning = "what the rows hold";
  for (const std::string_view type : kTypes)
    meaning.append(type == kTypes.front() ? ": `" : ", `").append(short_type_name(type)).append("`");
  meaning += "; or a payload that a plugin of the robot registers";
  const std::string name = entry.text({"payload", meaning});
  const std::vector<std::string_view> types = readable_types();
  const std::string_view asked = find_payload_type(name);
  if (std::ranges::find(types, asked) != types.end()) return asked;
  std::vector<std::string_view> names;
  names.reserve(types.size());
  for (const std::string_view type : types) names.push_back(short_type_name(type));
  entry.fail("payload", "there is no payload " + in_quotes(name) + suggestion(name, names));
}

bool holds_totals(const Config& entry) {
  return entry.is_mapping("cumulative") || entry.boolean(cumulative_key(), false);
}

double totals_wrap_at(const Config& entry) {
  if (!entry.is_mapping("cumulative")) return 0.0;
  return entry.child(cumulative_key()).positive({"wraps_at", "raw totals begin anew there"});
}

bool ends_interval(const Config& entry) {
  return entry.boolean(
      {"end_of_interval",
       "the stamp is the end of the interval that a row describes: a `PoseIncrement` begins `interval_s` before it, or "
       "at the row before if that has no column; speeds and rates are the mean since the row before, true in the "
       "middle; the last beam of a `LaserScan` is at the stamp"},
      false);
}

std::unique_ptr<PayloadBuilder> make_payload_builder(std::string_view type, const Config& entry, ColumnFinder& finder) {
  const Config columns = entry.child({"columns",
                                      "which column goes to which field of the payload: a number, counted from 0, or a "
                                      "name from the header; or `{ column, unit, scale, offset }`; or `{ constant }`"});
  if (type == WheelSpeeds::kType) {
    using Builder = FieldsBuilder<WheelSpeeds>;
    return std::make_unique<Builder>(columns, finder, Builder::Kind::speeds);
  }
  if (type == WheelSteering::kType) {
    using Builder = FieldsBuilder<WheelSteering>;
    return std::make_unique<Builder>(columns, finder, Builder::Kind::rates);
  }
  if (type == BodyTwist::kType) {
    using Builder = FieldsBuilder<BodyTwist>;
    return std::make_unique<Builder>(columns, finder, Builder::Kind::speeds);
  }
  if (type == PoseIncrement::kType) {
    if (holds_totals(entry)) return std::make_unique<MotionBuilder>(entry, columns, finder);
    return std::make_unique<IncrementBuilder>(columns, finder, ends_interval(entry));
  }
  if (type == GnssFix::kType) {
    require_position(columns);
    return std::make_unique<FieldsBuilder<GnssFix>>(columns, finder);
  }
  if (type == LaserScan::kType) {
    if (BeamBuilder::is_meant(columns)) return std::make_unique<BeamBuilder>(entry, columns, finder);
    return std::make_unique<ScanBuilder>(entry, columns, finder);
  }
  if (type == ImuSample::kType) {
    using Builder = FieldsBuilder<ImuSample>;
    return std::make_unique<Builder>(columns, finder, Builder::Kind::rates);
  }
  if (type == CompassHeading::kType) return std::make_unique<FieldsBuilder<CompassHeading>>(columns, finder);
  if (type == MagneticField::kType) return std::make_unique<FieldsBuilder<MagneticField>>(columns, finder);
  if (type == Height::kType) return std::make_unique<FieldsBuilder<Height>>(columns, finder);
  if (type == Image::kType) {
    return std::make_unique<ImageBuilder>(columns, readable_file(entry, "path").parent_path(), finder);
  }
  if (type == Ranges::kType) return std::make_unique<SetBuilder<Ranges, &Ranges::ranges>>(columns, finder);
  if (type == RadarTargets::kType) {
    return std::make_unique<SetBuilder<RadarTargets, &RadarTargets::targets>>(columns, finder);
  }
  if (type == LandmarkObservations::kType) {
    return std::make_unique<SetBuilder<LandmarkObservations, &LandmarkObservations::landmarks>>(columns, finder);
  }
  return std::make_unique<RegisteredBuilder>(type, columns, finder);
}

}  // namespace waymark::csv
