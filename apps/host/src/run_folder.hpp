// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace waymark::host {

/// The output folder of a run, which it owns: at its end the files of an earlier run that it did not write anew are
/// removed. Only what a run wrote (written_files.hpp) and nobody has changed since is removed; flight records and
/// checkpoints stay.
class RunFolder {
 public:
  /// What happened to the files of an earlier run.
  struct Replaced {
    bool any = false;                  ///< there was an earlier run
    std::vector<std::string> removed;  ///< names within the folder
    std::vector<std::string> changed;  ///< changed since that run, so they stay
    std::vector<std::string> left;     ///< they stay since this run is not complete
  };

  /// Opens the list of what this run writes. The folder is locked. Throws Error if it cannot be created.
  explicit RunFolder(std::filesystem::path folder);

  /// Ends the run. `complete`: all its results were written. Throws Error if the list cannot be written.
  Replaced finish(bool complete);

 private:
  /// Size [bytes] and time of the last change, as the file system gives it.
  struct State {
    std::uintmax_t size = 0;
    std::filesystem::file_time_type changed;
    bool operator==(const State&) const = default;
  };

  static bool read(const std::filesystem::path& file, State& state);
  void take_over(const std::filesystem::path& list, bool with_sizes);
  void write_list(const std::set<std::string>& names) const;
  void remove(const std::string& name) const;

  std::filesystem::path folder_;
  bool any_older_ = false;
  std::map<std::string, State> older_;  // as the earlier runs left them
  std::set<std::string> changed_;       // since
};

}  // namespace waymark::host
