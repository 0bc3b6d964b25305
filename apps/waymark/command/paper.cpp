// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <thread>

#include "apps/waymark/command/batch.hpp"
#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/jobs/jobs.hpp"
#include "apps/waymark/paper/outages.hpp"
#include "apps/waymark/paper/page.hpp"
#include "apps/waymark/paper/representative.hpp"
#include "apps/waymark/paper/sawtooth.hpp"
#include "waymark/base/error.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::command {

namespace {

struct PaperOptions {
  std::string config;  // empty: that of the experiment
  std::filesystem::path out = "out/paper";
  std::vector<std::string> overrides;
  std::vector<double> noises;  // empty: those of the experiment
  std::string experiment = "scenarios";
  int seeds = 30;
  int jobs = 0;
};

std::string command_of(const PaperOptions& options) {
  std::string text =
      fmt::format("waymark paper {} --experiment {} --seeds {}", options.config, options.experiment, options.seeds);
  if (!options.noises.empty()) text += fmt::format(" --noise {:g}", fmt::join(options.noises, ","));
  for (const std::string& one : options.overrides) text += fmt::format(" --set '{}'", one);
  return text;
}

void run_courses(std::size_t count, const PaperOptions& options, const std::function<void(std::size_t)>& work) {
  jobs::run_all(count, options.jobs, work, [&](std::size_t done) { report_ended(done, count, "courses"); });
}

void require_own_page(const PaperOptions& options, const std::string& name) {
  require_replaceable(options.out / (name + ".md"), "waymark paper", "--out");
}

/// Writes page and numbers, and reports where they are.
void write(const PaperOptions& options, const std::string& name, const std::string& page, const std::string& json) {
  write_file(options.out / (name + ".json"), json);
  write_file(options.out / (name + ".md"), page);
  print_message("results in {}\n", (options.out / (name + ".md")).string());
}

/// The YAML of the algorithm as published that lies beside the given one; empty: there is none, or it is the given one.
std::string published_beside(const std::filesystem::path& config) {
  const std::filesystem::path published = config.parent_path() / "paper_literal.yaml";
  std::error_code error;
  if (!std::filesystem::exists(published, error) || std::filesystem::equivalent(published, config, error)) return {};
  return published.string();
}

/// Draws the seeds that stand for a figure of the paper: those courses once more, with a picture.
void draw_representatives(const PaperOptions& options, const paper::Results& results) {
  for (const paper::Representative& one : paper::representative_failures(results)) {
    paper::Scenario scenario = results.experiment.scenarios[one.scenario];
    scenario.picture = one.picture;
    paper::run(
        options.config, options.overrides,
        {results.seeds[one.seed], results.noises[paper::shown_noise(results)], options.out / results.experiment.name},
        {scenario});
  }
}

void run_scenarios(const PaperOptions& options) {
  paper::Results results;
  results.command = command_of(options);
  results.config = options.config;
  results.overrides = options.overrides;
  results.world = paper::surveyed(options.config, options.overrides);
  results.experiment = options.experiment == "signatures"
                           ? paper::signature_rules()
                           : paper::scenarios_of_the_paper(published_beside(options.config));
  results.noises = options.noises;
  for (int seed = 1; seed <= options.seeds; ++seed) results.seeds.push_back(static_cast<std::uint64_t>(seed));
  results.trials.assign(results.noises.size(), std::vector<std::vector<paper::Trial>>(results.seeds.size()));
  const std::string& name = results.experiment.name;
  require_own_page(options, name);
  create_folder(options.out / name, "output folder");
  run_courses(results.noises.size() * results.seeds.size(), options, [&](std::size_t i) {
    const std::size_t noise = i / results.seeds.size();
    const std::size_t seed = i % results.seeds.size();
    const bool pictures = seed == 0 && noise == paper::shown_noise(results);
    results.trials[noise][seed] = paper::run(
        options.config, options.overrides,
        {results.seeds[seed], results.noises[noise], pictures ? options.out / name : std::filesystem::path()},
        results.experiment.scenarios);
  });
  draw_representatives(options, results);
  write(options, name, paper::to_page(results, name), paper::to_json(results));
}

void run_sawtooth(const PaperOptions& options) {
  if (options.noises.size() != 1) throw Error("paper: --experiment sawtooth takes one --noise");
  require_own_page(options, "sawtooth");
  paper::Sawtooth results = paper::Sawtooth::prepare(options.seeds);
  results.command = command_of(options);
  results.config = options.config;
  results.overrides = options.overrides;
  results.noise = options.noises.front();
  create_folder(options.out, "output folder");
  run_courses(results.gps.size() * results.seeds.size(), options,
              [&](std::size_t i) { results.run(options.config, i / results.seeds.size(), i % results.seeds.size()); });
  write(options, "sawtooth", paper::to_page(results), paper::to_json(results));
}

void run_outages(const PaperOptions& options) {
  if (!options.noises.empty()) throw Error("paper: --experiment outages takes no --noise; use --set");
  require_own_page(options, "outages");
  paper::Outages results;
  results.command = command_of(options);
  results.config = options.config;
  results.overrides = options.overrides;
  for (int seed = 1; seed <= options.seeds; ++seed) results.seeds.push_back(static_cast<std::uint64_t>(seed));
  results.trials.resize(results.seeds.size());
  create_folder(options.out / "paper", "output folder");
  run_courses(results.seeds.size(), options,
              [&](std::size_t i) { results.run(i, i == 0 ? options.out / "paper" : std::filesystem::path()); });
  write(options, "outages", paper::to_page(results, "paper"), paper::to_json(results));
}

/// The YAML of an experiment.
const char* config_of(const std::string& experiment) {
  if (experiment == "sawtooth") return "config/paper_sawtooth.yaml";
  return experiment == "outages" ? "config/paper_outages.yaml" : "config/paper.yaml";
}

int run(PaperOptions options) {
  if (options.jobs == 0) options.jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  if (options.config.empty()) options.config = config_of(options.experiment);
  if (options.experiment == "outages") {
    run_outages(options);
  } else if (options.experiment == "sawtooth") {
    if (options.noises.empty()) options.noises = {1.0};
    run_sawtooth(options);
  } else {
    if (options.noises.empty()) options.noises = {0.5, 1.0, 2.0, 4.0};
    run_scenarios(options);
  }
  return kSuccess;
}

}  // namespace

