// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "apps/waymark/calibration/report_of_fields.hpp"

namespace waymark::calibration {

namespace {

/// A parameter counts as determined by the drive if the log removed so much of the prior's variance.
constexpr double kDetermined = 0.75;
/// A level of noise also if the log contradicts the given one by so many σ: of one that is near zero a log says hardly
/// more than that it is small.
constexpr double kContradicted = 2.0;
/// A value so many σ of its prior away from what the YAML gives rather shows that the equations do not describe the
/// log.
constexpr double kImplausible = 3.0;

bool is_implausible(const Findings& findings, std::size_t i) {
  const Parameter& parameter = findings.parameters[i];
  return parameter.kind != Parameter::Kind::noise &&
         std::abs(findings.estimate.change(static_cast<Eigen::Index>(i))) > kImplausible * parameter.prior_sigma;
}

bool is_determined(const Findings& findings, std::size_t i) {
  const auto index = static_cast<Eigen::Index>(i);
  const Estimate& estimate = findings.estimate;
  if (!estimate.converged || is_implausible(findings, i)) return false;
  if (estimate.information(index) >= kDetermined) return true;
  return findings.parameters[i].kind == Parameter::Kind::noise &&
         std::abs(estimate.change(index)) >= kContradicted * estimate.sigma(index);
}

/// Given and estimated value of a parameter, and σ in its unit.
struct Row {
  double given;
  double estimated;
  double sigma;
};

Row row_of(const Findings& findings, const Values& values, std::size_t i) {
  const auto index = static_cast<Eigen::Index>(i);
  Row row{values.value(i, 0.0), values.value(i, findings.estimate.change(index)), findings.estimate.sigma(index)};
  if (findings.parameters[i].kind != Parameter::Kind::value) row.sigma *= std::abs(row.estimated);
  return row;
}

/// How late the time base is [s]: as much as the sensor that is most ahead of it. At `parameter`, −1: it is not.
struct Lateness {
  double seconds = 0.0;
  int parameter = -1;
};

Lateness lateness_of(const Findings& findings, const Values& values) {
  Lateness late;
  for (std::size_t i = 0; i < findings.parameters.size(); ++i) {
    if (findings.parameters[i].key != "delay_s" || !is_determined(findings, i)) continue;
    const Row row = row_of(findings, values, i);
    if (-row.estimated > std::max(2.0 * row.sigma, late.seconds)) late = {-row.estimated, static_cast<int>(i)};
  }
  return late;
}

/// The change of what the drive determined, zero elsewhere.
Eigen::VectorXd determined_change(const Findings& findings, const Values& values) {
  const Lateness late = lateness_of(findings, values);
  Eigen::VectorXd change = findings.estimate.change;
  for (std::size_t i = 0; i < findings.parameters.size(); ++i) {
    double& one = change(static_cast<Eigen::Index>(i));
    if (!is_determined(findings, i)) {
      one = 0.0;
    } else if (findings.parameters[i].key == "delay_s") {
      one += late.seconds;
    }
  }
  return change;
}

/// With as many digits as σ makes sense of.
std::string number(double value, double sigma) {
  const int digits = sigma > 0.0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 12) : 6;
  return fmt::format("{:.{}f}", value, digits);
}

/// "[0] " of "base_p_antenna_m[0]", for a comment; empty if the key is no list.
std::string element_of(const Parameter& parameter) {
  const std::string name = parameter.name();
  const std::size_t bracket = name.find('[');
  return bracket == std::string::npos ? std::string() : name.substr(bracket) + " ";
}

/// What is known of the values under one key.
std::string comment_of(const Findings& findings, const Values& values, const std::string& path) {
  if (path == fmt::format("sensors.{}.delay_s", findings.time_base)) {
    const Lateness late = lateness_of(findings, values);
    const Parameter& ahead = findings.parameters[static_cast<std::size_t>(late.parameter)];
    const double sigma = findings.estimate.sigma(late.parameter);
    return fmt::format("± {}, was {}; {} is ahead of it by so much", number(sigma, sigma),
                       number(findings.time_base_delay, sigma), ahead.sensor);
  }
  std::string comment;
  for (std::size_t i = 0; i < findings.parameters.size(); ++i) {
    const Parameter& parameter = findings.parameters[i];
    if (path != fmt::format("sensors.{}.{}", parameter.sensor, parameter.key)) continue;
    const Row row = row_of(findings, values, i);
    comment += (comment.empty() ? "" : "; ") + element_of(parameter);
    comment += is_determined(findings, i)
                   ? fmt::format("± {}, was {}", number(row.sigma, row.sigma), number(row.given, row.sigma))
                   : "not determined";
  }
  return comment;
}

/// The force at rest. Along it a bias shows; across it a bias is not distinguished from a tilt of floor or mounting.
std::string lines_of_force(const Standing& standing) {
  if (!std::isfinite(standing.force_norm)) return {};
  constexpr double kInDegrees = 180.0 / std::numbers::pi;
  const Eigen::Vector3d& f = standing.force_base;
  const double sigma = standing.force_norm_sigma;
  return fmt::format(
      "    # upwards the accelerometer shows {:+.4f} ± {:.4f} m/s² more than gravity; forward and left its bias is "
      "not\n"
      "    # distinguished from a floor or a mounting that leans: the force is {:.2f}° off the base's z forward, "
      "{:.2f}° left\n"
      "    {}: {}  # ± {}, was {}\n",
      standing.force_norm - standing.given_gravity, sigma, std::atan2(f.x(), f.z()) * kInDegrees,
      std::atan2(f.y(), f.z()) * kInDegrees, kGravity, number(standing.force_norm, sigma), number(sigma, sigma),
      number(standing.given_gravity, sigma));
}

std::string lines_of_standing(const Standing& standing) {
  const double shown = standing.bias_sigma.maxCoeff();
  return fmt::format(
             "    # gyro bias at rest: [{}, {}, {}] ± {} rad/s\n    {}: {}  # ± {}, was {}; at rest: a driving robot "
             "shakes\n",
             number(standing.bias.x(), shown), number(standing.bias.y(), shown), number(standing.bias.z(), shown),
             number(shown, shown), kGyroNoise, number(standing.noise.density, standing.noise.sigma),
             number(standing.noise.sigma, standing.noise.sigma), number(standing.given_noise, standing.noise.sigma)) +
         lines_of_force(standing);
}

}  // namespace

