// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/waymark/calibration/equations.hpp"
#include "apps/waymark/calibration/estimate.hpp"
#include "apps/waymark/calibration/magnetometer.hpp"
#include "apps/waymark/calibration/parameter.hpp"
#include "apps/waymark/calibration/recording.hpp"
#include "apps/waymark/calibration/report.hpp"
#include "apps/waymark/calibration/report_of_fields.hpp"
#include "apps/waymark/calibration/standing.hpp"
#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/command/log_diagnosis.hpp"
#include "waymark/base/error.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::command {

namespace {

struct CalibrateOptions {
  std::filesystem::path config;
  std::filesystem::path out;
  std::filesystem::path json;
  std::vector<std::string> overrides;
  std::vector<std::string> only;
  std::optional<double> until_s;
};

/// True if the finding is about a value that is estimated.
bool is_estimated(const Finding& finding, const calibration::Plan& plan) {
  return std::ranges::any_of(plan.parameters, [&](const calibration::Parameter& parameter) {
    return finding.change.starts_with(fmt::format("sensors.{}.{}", parameter.sensor, parameter.key));
  });
}

/// What no value can mend: signs, units, swapped axes. An error of the log is left to the calibration itself.
std::vector<Finding> contradictions(const CalibrateOptions& options, const Config& yaml,
                                    const calibration::Plan& plan) {
  host::Robot robot = host::Robot::load(yaml, host::plugin_loader(yaml));
  if (robot.source == nullptr || robot.source->is_live()) return {};
  host::Diagnosis diagnosis(robot);
  double length_s = 0.0;
  diagnose_log(robot, diagnosis, std::min(kDiagnosedSeconds, options.until_s.value_or(kDiagnosedSeconds)), length_s);
  diagnosis.finish();
  std::vector<Finding> found = diagnosis.findings();
  std::erase_if(found, [&](const Finding& finding) { return is_estimated(finding, plan); });
  return found;
}

void read_standing(const CalibrateOptions& options, const calibration::Plan& plan, calibration::Findings& findings) {
  if (plan.imus.empty()) return;
  findings.standing = calibration::standing_over_log(options.config, options.overrides, options.until_s, plan.imus);
  for (calibration::Standing& standing : findings.standing) {
    if (std::ranges::find(plan.accelerometers, standing.sensor) == plan.accelerometers.end())
      standing.force_norm = std::nan("");
  }
  for (const std::string& imu : plan.imus) {
    if (std::ranges::find(findings.standing, imu, &calibration::Standing::sensor) == findings.standing.end())
      print_output("{} never stands for 20 s: no Allan deviation\n", imu);
  }
}

void calibrate(const CalibrateOptions& options) {
  const Config yaml = Config::load(options.config, options.overrides);
  const calibration::Plan plan = calibration::plan_for(yaml, options.only);
  const calibration::Values values(yaml, plan.parameters);
  calibration::Findings findings;
  findings.parameters = plan.parameters;
  findings.contradictions = contradictions(options, yaml, plan);
  if (!findings.contradictions.empty()) {
    print_output("waymark doctor finds what no value below mends; first:\n{}",
                 calibration::contradiction_lines(findings, ""));
  }
  read_standing(options, plan, findings);
  if (!plan.magnetometers.empty()) {
    findings.magnetometers =
        calibration::magnetometers_over_log(options.config, options.overrides, options.until_s, plan.magnetometers);
  }
  std::string heading =
      fmt::format("# waymark calibrate {}: copy what you trust into the YAML.\n", options.config.string());
  if (!plan.parameters.empty()) {
    std::vector<Config::Override> overrides = options.overrides;
    overrides.insert(overrides.end(), plan.overrides.begin(), plan.overrides.end());
    // Headings of a field that is bent would bend the path.
    for (const calibration::Magnetometer& magnetometer : findings.magnetometers) {
      for (Config::Override& one : calibration::overrides(magnetometer)) overrides.push_back(std::move(one));
    }
    const calibration::Recording recording = calibration::read_recording(options.config, overrides, options.until_s);
    std::vector<calibration::Parameter> all = plan.parameters;
    all.insert(all.end(), plan.others.begin(), plan.others.end());
    const calibration::Equations equations(recording, yaml, all);
    findings.time_base = recording.wheels.front().sensor;
    findings.time_base_delay = calibration::number_of(yaml, findings.time_base, "delay_s", 0.0);
    const auto progress = [](const calibration::Estimate& so_far) {
      print_message("step {}: {:.2g} σ\n", so_far.iterations, so_far.largest_step);
    };
    findings.estimate = calibration::estimate(equations, progress);
    print_output("\n{}\n", calibration::table(findings, values));
  }
  print_output("{}{}", calibration::standing_tables(findings), calibration::magnetometer_lines(findings));
  const std::string block = calibration::yaml_block(findings, values, heading);
  if (!options.out.empty()) {
    OutputFile file(options.out);
    file.write(block);
    file.commit();
    print_output("written: {}\n", options.out.string());
  } else {
    print_output("\n{}", block);
  }
  if (!options.json.empty()) {
    OutputFile file(options.json);
    file.write(calibration::json(findings, values));
    file.commit();
  }
  const std::vector<Config::Override> found = calibration::overrides(findings, values);
  if (!found.empty())
    print_output("\nto try it: waymark run {} --set '{}'\n", options.config.string(), fmt::join(found, "' --set '"));
  if (!plan.parameters.empty() && !findings.estimate.converged)
    throw Error(fmt::format(
        "{}: not converged after {} steps, so no value is proposed: the equations do not describe this log; waymark "
        "doctor checks its stamps, --only leaves parameters out",
        options.config.string(), findings.estimate.iterations));
}

}  // namespace

void add_calibrate_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command = app.add_subcommand(
      "calibrate",
      "Estimate geometry, delays, scales and noise of a robot's sensors from a log, with their uncertainty");
  command->footer("Example:\n  waymark calibrate robot.yaml --only wheels gps.base_p_antenna_m --out calibration.yaml");
  command->add_option("config", options->config, "the YAML of a log")->required();
  command->add_option("--only", options->only, "parameters, or beginnings of their names: gps, wheels.track_m");
  command->add_option("--out", options->out, "file for the block of YAML; else it is printed");
  command->add_option("--json", options->json, "file for the table as JSON");
  command->add_option("--set", options->overrides, "key=value: overrides a key of the YAML");
  command->add_option("--until", options->until_s, "only the first seconds of the log")->check(positive_number());
  command->callback([options, &exit_code] {
    calibrate(*options);
    exit_code = kSuccess;
  });
}

}  // namespace waymark::command
