// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

namespace waymark::calibration {

namespace {

/// A parameter counts as determined by the drive if the log removed so much of the prior's variance.
constexpr double kDetermined = 0.75;

bool is_determined(const Estimate& estimate, std::size_t i) {
  return estimate.information(static_cast<Eigen::Index>(i)) >= kDetermined;
}

/// The change of what the drive determined, zero elsewhere.
Eigen::VectorXd determined_change(const std::vector<Parameter>& parameters, const Estimate& estimate) {
  Eigen::VectorXd change = estimate.change;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (!is_determined(estimate, i)) change(static_cast<Eigen::Index>(i)) = 0.0;
  }
  return change;
}

/// Given and estimated value of a parameter, and σ in its unit.
struct Row {
  double given;
  double estimated;
  double sigma;
};

Row row_of(const Parameter& parameter, const Values& values, const Estimate& estimate, std::size_t i) {
  const auto index = static_cast<Eigen::Index>(i);
  Row row{values.value(i, 0.0), values.value(i, estimate.change(index)), estimate.sigma(index)};
  if (parameter.kind == Parameter::Kind::level) row.sigma *= std::abs(row.estimated);
  return row;
}

/// With as many digits as σ makes sense of.
std::string number(double value, double sigma) {
  const int digits = sigma > 0.0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 12) : 6;
  return fmt::format("{:.{}f}", value, digits);
}

}  // namespace

std::string table(const std::vector<Parameter>& parameters, const Values& values, const Estimate& estimate) {
  std::size_t width = 9;
  for (const Parameter& parameter : parameters) width = std::max(width, parameter.name().size());
  std::string text = fmt::format("{:<{}}  {:>12}  {:>12}  {:>12}\n", "parameter", width, "given", "estimated", "± σ");
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const Parameter& parameter = parameters[i];
    const Row row = row_of(parameter, values, estimate, i);
    const double shown = std::max(row.sigma, 1e-12);
    text += fmt::format("{:<{}}  {:>12}  {:>12}  {:>12} {}{}\n", parameter.name(), width, number(row.given, shown),
                        number(row.estimated, shown), number(row.sigma, shown), parameter.unit,
                        is_determined(estimate, i) ? "" : "  not determined by this drive");
  }
  return text;
}

std::string json(const std::vector<Parameter>& parameters, const Values& values, const Estimate& estimate) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const Row row = row_of(parameters[i], values, estimate, i);
    list.push_back({{"name", parameters[i].name()},
                    {"unit", parameters[i].unit},
                    {"given", row.given},
                    {"estimated", row.estimated},
                    {"sigma", row.sigma},
                    {"determined", is_determined(estimate, i)}});
  }
  return list.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::vector<Config::Override> overrides(const std::vector<Parameter>& parameters, const Values& values,
                                        const Estimate& estimate) {
  std::vector<Config::Override> all = values.changed(determined_change(parameters, estimate));
  std::erase_if(all, [&](const std::string& one) {
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      if (is_determined(estimate, i) &&
          one.starts_with(fmt::format("sensors.{}.{}=", parameters[i].sensor, parameters[i].key)))
        return false;
    }
    return true;
  });
  return all;
}

std::string yaml_block(const std::vector<Parameter>& parameters, const Values& values, const Estimate& estimate,
                       const std::string& heading) {
  std::string text = heading + "sensors:\n";
  std::string sensor;
  const std::vector<Config::Override> all = overrides(parameters, values, estimate);
  for (const Config::Override& one : all) {
    // "sensors.NAME.KEY=VALUE"
    const std::size_t equals = one.find('=');
    const std::string path = one.substr(0, equals);
    std::string comment;
    std::string key;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const Parameter& parameter = parameters[i];
      if (path != fmt::format("sensors.{}.{}", parameter.sensor, parameter.key)) continue;
      if (parameter.sensor != sensor) {
        sensor = parameter.sensor;
        text += fmt::format("  - name: {}\n", sensor);
      }
      key = parameter.key;
      const Row row = row_of(parameter, values, estimate, i);
      if (!comment.empty()) comment += "; ";
      if (parameter.element >= 0) comment += fmt::format("[{}] ", parameter.element);
      if (!is_determined(estimate, i)) {
        comment += "not determined";
      } else {
        comment += fmt::format("± {}, was {}", number(row.sigma, row.sigma), number(row.given, row.sigma));
      }
    }
    const std::size_t dot = key.find('.');
    if (dot != std::string::npos) {
      text += fmt::format("    {}:  # the other keys of it stay\n      {}: {}  # {}\n", key.substr(0, dot),
                          key.substr(dot + 1), one.substr(equals + 1), comment);
    } else {
      text += fmt::format("    {}: {}  # {}\n", key, one.substr(equals + 1), comment);
    }
  }
  return text;
}

}  // namespace waymark::calibration