std::string table(const Findings& findings, const Values& values) {
  std::size_t width = 9;
  for (const Parameter& parameter : findings.parameters) width = std::max(width, parameter.name().size());
  std::string text = fmt::format("{:<{}}  {:>12}  {:>12}  {:>12}\n", "parameter", width, "given", "estimated", "± σ");
  for (std::size_t i = 0; i < findings.parameters.size(); ++i) {
    const Parameter& parameter = findings.parameters[i];
    const Row row = row_of(findings, values, i);
    const double shown = std::max(row.sigma, 1e-12);
    const char* verdict = is_implausible(findings, i)  ? "  implausible: check this sensor's stamps and model"
                          : is_determined(findings, i) ? ""
                                                       : "  not determined by this drive";
    text += fmt::format("{:<{}}  {:>12}  {:>12}  {:>12} {}{}\n", parameter.name(), width, number(row.given, shown),
                        number(row.estimated, shown), number(row.sigma, shown), parameter.unit, verdict);
  }
  return text;
}

std::string standing_tables(const Findings& findings) {
  std::string text;
  for (const Standing& standing : findings.standing) {
    text += fmt::format("{} stands from {:.0f} s on for {:.0f} s, {:.0f} samples a second; Allan deviations:\n",
                        standing.sensor, standing.begin_s, standing.duration_s, standing.rate_hz);
    text += fmt::format("{:>9}  {:>35}  {:>35}\n", "τ [s]", "rate x, y, z [rad/s]", "force x, y, z [m/s²]");
    for (std::size_t k = 0; k < standing.gyro[0].size(); ++k) {
      text += fmt::format("{:>8.3g}  {:>11.3g} {:>11.3g} {:>11.3g}", standing.gyro[0][k].tau_s,
                          standing.gyro[0][k].deviation, standing.gyro[1][k].deviation, standing.gyro[2][k].deviation);
      if (k < standing.force[0].size()) {
        text += fmt::format("  {:>11.3g} {:>11.3g} {:>11.3g}", standing.force[0][k].deviation,
                            standing.force[1][k].deviation, standing.force[2][k].deviation);
      }
      text += "\n";
    }
    text += lines_of_standing(standing);
  }
  return text;
}

std::string magnetometer_lines(const Findings& findings) {
  std::string text;
  for (const Magnetometer& magnetometer : findings.magnetometers) text += summary(magnetometer);
  return text;
}

std::string contradiction_lines(const Findings& findings, std::string_view start) {
  std::string text;
  for (const Finding& finding : findings.contradictions)
    text += fmt::format("{}{}: {}\n", start, finding.check, describe(finding));
  return text;
}

