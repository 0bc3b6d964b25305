// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/parameter.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <span>
#include <string_view>
#include <utility>

#include "apps/waymark/calibration/magnetometer.hpp"
#include "waymark/base/error.hpp"

namespace waymark::calibration {

namespace {

using Kind = Parameter::Kind;

/// One row of what plugins have to offer.
struct Offer {
  std::string_view key;
  int element;
  int elements;
  std::string_view unit;
  Kind kind;
  double prior_sigma;
  std::vector<double> fallback;  ///< where the YAML leaves the key out; empty: then it is not estimated
};

// Priors: what a careful owner with a tape measure achieves, times three or so.
Offer value(std::string_view key, std::string_view unit, double prior_sigma, std::vector<double> fallback = {}) {
  return {key, -1, 1, unit, Kind::value, prior_sigma, std::move(fallback)};
}
Offer element(std::string_view key, int at, std::string_view unit, double prior_sigma,
              std::vector<double> fallback = {}) {
  return {key, at, 1, unit, Kind::value, prior_sigma, std::move(fallback)};
}
/// Known to 10 %.
Offer length(std::string_view key) { return {key, -1, 1, "m", Kind::factor, 0.1, {}}; }
/// Known up to a factor of e². `count` elements of a list from `first` on; a number if that is negative.
Offer noise(std::string_view key, int first, int count, std::string_view unit, std::vector<double> fallback = {}) {
  return {key, first, count, unit, Kind::noise, 2.0, std::move(fallback)};
}
Offer delay() { return value("delay_s", "s", 0.15, {0.0}); }
Offer yaw() { return value("base_T_sensor.yaw_deg", "°", 10.0, {0.0}); }

/// The default of `yaw_noise_rad_per_sqrt_s`, which goes with the model.
std::vector<double> usual_yaw_noise(const Config& wheels) {
  if (wheels.has("track_m")) {
    const double noise = 0.015 / wheels.number("track_m");
    return {noise, noise, 0.2};
  }
  if (wheels.has("wheelbase_m")) return {0.0, 0.01, 0.05};
  return {0.03, 0.03, 0.2};
}

std::vector<Offer> offers_of_wheels(const Config& wheels) {
  std::vector<Offer> offers{value("speed_scale", "", 0.1, {1.0}), value("curvature_per_m", "1/m", 0.1, {0.0})};
  if (wheels.has("track_m")) {
    offers.push_back(length("track_m"));
  } else if (wheels.has("wheelbase_m")) {
    offers.push_back(length("wheelbase_m"));
  } else {
    offers.push_back(value("yaw_scale", "", 0.1, {1.0}));
  }
  offers.push_back(noise("speed_noise_m_per_sqrt_s", 0, 2, "m/√s", {0.02, 0.05}));
  offers.push_back(noise("lateral_noise_m_per_sqrt_s", 0, 2, "m/√s", {0.0, 0.1}));
  // The share that grows with the rate is a parameter of its own: too large, it forgets the heading within a turn, and
  // then the turn looks shorter than the wheels say, since their noise is in the rotation that they give (errors in
  // variables).
  offers.push_back(noise("yaw_noise_rad_per_sqrt_s", 0, 2, "rad/√s", usual_yaw_noise(wheels)));
  offers.push_back(noise("yaw_noise_rad_per_sqrt_s", 2, 1, "√s", usual_yaw_noise(wheels)));
  return offers;
}

/// What of a sensor can be estimated, by its plugin and keys. Without a plugin it feeds maps.
std::vector<Offer> offers_of(const Config& sensor, const std::string& plugin) {
  if (plugin.empty()) {
    if (!sensor.has("payload") || sensor.text("payload").find("LaserScan") == std::string::npos) return {};
    std::vector<Offer> offers{delay()};
    if (sensor.has("base_T_sensor")) {
      offers.push_back(yaw());
      for (const int axis : {0, 1}) offers.push_back(element("base_T_sensor.xyz_m", axis, "m", 0.3, {0.0, 0.0, 0.0}));
    }
    return offers;
  }
  if (plugin == "odometry") return offers_of_wheels(sensor);
  if (plugin == "dgps") {
    std::vector<Offer> offers{delay(), noise("sigma_m", -1, 1, "m")};
    if (sensor.has("base_p_antenna_m") && sensor.is_list("base_p_antenna_m")) {
      for (const int axis : {0, 1}) offers.push_back(element("base_p_antenna_m", axis, "m", 0.5));
    }
    offers.push_back(noise("offset_sigma_m", -1, 1, "m"));
    return offers;
  }
  if (plugin == "compass") {
    std::vector<Offer> offers{delay(), noise("sigma_deg", -1, 1, "°", {5.0})};
    if (sensor.has("base_T_sensor")) offers.push_back(yaw());
    return offers;
  }
  if (plugin == "imu") return {delay()};
  return {};
}

/// The node that holds a dotted key, and the key's last part.
std::pair<Config, std::string> find(const Config& sensor, std::string_view key) {
  Config node = sensor;
  while (true) {
    const std::size_t dot = key.find('.');
    if (dot == std::string_view::npos) return {node, std::string(key)};
    node = node.child_or_empty(key.substr(0, dot));
    key.remove_prefix(dot + 1);
  }
}

Config sensor_named(const Config& yaml, const std::string& name) {
  for (const Config& sensor : yaml.items("sensors")) {
    if (sensor.text("name") == name) return sensor;
  }
  throw Error(fmt::format("there is no sensor {}", name));
}

std::string plugin_of(const Config& sensor) { return sensor.has("plugin") ? sensor.text("plugin") : std::string(); }

bool is_wanted(const Parameter& parameter, const std::vector<std::string>& only) {
  return only.empty() ||
         std::ranges::any_of(only, [&](const std::string& word) { return parameter.name().starts_with(word); });
}

/// True if one of these keys of a sensor is wanted, which are not adjusted but read from the log directly.
bool wants_one(const std::string& sensor, std::initializer_list<const char*> keys,
               const std::vector<std::string>& only) {
  return std::ranges::any_of(keys, [&](const char* key) {
    Parameter parameter;
    parameter.sensor = sensor;
    parameter.key = key;
    return is_wanted(parameter, only);
  });
}

/// Keys that are read from the log directly.
constexpr std::initializer_list<const char*> kOfImu{kGyroNoise, kGravity};
constexpr std::initializer_list<const char*> kOfField{kHardIron, kSoftIron};

/// An IMU takes part if it hands on the heading of its field.
bool has_magnetometer(const Config& sensor, const std::string& plugin) {
  return plugin == "compass" || (plugin == "imu" && sensor.has("heading") && sensor.boolean("heading", false));
}

/// The elements of a list that a factor scales.
template <class Number>
std::span<Number> scaled_by(const Parameter& parameter, std::span<Number> list) {
  if (parameter.element < 0) return list;
  const std::size_t first = std::min(static_cast<std::size_t>(parameter.element), list.size());
  return list.subspan(first, std::min(static_cast<std::size_t>(parameter.elements), list.size() - first));
}

const Offer* offer_of(const std::vector<Offer>& offers, const Parameter& parameter) {
  const auto found = std::ranges::find_if(offers, [&](const Offer& offer) { return offer.key == parameter.key; });
  return found == offers.end() ? nullptr : &*found;
}

}  // namespace

double number_of(const Config& yaml, const std::string& sensor, const char* key, double fallback) {
  const Config block = sensor_named(yaml, sensor);
  return block.has(key) ? block.number(key) : fallback;
}

std::string Parameter::name() const {
  if (element < 0) return fmt::format("{}.{}", sensor, key);
  if (elements == 1) return fmt::format("{}.{}[{}]", sensor, key, element);
  return fmt::format("{}.{}[{}..{}]", sensor, key, element, element + elements - 1);
}

Values::Values(const Config& yaml, const std::vector<Parameter>& parameters) : parameters_(parameters) {
  for (const Parameter& parameter : parameters_) {
    const std::string path = fmt::format("sensors.{}.{}", parameter.sensor, parameter.key);
    const Config sensor = sensor_named(yaml, parameter.sensor);
    const std::vector<Offer> offers = offers_of(sensor, plugin_of(sensor));
    const std::vector<double> fallback = offer_of(offers, parameter)->fallback;
    const auto [node, key] = find(sensor, parameter.key);
    const bool is_list = node.has(key) ? node.is_list(key) : fallback.size() > 1;
    is_list_[path] = is_list;
    if (is_list) {
      numbers_[path] = node.has(key) ? node.numbers(key) : fallback;
    } else {
      numbers_[path] = {node.has(key) ? node.number(key) : fallback.at(0)};
    }
  }
}

std::vector<double> Values::given(std::size_t i) const {
  const Parameter& parameter = parameters_[i];
  const std::vector<double>& numbers = numbers_.at(fmt::format("sensors.{}.{}", parameter.sensor, parameter.key));
  const std::span<const double> scaled = scaled_by(parameter, std::span(numbers));
  return {scaled.begin(), scaled.end()};
}

double Values::value(std::size_t i, double delta) const {
  const Parameter& parameter = parameters_[i];
  const std::vector<double>& numbers = numbers_.at(fmt::format("sensors.{}.{}", parameter.sensor, parameter.key));
  if (parameter.kind == Kind::value) return numbers[static_cast<std::size_t>(std::max(parameter.element, 0))] + delta;
  const std::span<const double> scaled = scaled_by(parameter, std::span(numbers));
  const auto found = std::ranges::find_if(scaled, [](double one) { return one != 0.0; });
  return found == scaled.end() ? 0.0 : *found * std::exp(delta);
}

std::vector<Config::Override> Values::changed(const Eigen::VectorXd& delta) const {
  std::map<std::string, std::vector<double>> numbers = numbers_;
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    const Parameter& parameter = parameters_[i];
    std::vector<double>& list = numbers[fmt::format("sensors.{}.{}", parameter.sensor, parameter.key)];
    const double d = delta(static_cast<Eigen::Index>(i));
    if (parameter.kind == Kind::value) {
      list[static_cast<std::size_t>(std::max(parameter.element, 0))] += d;
    } else {
      for (double& one : scaled_by(parameter, std::span(list))) one *= std::exp(d);
    }
  }
  std::vector<Config::Override> overrides;
  overrides.reserve(numbers.size());
  for (const auto& [path, list] : numbers) {
    overrides.push_back(is_list_.at(path) ? fmt::format("{}=[{}]", path, fmt::join(list, ", "))
                                          : fmt::format("{}={}", path, list[0]));
  }
  return overrides;
}

