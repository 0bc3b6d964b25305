// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <thread>

#include "apps/waymark/paper/page.hpp"
#include "commands.hpp"
#include "waymark/error.hpp"
#include "waymark/output_file.hpp"

namespace waymark {

namespace {

struct PaperOptions {
  std::filesystem::path config = "config/paper.yaml";
  std::filesystem::path out = "out/paper";
  std::vector<std::string> overrides;
  std::vector<double> noises{0.5, 1.0, 2.0, 4.0};
  std::string experiment = "scenarios";
  int seeds = 30;
  int jobs = 0;
};

std::string command_of(const PaperOptions& options) {
  std::string text = fmt::format("waymark paper {} --experiment {} --seeds {} --noise {:g}", options.config.string(),
                                 options.experiment, options.seeds, fmt::join(options.noises, ","));
  for (const std::string& one : options.overrides) text += fmt::format(" --set '{}'", one);
  return text;
}

/// Courses one after the other on each of `jobs` threads; where a result goes does not depend on which thread was
/// sooner. The first error ends all.
class Courses {
 public:
  Courses(const PaperOptions& options, paper::Results& results) : options_(options), results_(results) {}

  void run() {
    {
      std::vector<std::jthread> threads;
      threads.reserve(static_cast<std::size_t>(options_.jobs));
      for (int i = 0; i < options_.jobs; ++i) threads.emplace_back([this] { work(); });
    }
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::size_t count() const { return results_.noises.size() * results_.seeds.size(); }

  void work() {
    for (std::size_t i = next_++; i < count(); i = next_++) {
      const std::size_t noise = i / results_.seeds.size();
      const std::size_t seed = i % results_.seeds.size();
      const bool pictures = seed == 0 && noise == paper::shown_noise(results_);
      try {
        results_.trials[noise][seed] =
            paper::run(options_.config, options_.overrides,
                       {results_.seeds[seed], results_.noises[noise],
                        pictures ? options_.out / results_.experiment.name : std::filesystem::path()},
                       results_.experiment.scenarios);
      } catch (...) {
        const std::scoped_lock lock(mutex_);
        if (!failure_) failure_ = std::current_exception();
        next_ = count();
      }
      report();
    }
  }

  void report() {
    const std::scoped_lock lock(mutex_);
    ++done_;
    if (isatty(STDERR_FILENO) == 1) {
      fmt::print(stderr, "\r{} of {} courses{}", done_, count(), done_ == count() ? "\n" : "");
      std::fflush(stderr);
    } else if (done_ * 10 / count() != (done_ - 1) * 10 / count()) {
      fmt::print(stderr, "{} of {} courses\n", done_, count());
    }
  }

  const PaperOptions& options_;
  paper::Results& results_;
  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;
  std::size_t done_ = 0;
  std::exception_ptr failure_;
};

int run(PaperOptions options) {
  if (options.jobs == 0) options.jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  paper::Results results;
  results.command = command_of(options);
  results.config = options.config.string();
  results.overrides = options.overrides;
  results.world = paper::surveyed(options.config, options.overrides);
  results.experiment = options.experiment == "signatures" ? paper::signature_rules() : paper::scenarios_of_the_paper();
  results.noises = options.noises;
  for (int seed = 1; seed <= options.seeds; ++seed) results.seeds.push_back(static_cast<std::uint64_t>(seed));
  results.trials.assign(results.noises.size(), std::vector<std::vector<paper::Trial>>(results.seeds.size()));
  create_folder(options.out / results.experiment.name, "output folder");
  Courses(options, results).run();

  const std::string& name = results.experiment.name;
  write_file(options.out / (name + ".json"), paper::to_json(results));
  write_file(options.out / (name + ".md"), paper::to_page(results, name));
  fmt::print(stderr, "results in {}\n", (options.out / (name + ".md")).string());
  return kSuccess;
}

}  // namespace

void add_paper_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<PaperOptions>();
  CLI::App* command =
      app.add_subcommand("paper", "The experiment of the paper: four scenarios over seeds, with figures and tables");
  command->footer("Example:\n  waymark paper --out out/paper --seeds 5 --noise 1");
  command->add_option("config", options->config, "the YAML of scenario 3, on the simulator")->capture_default_str();
  command->add_option("--out", options->out, "folder for paper.md, paper.json and paper/*.png")->capture_default_str();
  command
      ->add_option("--experiment", options->experiment, "scenarios: the four of the paper; signatures: rules compared")
      ->check(CLI::IsMember({"scenarios", "signatures"}))
      ->capture_default_str();
  command->add_option("--seeds", options->seeds, "seeds 1 to N")->check(CLI::Range(1, 100000))->capture_default_str();
  command->add_option("--noise", options->noises, "factors on the odometry's noise, in simulator and filter")
      ->delimiter(',')
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--set", options->overrides, "key=value: overrides a key of the YAML in all runs");
  command->add_option("--jobs", options->jobs, "courses at the same time (default: one per core)")
      ->check(CLI::Range(1, 1024));
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace waymark