void add_paper_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<PaperOptions>();
  CLI::App* command = app.add_subcommand("paper", "The experiments of the paper over seeds, with figures and tables");
  command->footer("Example:\n  waymark paper --out out/paper --seeds 5 --noise 1");
  command->add_option("config", options->config,
                      "YAML on the simulator (default: config/paper.yaml, paper_outages.yaml or paper_sawtooth.yaml)");
  command->add_option("--out", options->out, "folder for the page, its numbers and its pictures")
      ->capture_default_str();
  command
      ->add_option("--experiment", options->experiment,
                   "scenarios: the four of the paper, also with the paper_literal.yaml beside the YAML; signatures: "
                   "rules compared; outages: Figs. 3.1 and 3.2; "
                   "sawtooth: what a GPS does to SLAM")
      ->check(CLI::IsMember({"scenarios", "signatures", "outages", "sawtooth"}))
      ->capture_default_str();
  command->add_option("--seeds", options->seeds, "seeds 1 to N")->check(CLI::Range(1, 100000))->capture_default_str();
  command
      ->add_option("--noise", options->noises,
                   "factors on the odometry's noise, in simulator and filter (default: 0.5,1,2,4; 1 for sawtooth)")
      ->delimiter(',')
      ->check(positive_number());
  command->add_option("--set", options->overrides, "key=value: overrides a key of the YAML in all runs");
  command->add_option("--jobs", options->jobs, "courses at the same time (default: one per core)")
      ->check(CLI::Range(1, 1024));
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace waymark::command