Plan plan_for(const Config& yaml, const std::vector<std::string>& only) {
  Plan plan;
  // A changed delay changes the order of the measurements; the filter puts them in order again.
  plan.overrides = {"filter.max_latency_s=1", "filter.history_s=0", "filter.smooth=false", "clock.max_ahead_s=5",
                    "sinks=[]"};
  // The wheels hold the path together, and scans are compared in pairs.
  if (yaml.has("maps")) plan.overrides.emplace_back("maps=[]");
  for (const Config& sensor : yaml.items("sensors")) {
    if (sensor.has("enabled") && !sensor.boolean("enabled", true)) continue;
    const std::string name = sensor.text("name");
    const std::string plugin = plugin_of(sensor);
    if (!plugin.empty()) {
      plan.overrides.push_back(fmt::format("sensors.{}.gate_probability=0.999999999999", name));
      plan.overrides.push_back(fmt::format("sensors.{}.max_consecutive_rejections=0", name));
    }
    std::vector<Parameter> all;
    for (const Offer& offer : offers_of(sensor, plugin)) {
      const auto [node, key] = find(sensor, offer.key);
      if (!node.has(key) && offer.fallback.empty()) continue;
      all.push_back({name, std::string(offer.key), offer.element, offer.elements, std::string(offer.unit), offer.kind,
                     offer.prior_sigma});
    }
    // A factor changes nothing of a zero.
    const Values values(yaml, all);
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (all[i].kind != Kind::value && !(values.value(i, 0.0) > 0.0)) continue;
      if (is_wanted(all[i], only)) {
        plan.parameters.push_back(all[i]);
      } else if (all[i].kind == Kind::noise) {
        plan.others.push_back(all[i]);
      }
    }
    if (plugin == "imu" && wants_one(name, {kGravity}, only)) plan.accelerometers.push_back(name);
    if (plugin == "imu" && wants_one(name, kOfImu, only)) plan.imus.push_back(name);
    if (has_magnetometer(sensor, plugin) && wants_one(name, kOfField, only)) plan.magnetometers.push_back(name);
  }
  for (const std::string& word : only) {
    const auto begins_so = [&](const Parameter& one) { return one.name().starts_with(word); };
    const auto is_of_imu = [&](const std::string& imu) { return wants_one(imu, kOfImu, {word}); };
    const auto is_of_field = [&](const std::string& sensor) { return wants_one(sensor, kOfField, {word}); };
    if (std::ranges::any_of(plan.parameters, begins_so) || std::ranges::any_of(plan.imus, is_of_imu) ||
        std::ranges::any_of(plan.magnetometers, is_of_field))
      continue;
    throw Error(fmt::format("--only {}: no parameter of this robot begins so", word));
  }
  const Config motion = yaml.child_or_empty("motion");
  if (!plan.parameters.empty() && motion.has("source") && motion.text("source") == "maps")
    throw Error("motion.source is maps: a calibration needs wheels or another odometry, which gives a speed");
  if (plan.parameters.empty() && plan.imus.empty() && plan.magnetometers.empty())
    throw Error("no sensor of this robot has a parameter that can be estimated");
  return plan;
}

}  // namespace waymark::calibration
