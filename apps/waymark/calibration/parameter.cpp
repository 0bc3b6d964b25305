// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/parameter.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "waymark/base/error.hpp"

namespace waymark::calibration {

namespace {

using Kind = Parameter::Kind;

/// One row of what plugins have to offer.
struct Offer {
  std::string_view key;
  int element;
  std::string_view unit;
  Kind kind;
  double step;
  double prior_sigma;
  std::vector<double> fallback;  ///< where the YAML leaves the key out; empty: then it is not estimated
};

// Priors: what a careful owner with a tape measure achieves, times three or so.
const Offer kDelay{"delay_s", -1, "s", Kind::value, 0.02, 0.15, {0.0}};
const Offer kYaw{"base_T_sensor.yaw_deg", -1, "°", Kind::value, 1.0, 10.0, {0.0}};

/// What of a sensor can be estimated, by its plugin and keys. Without a plugin it feeds maps.
std::vector<Offer> offers_of(const Config& sensor, const std::string& plugin) {
  if (plugin.empty()) {
    if (!sensor.has("payload") || sensor.text("payload").find("LaserScan") == std::string::npos) return {};
    std::vector<Offer> offers{kDelay};
    if (sensor.has("base_T_sensor")) {
      offers.push_back(kYaw);
      for (const int axis : {0, 1})
        offers.push_back({"base_T_sensor.xyz_m", axis, "m", Kind::value, 0.02, 0.3, {0.0, 0.0, 0.0}});
    }
    return offers;
  }
  if (plugin == "odometry") {
    std::vector<Offer> offers{{"speed_scale", -1, "", Kind::value, 0.005, 0.1, {1.0}},
                              {"curvature_per_m", -1, "1/m", Kind::value, 0.005, 0.1, {0.0}}};
    if (sensor.has("track_m")) {
      offers.push_back({"track_m", -1, "m", Kind::level, 0.01, 0.1, {}});
    } else if (sensor.has("wheelbase_m")) {
      offers.push_back({"wheelbase_m", -1, "m", Kind::level, 0.01, 0.1, {}});
    } else {
      offers.push_back({"yaw_scale", -1, "", Kind::value, 0.005, 0.1, {1.0}});
    }
    offers.push_back({"speed_noise_m_per_sqrt_s", -1, "m/√s", Kind::level, 0.05, 1.0, {0.02, 0.05}});
    offers.push_back({"yaw_noise_rad_per_sqrt_s", -1, "rad/√s", Kind::level, 0.05, 1.0, {0.0, 0.01, 0.05}});
    return offers;
  }
  if (plugin == "dgps") {
    std::vector<Offer> offers{kDelay, {"sigma_m", -1, "m", Kind::level, 0.05, 1.0, {}}};
    if (sensor.has("base_p_antenna_m") && sensor.is_list("base_p_antenna_m")) {
      offers.push_back({"base_p_antenna_m", 0, "m", Kind::value, 0.1, 0.5, {}});
      offers.push_back({"base_p_antenna_m", 1, "m", Kind::value, 0.1, 0.5, {}});
    }
    if (sensor.has("offset_sigma_m")) offers.push_back({"offset_sigma_m", -1, "m", Kind::level, 0.05, 1.0, {}});
    return offers;
  }
  if (plugin == "compass") {
    std::vector<Offer> offers{kDelay, {"sigma_deg", -1, "°", Kind::level, 0.05, 1.0, {5.0}}};
    if (sensor.has("base_T_sensor")) offers.push_back(kYaw);
    if (sensor.has("hard_iron_t") && sensor.has("payload") && sensor.text("payload").ends_with("MagneticField")) {
      for (const int axis : {0, 1})
        offers.push_back({"hard_iron_t", axis, "T", Kind::value, 1e-6, 2e-5, {0.0, 0.0, 0.0}});
    }
    return offers;
  }
  if (plugin == "imu") return {kDelay};
  return {};
}

/// What stands between a parameter and the innovations that it changes.
std::vector<std::string> to_switch_off(const std::string& plugin) {
  if (plugin == "odometry")
    return {"speed_scale_sigma=0",     "speed_scale_walk_per_sqrt_m=0",
            "curvature_sigma_per_m=0", "curvature_walk_per_m_sqrt_m=0",
            "yaw_scale_sigma=0",       "yaw_scale_walk_per_sqrt_m=0"};
  if (plugin == "dgps")
    return {"jump_sigmas=0",        "frozen_distance_m=0", "drift_sigmas=0",
            "adaptive_noise=false", "settling_s=0",        "reacquisition_fixes=0"};
  if (plugin == "compass") return {"jump_sigmas=0"};
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

const Offer* offer_of(const std::vector<Offer>& offers, const Parameter& parameter) {
  const auto found = std::ranges::find_if(offers, [&](const Offer& offer) { return offer.key == parameter.key; });
  return found == offers.end() ? nullptr : &*found;
}

}  // namespace

std::string Parameter::name() const {
  return element < 0 ? fmt::format("{}.{}", sensor, key) : fmt::format("{}.{}[{}]", sensor, key, element);
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

double Values::value(std::size_t i, double delta) const {
  const Parameter& parameter = parameters_[i];
  const std::vector<double>& numbers = numbers_.at(fmt::format("sensors.{}.{}", parameter.sensor, parameter.key));
  if (parameter.kind == Kind::level) return numbers[0] * std::exp(delta);
  return numbers[static_cast<std::size_t>(std::max(parameter.element, 0))] + delta;
}

std::vector<Config::Override> Values::changed(const Eigen::VectorXd& delta) const {
  std::map<std::string, std::vector<double>> numbers = numbers_;
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    const Parameter& parameter = parameters_[i];
    std::vector<double>& list = numbers[fmt::format("sensors.{}.{}", parameter.sensor, parameter.key)];
    const double d = delta(static_cast<Eigen::Index>(i));
    if (parameter.kind == Kind::level) {
      for (double& one : list) one *= std::exp(d);
    } else {
      list[static_cast<std::size_t>(std::max(parameter.element, 0))] += d;
    }
  }
  std::vector<Config::Override> overrides;
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
  // One particle that samples nothing is an EKF: its innovations are smooth functions of the parameters.
  if (yaml.has("maps"))
    plan.overrides.insert(plan.overrides.end(), {"filter.particles=1", "filter.sampling_fraction=0"});
  for (const Config& sensor : yaml.items("sensors")) {
    if (sensor.has("enabled") && !sensor.boolean("enabled", true)) continue;
    const std::string name = sensor.text("name");
    const std::string plugin = plugin_of(sensor);
    const auto add = [&](std::string_view key_and_value) {
      plan.overrides.push_back(fmt::format("sensors.{}.{}", name, key_and_value));
    };
    if (!plugin.empty()) {
      add("gate_probability=0.999999999999");
      add("max_consecutive_rejections=0");
    }
    for (const std::string& one : to_switch_off(plugin)) add(one);
    for (const Offer& offer : offers_of(sensor, plugin)) {
      const auto [node, key] = find(sensor, offer.key);
      if (!node.has(key) && offer.fallback.empty()) continue;
      if (node.has(key) && offer.kind == Kind::level && !node.is_list(key) && node.number(key) <= 0.0) continue;
      Parameter parameter{name,       std::string(offer.key), offer.element, std::string(offer.unit), offer.kind,
                          offer.step, offer.prior_sigma};
      if (is_wanted(parameter, only)) plan.parameters.push_back(std::move(parameter));
    }
    const auto is_own = [&](const Parameter& one) { return one.sensor == name; };
    if (plugin == "odometry" && std::ranges::any_of(plan.parameters, is_own)) plan.inputs.push_back(name);
  }
  for (const std::string& word : only) {
    if (std::ranges::any_of(plan.parameters, [&](const Parameter& one) { return one.name().starts_with(word); }))
      continue;
    throw Error(fmt::format("--only {}: no parameter of this robot begins so", word));
  }
  if (plan.parameters.empty()) throw Error("no sensor of this robot has a parameter that can be estimated");
  return plan;
}

}  // namespace waymark::calibration