std::string json(const Findings& findings, const Values& values) {
  using Json = nlohmann::ordered_json;
  Json list = Json::array();
  const auto add = [&](const std::string& name, std::string_view unit, const Json& given, double estimated,
                       double sigma, bool is_determined) {
    list.push_back({{"name", name},
                    {"unit", unit},
                    {"given", given},
                    {"estimated", estimated},
                    {"sigma", sigma},
                    {"determined", is_determined}});
  };
  for (std::size_t i = 0; i < findings.parameters.size(); ++i) {
    const Row row = row_of(findings, values, i);
    const Parameter& parameter = findings.parameters[i];
    add(parameter.name(), parameter.unit, row.given, row.estimated, row.sigma, is_determined(findings, i));
  }
  for (const Standing& standing : findings.standing) {
    add(standing.sensor + "." + kGyroNoise, "rad/√s", standing.given_noise, standing.noise.density,
        standing.noise.sigma, true);
    for (int axis = 0; axis < 3; ++axis) {
      add(fmt::format("{}.gyro_bias_radps[{}]", standing.sensor, axis), "rad/s", nullptr, standing.bias(axis),
          standing.bias_sigma(axis), true);
    }
    if (!std::isfinite(standing.force_norm)) continue;
    add(standing.sensor + "." + kGravity, "m/s²", standing.given_gravity, standing.force_norm,
        standing.force_norm_sigma, true);
  }
  for (const Magnetometer& magnetometer : findings.magnetometers) {
    for (const IronElement& one : elements(magnetometer))
      add(one.name, one.unit, one.given, one.estimated, one.sigma, one.is_determined);
  }
  return list.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<Config::Override> overrides(const Findings& findings, const Values& values) {
  std::vector<Config::Override> all = values.changed(determined_change(findings, values));
  std::erase_if(all, [&](const Config::Override& one) {
    for (std::size_t i = 0; i < findings.parameters.size(); ++i) {
      const Parameter& parameter = findings.parameters[i];
      if (is_determined(findings, i) && one.starts_with(fmt::format("sensors.{}.{}=", parameter.sensor, parameter.key)))
        return false;
    }
    return true;
  });
  if (const Lateness late = lateness_of(findings, values); late.parameter >= 0)
    all.push_back(fmt::format("sensors.{}.delay_s={}", findings.time_base, findings.time_base_delay + late.seconds));
  for (const Standing& standing : findings.standing) {
    all.push_back(fmt::format("sensors.{}.{}={}", standing.sensor, kGyroNoise,
                              number(standing.noise.density, standing.noise.sigma)));
    if (!std::isfinite(standing.force_norm)) continue;
    all.push_back(fmt::format("sensors.{}.{}={}", standing.sensor, kGravity,
                              number(standing.force_norm, standing.force_norm_sigma)));
  }
  for (const Magnetometer& magnetometer : findings.magnetometers) {
    for (Config::Override& one : overrides(magnetometer)) all.push_back(std::move(one));
  }
  return all;
}

std::string yaml_block(const Findings& findings, const Values& values, const std::string& heading) {
  const std::vector<Config::Override> all = overrides(findings, values);
  std::vector<std::string> sensors{findings.time_base};
  for (const Parameter& parameter : findings.parameters) sensors.push_back(parameter.sensor);
  for (const Standing& standing : findings.standing) sensors.push_back(standing.sensor);
  for (const Magnetometer& magnetometer : findings.magnetometers) sensors.push_back(magnetometer.sensor);
  std::string text;
  std::vector<std::string> written;
  for (const std::string& sensor : sensors) {
    if (std::ranges::find(written, sensor) != written.end()) continue;
    written.push_back(sensor);
    const std::string prefix = fmt::format("sensors.{}.", sensor);
    std::string lines;
    std::string parent;
    for (const Config::Override& one : all) {  // "sensors.NAME.KEY=VALUE", in the order of the keys
      if (!one.starts_with(prefix)) continue;
      const std::size_t equals = one.find('=');
      const std::string path = one.substr(0, equals);
      const std::string key = path.substr(prefix.size());
      const std::string comment = comment_of(findings, values, path);
      if (comment.empty()) continue;  // of a standing stretch or a field, below
      const std::size_t dot = key.find('.');
      if (dot != std::string::npos && key.substr(0, dot) != parent) {
        parent = key.substr(0, dot);
        lines += fmt::format("    {}:  # its other keys stay\n", parent);
      }
      lines += fmt::format("    {}{}: {}  # {}\n", dot == std::string::npos ? "" : "  ",
                           dot == std::string::npos ? key : key.substr(dot + 1), one.substr(equals + 1), comment);
    }
    for (const Standing& standing : findings.standing) {
      if (standing.sensor == sensor) lines += lines_of_standing(standing);
    }
    for (const Magnetometer& magnetometer : findings.magnetometers) {
      if (magnetometer.sensor == sensor) lines += yaml_lines(magnetometer);
    }
    if (!lines.empty()) text += fmt::format("  - name: {}\n{}", sensor, lines);
  }
  return heading + contradiction_lines(findings, "# ") +
         (text.empty() ? "# Nothing was determined.\n" : "sensors:\n" + text);
}

}  // namespace waymark::calibration
