// SPDX-License-Identifier: Apache-2.0
#include "earth_field.hpp"

#include <GeographicLib/MagneticModel.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "model_files.hpp"
#include "waymark/base/error.hpp"

namespace waymark::magnetic_model {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kTesla = 1e-9;  // of a nanotesla
constexpr const char* kShipped = "wmm2025";

/// One decimal is enough to see what is wrong.
std::string year_text(double year) {
  const auto tenths = static_cast<long>(std::floor(10.0 * year));
  return std::to_string(tenths / 10) + "." + std::to_string(std::abs(tenths % 10));
}

std::filesystem::path find_model(const Config& config) {
  if (config.has("magnetic_model")) {
    const std::filesystem::path file = config.text({"magnetic_model", "",
                                                    "for `declination: auto`: a `.wmm` file beside its `.wmm.cof`, for "
                                                    "another time than the shipped model's; relative to the YAML",
                                                    "the one shipped"});
    return file.is_absolute() ? file : config.file().parent_path() / file;
  }
  std::string tried;
  for (const auto& folder : model_folders()) {
    std::filesystem::path file = folder / (std::string(kShipped) + ".wmm");
    std::error_code none;
    if (std::filesystem::exists(file, none)) return file;
    tried += (tried.empty() ? "" : ", ") + folder.string();
  }
  config.fail("declination", std::string("auto needs the magnetic model ") + kShipped + ".wmm, which is in none of " +
                                 tried + "; set WAYMARK_MAGNETIC_MODEL to its folder, or declination_deg");
}

}  // namespace

class EarthField::Model {
 public:
  explicit Model(const std::filesystem::path& file)
      : model_(file.stem().string(), file.parent_path().string(), GeographicLib::Geocentric::WGS84()) {}

  Field at(double year, const Datum& place) const {
    if (year < model_.MinTime() || year > model_.MaxTime()) {
      throw DataError("the magnetic model " + model_.MagneticModelName() + " holds from " +
                      year_text(model_.MinTime()) + " to " + year_text(model_.MaxTime()) + ", the measurement is of " +
                      year_text(year) +
                      ": give declination_deg instead of `declination: auto`, or the model of that time as "
                      "magnetic_model");
    }
    double east = 0.0;
    double north = 0.0;
    double up = 0.0;
    model_(year, place.latitude_deg, place.longitude_deg, place.height_m, east, north, up);
    const double horizontal = std::hypot(east, north);
    return {std::atan2(east, north), kTesla * std::hypot(horizontal, up), std::atan2(-up, horizontal)};
  }

 private:
  GeographicLib::MagneticModel model_;
};

EarthField::EarthField(const Config& config, std::optional<double> fallback) {
  const Config::Key degrees{
      "declination_deg", "°",
      "declination of the magnetic field, east positive: magnetic north lies so far east of true north",
      fallback ? "" : "from `declination`"};
  const bool in_degrees = config.has(degrees.name);
  const bool in_words = config.has("declination");
  if (in_degrees && in_words) config.fail("declination", "give this or declination_deg, not both");
  if (!in_words) {
    if (!in_degrees && !fallback) {
      config.fail("declination", "a compass shows magnetic north: give declination_deg, or auto, or none");
    }
    field_.declination = kDegree * (fallback ? config.number_in(degrees, -180.0, 180.0, *fallback)
                                             : config.number_in(degrees, -180.0, 180.0));
    return;
  }
  if (config.choice({"declination", "",
                     "`auto`: from the World Magnetic Model, by the measurement's stamp (UTC) and the datum; `none`: "
                     "headings count from true north already",
                     "from `declination_deg`"},
                    {"auto", "none"}) == "none") {
    from_true_north_ = true;
    return;
  }
  const auto file = find_model(config);
  try {
    model_ = std::make_shared<const Model>(file);
  } catch (const std::exception& error) {  // GeographicErr, or of the standard library
    config.fail(config.has("magnetic_model") ? "magnetic_model" : "declination",
                file.string() + " is not a magnetic model that can be read: " + error.what());
  }
}

const Field& EarthField::at(Time stamp, const Datum* datum) {
  if (!model_) return field_;
  const Time day = std::chrono::floor<std::chrono::days>(stamp);
  const bool same_place = datum != nullptr && datum->latitude_deg == place_.latitude_deg &&
                          datum->longitude_deg == place_.longitude_deg && datum->height_m == place_.height_m;
  if (day_ == day && same_place) return field_;
  field_ = std::as_const(*this).at(stamp, datum);
  day_ = day;
  place_ = *datum;
  return field_;
}

Field EarthField::at(Time stamp, const Datum* datum) const {
  if (!model_) return field_;
  if (datum == nullptr) {
    throw DataError("`declination: auto` needs the place: set `datum`, or wait for a geodetic fix");
  }
  return model_->at(decimal_year(std::chrono::floor<std::chrono::days>(stamp)), *datum);
}

double decimal_year(Time utc) {
  namespace chrono = std::chrono;
  const chrono::year_month_day date(chrono::floor<chrono::days>(utc));
  const chrono::sys_days begin = date.year() / chrono::January / 1;
  const chrono::sys_days end = (date.year() + chrono::years(1)) / chrono::January / 1;
  return static_cast<int>(date.year()) + chrono::duration<double>(utc - begin) / chrono::duration<double>(end - begin);
}

}  // namespace waymark::magnetic_model
