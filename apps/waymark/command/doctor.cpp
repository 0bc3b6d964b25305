// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/command/log_diagnosis.hpp"
#include "waymark/host/diagnosis.hpp"

namespace waymark::command {

namespace {

struct DoctorOptions {
  std::filesystem::path config;
  std::vector<std::string> overrides;
  double until_s = kDiagnosedSeconds;
  bool json = false;
};

using Json = nlohmann::ordered_json;

void print_comparisons(const std::vector<host::Comparison>& comparisons) {
  if (comparisons.empty()) return;
  print_output("\n{:<10} {:<22} {:<22} {:>10} {:>9} {:>6}  {}\n", "compared", "of", "by", "value", "sigma", "spans",
               "");
  for (const host::Comparison& c : comparisons) {
    print_output("{:<10} {:<22} {:<22} {:>10.3f} {:>9.3f} {:>6}  {}\n", c.quantity, c.first, c.second, c.ratio, c.sigma,
                 c.spans > 0 ? fmt::format("{}", c.spans) : "", c.verdict);
  }
}

void print_json(const std::vector<Finding>& findings, const std::vector<host::Comparison>& comparisons,
                const std::string& error) {
  Json document{{"findings", Json::array()}, {"comparisons", Json::array()}, {"error", error}};
  for (const Finding& f : findings) {
    document["findings"].push_back({{"certainty", to_string(f.certainty)},
                                    {"check", f.check},
                                    {"sensors", f.sensors},
                                    {"seen", f.seen},
                                    {"change", f.change},
                                    {"sigmas", f.sigmas},
                                    {"t_s", to_seconds(f.stamp.time_since_epoch())}});
  }
  for (const host::Comparison& c : comparisons) {
    document["comparisons"].push_back({{"quantity", c.quantity},
                                       {"first", c.first},
                                       {"second", c.second},
                                       {"ratio", c.ratio},
                                       {"sigma", c.sigma},
                                       {"spans", c.spans},
                                       {"verdict", c.verdict}});
  }
  print_output("{}\n", document.dump(1, ' ', false, Json::error_handler_t::replace));
}

int examine(const DoctorOptions& options) {
  const Config yaml = Config::load(options.config, options.overrides);
  host::Robot robot = host::Robot::load(yaml, host::plugin_loader(yaml));
  if (robot.source->is_live())
    throw Error(fmt::format("{}: is of a running robot; `waymark run` compares its sensors", options.config.string()));
  host::Diagnosis diagnosis(robot);
  double length_s = 0.0;
  const std::string error = diagnose_log(robot, diagnosis, options.until_s, length_s);
  diagnosis.finish();
  const std::vector<Finding>& findings = diagnosis.findings();
  if (options.json) {
    print_json(findings, diagnosis.comparisons(), error);
  } else {
    print_output("{}: {:.0f} s of log, {} finding{}\n", options.config.string(), length_s, findings.size(),
                 findings.size() == 1 ? "" : "s");
    for (const Finding& finding : findings) print_output("  {}: {}\n", finding.check, describe(finding));
    print_comparisons(diagnosis.comparisons());
  }
  if (!error.empty()) throw Error(error);
  return findings.empty() ? kSuccess : kFindings;
}

}  // namespace

void add_doctor_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<DoctorOptions>();
  CLI::App* command =
      app.add_subcommand("doctor", "Compare the sensors of a log with each other and name the one that does not fit");
  command->footer(
      "Example:\n  waymark doctor robot.yaml\n\n"
      "Nothing is estimated and nothing is written. Exit code: 0 nothing found; 1 error; 2 wrong command line; 5 "
      "something found.");
  command->add_option("config", options->config, "the YAML")->required();
  command->add_option("--set", options->overrides, "key=value: overrides a key of the YAML");
  command->add_option("--until", options->until_s, "seconds of the log that are read")->check(positive_number());
  command->add_flag("--json", options->json, "findings and comparisons as JSON");
  command->callback([options, &exit_code] { exit_code = examine(*options); });
}

}  // namespace waymark::command
