// SPDX-License-Identifier: Apache-2.0
#include "waymark/testing/sink_contract.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <system_error>
#include <thread>

#include "findings.hpp"
#include "scripted_run.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/testing/keys_contract.hpp"

namespace waymark::testing {

namespace {

namespace fs = std::filesystem;

/// A folder for one check, removed at its end.
class Workplace {
 public:
  Workplace() {
    std::string pattern = (fs::temp_directory_path() / "waymark_sink_XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) throw std::system_error(errno, std::generic_category(), pattern);
    root_ = fs::canonical(pattern);
  }
  ~Workplace() {
    std::error_code ignored;
    fs::remove_all(root_, ignored);
  }
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;

  const fs::path& root() const { return root_; }
  /// A new output folder with an empty folder around it. All have one name, which a file may contain.
  fs::path new_folder() {
    fs::path folder = root_ / std::to_string(++count_) / "out";
    fs::create_directories(folder);
    return folder;
  }

 private:
  fs::path root_;
  int count_ = 0;
};

/// Relative names below a folder and the bytes of the regular files; folders have none.
std::map<std::string, std::string> content_of(const fs::path& folder) {
  std::map<std::string, std::string> content;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    std::string& bytes = content[entry.path().lexically_relative(folder).string()];
    if (!entry.is_regular_file()) continue;
    std::ifstream in(entry.path(), std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return content;
}

/// Regular files that this process has open for writing.
std::set<std::string> open_for_writing() {
  std::set<std::string> files;
  std::error_code ignored;
  for (fs::directory_iterator entry("/proc/self/fd", ignored), end; entry != end; entry.increment(ignored)) {
    const int descriptor = std::atoi(entry->path().filename().c_str());
    const int flags = ::fcntl(descriptor, F_GETFL);
    struct stat status {};
    if (flags < 0 || (flags & O_ACCMODE) == O_RDONLY || ::fstat(descriptor, &status) != 0) continue;
    if (S_ISREG(status.st_mode)) files.insert(fs::read_symlink(entry->path(), ignored).string());
  }
  return files;
}

/// How a run ends.
enum class End { with_snapshot, interrupted, with_nothing, never_started, without_finish };

class Check {
 public:
  Check(const MakeSink& make, const std::string& yaml, const SinkSetting& setting, Findings& findings)
      : make_(make), yaml_(yaml), setting_(setting), findings_(findings) {}

  /// One run with its output folder. Returns what is in that at the end.
  std::map<std::string, std::string> run(StateLayout::Motion motion, End end, std::string_view which) {
    const fs::path out = workplace_.new_folder();
    const auto before = content_of(workplace_.root());
    const std::set<std::string> open_before = open_for_writing();
    findings_.part(which, [&] {
      const auto sink = new_sink();
      findings_.require(content_of(workplace_.root()) == before, "the constructor writes files");
      sink->start(info(out));
      drive(*sink, motion, end, out, open_before);
    });
    for (const std::string& file : open_for_writing()) {
      findings_.require(open_before.contains(file), "a file is still open when the sink is gone", file);
    }
    check_place(out, which);
    return content_of(out);
  }

  /// The same on a folder that does not exist, or that goes away after `steps` steps.
  void run_without_folder(std::size_t steps) {
    const fs::path out = workplace_.new_folder();
    if (steps == 0) fs::remove_all(out);
    const auto sink = new_sink();
    try {
      sink->start(info(out));
      ScriptedRun script(StateLayout::Motion::planar);
      for (std::size_t k = 0; k < ScriptedRun::kSteps; ++k) {
        if (k == steps) fs::remove_all(out);
        const Snapshot& snapshot = script.at(k);
        sink->arrived(snapshot.measurement());
        sink->write(snapshot);
      }
      sink->finish(&script.at(ScriptedRun::kSteps), ScriptedRun::report(ScriptedRun::kSteps));
    } catch (const Error& error) {
      findings_.require(!std::string_view(error.what()).empty(), "an Error has no text");
    } catch (const fs::filesystem_error&) {
      return;  // names its file
    } catch (const std::exception& error) {
      findings_.add("without its folder the sink throws something else than an Error", error.what());
    } catch (...) {
      findings_.add("without its folder the sink throws something that is not a std::exception");
    }
  }

  /// Calls of the thread of outputs and of a user's program during the run.
  void run_with_threads() {
    const fs::path out = workplace_.new_folder();
    const auto sink = new_sink();
    ScriptedRun script(StateLayout::Motion::planar);
    ScriptedRun front(StateLayout::Motion::planar);
    front.at(0);
    sink->start(info(out));
    std::atomic<bool> has_bad_event = false;
    std::atomic<bool> has_thrown = false;
    std::atomic<bool> was_called = false;
    {
      const std::jthread other([&](const std::stop_token& stop) {
        try {
          while (!stop.stop_requested()) {
            sink->front(front.belief());
            for (const std::string& event : sink->take_events())
              if (event.empty() || event.find('\n') != std::string::npos) has_bad_event = true;
            was_called = true;
            std::this_thread::yield();
          }
        } catch (...) {
          has_thrown = was_called = true;
        }
      });
      for (std::size_t k = 0; k < ScriptedRun::kSteps; ++k) {
        const Snapshot& snapshot = script.at(k);
        sink->arrived(snapshot.measurement());
        if (k % 10 == 9) {
          sink->dropped(snapshot.measurement());
        } else {
          sink->write(snapshot);
        }
      }
      while (!was_called) std::this_thread::yield();
    }
    findings_.require(!has_thrown, "front or take_events threw");
    findings_.require(!has_bad_event, "take_events gives a text that is empty or has several lines");
    sink->finish(&script.at(ScriptedRun::kSteps), ScriptedRun::report(ScriptedRun::kSteps));
  }

 private:
  std::shared_ptr<Sink> new_sink() {
    auto sink = make_(Config::parse(yaml_, (workplace_.root() / "robot.yaml").string()), ScriptedRun::rig());
    if (!sink) throw Error("make gives null");
    return sink;
  }

  RunInfo info(const fs::path& out) const {
    return {out, &ScriptedRun::rig(), ScriptedRun::reference(), setting_.run_config, "robot"};
  }

  void drive(Sink& sink, StateLayout::Motion motion, End end, const fs::path& out,
             const std::set<std::string>& open_before) {
    ScriptedRun script(motion);
    const std::size_t steps = end == End::with_nothing ? 0 : end == End::never_started ? 3 : ScriptedRun::kSteps;
    const Snapshot* last = nullptr;
    for (std::size_t k = 0; k < steps; ++k) {
      last = &script.at(k);
      sink.arrived(last->measurement());
      if (k == steps / 2) sink.commanded(last->measurement().arrival, "pause");
      sink.write(*last);
    }
    for (const std::string& file : open_for_writing()) {
      findings_.require(open_before.contains(file) || file.starts_with(out.string() + "/"),
                        "a file outside of the output folder is open for writing", file);
    }
    if (end == End::without_finish) return;
    RunReport report = ScriptedRun::report(steps);
    report.interrupted = end == End::interrupted;
    sink.finish(last, report);
  }

  void check_place(const fs::path& out, std::string_view which) {
    for (const auto& [name, bytes] : content_of(out)) {
      findings_.require(!name.ends_with(kPartialSuffix), "an incomplete file is left",
                        fmt::format("{}: {}", which, name));
    }
    for (const fs::directory_entry& entry : fs::directory_iterator(out.parent_path())) {
      findings_.require(entry.path() == out, "something is written outside of the output folder",
                        entry.path().lexically_relative(out).string());
    }
    for (const fs::directory_entry& entry : fs::directory_iterator(workplace_.root())) {
      findings_.require(entry.is_directory(), "something is written outside of the output folder",
                        entry.path().lexically_relative(out).string());
    }
  }

  const MakeSink& make_;
  const std::string& yaml_;
  const SinkSetting& setting_;
  Findings& findings_;
  Workplace workplace_;
};

/// The first file that differs, or is in one of both only; empty if there is none.
std::string difference(const std::map<std::string, std::string>& a, const std::map<std::string, std::string>& b) {
  for (const auto& [name, bytes] : a) {
    const auto found = b.find(name);
    if (found == b.end() || found->second != bytes) return name;
  }
  for (const auto& [name, bytes] : b) {
    if (!a.contains(name)) return name;
  }
  return "";
}

}  // namespace

Violations check_sink(const MakeSink& make, const std::string& yaml, const SinkSetting& setting) {
  Violations found = check_keys([&](const Config& config) { make(config, ScriptedRun::rig()); }, yaml);
  if (!found.empty()) return found;
  Findings findings;
  findings.part("the check", [&] {
    using Motion = StateLayout::Motion;
    Check check(make, yaml, setting, findings);
    const auto first = check.run(Motion::planar, End::with_snapshot, "a run");
    const auto second = check.run(Motion::planar, End::with_snapshot, "a second run");
    const std::string differs = difference(first, second);
    findings.require(!setting.same_bytes || differs.empty(), "two equal runs write different files", differs);
    check.run(Motion::spatial, End::with_snapshot, "a run in three dimensions");
    check.run(Motion::planar, End::interrupted, "an interrupted run");
    check.run(Motion::planar, End::with_nothing, "a run without a snapshot");
    check.run(Motion::planar, End::never_started, "a run whose filter never started");
    check.run(Motion::planar, End::without_finish, "a run without finish");
    findings.part("a run without its folder", [&] { check.run_without_folder(0); });
    findings.part("a run whose folder vanishes", [&] { check.run_without_folder(ScriptedRun::kSteps / 2); });
    findings.part("a run with more threads", [&] { check.run_with_threads(); });
  });
  return findings.take();
}

}  // namespace waymark::testing
