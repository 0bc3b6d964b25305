// SPDX-License-Identifier: Apache-2.0
#include "run_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <fstream>
#include <system_error>
#include <utility>

#include "waymark/base/error.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/io/written_files.hpp"

namespace waymark::host {

namespace {

constexpr const char* kComment = "# what waymark wrote here, and its size; the next run in this folder replaces it";

/// A list may come from anywhere: names that lead out of the folder name nothing.
bool lies_within(const std::filesystem::path& name) {
  const std::filesystem::path normal = name.lexically_normal();
  return !normal.empty() && normal.is_relative() && *normal.begin() != ".." && normal != ".";
}

}  // namespace

RunFolder::RunFolder(std::filesystem::path folder) : folder_(std::move(folder)) {
  take_over(folder_ / kWrittenFilesList, true);
  const std::filesystem::path open_list = folder_ / kOpenWrittenFilesList;
  take_over(open_list, false);  // of a run that was killed
  if (std::filesystem::exists(std::filesystem::symlink_status(open_list))) {
    std::set<std::string> names;
    for (const auto& [name, state] : older_) names.insert(name);
    write_list(names);
    ::unlink(open_list.c_str());
  }
  const int descriptor = ::open(open_list.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (descriptor < 0)
    throw Error(fmt::format("{}: creating: {}", open_list.string(), std::generic_category().message(errno)));
  ::close(descriptor);
}

bool RunFolder::read(const std::filesystem::path& file, State& state) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(std::filesystem::symlink_status(file, error)) || error) return false;
  state.size = std::filesystem::file_size(file, error);
  if (error) return false;
  state.changed = std::filesystem::last_write_time(file, error);
  return !error;
}

void RunFolder::take_over(const std::filesystem::path& list, bool with_sizes) {
  State of_list;
  if (!read(list, of_list)) return;
  any_older_ = true;
  std::ifstream in(list);
  for (std::string line; std::getline(in, line);) {
    if (in.eof() || line.empty() || line.front() == '#') continue;  // a line without its end is cut off
    std::uintmax_t size = 0;
    std::string name = line;
    if (with_sizes) {
      const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), size);
      if (error != std::errc() || end == line.data() + line.size() || *end != ' ') continue;
      name = line.substr(static_cast<std::size_t>(end - line.data()) + 1);
    }
    State state;
    if (!lies_within(name) || !read(folder_ / name, state)) continue;
    // The list is written last, so what is newer was changed by somebody else.
    if ((with_sizes && state.size != size) || state.changed > of_list.changed) {
      changed_.insert(name);
    } else {
      older_[name] = state;
      changed_.erase(name);
    }
  }
}

void RunFolder::write_list(const std::set<std::string>& names) const {
  std::string text = fmt::format("{}\n", kComment);
  for (const std::string& name : names) {
    State state;
    if (read(folder_ / name, state)) text += fmt::format("{} {}\n", state.size, name);
  }
  write_file(folder_ / kWrittenFilesList, text, Belongs::to_nobody);
}

void RunFolder::remove(const std::string& name) const {
  std::error_code error;
  std::filesystem::path path = folder_ / name;
  std::filesystem::remove(path, error);
  // Folders that are empty now held nothing else.
  for (std::filesystem::path within = std::filesystem::path(name).parent_path(); !within.empty() && !error;
       within = within.parent_path())
    std::filesystem::remove(folder_ / within, error);
}

RunFolder::Replaced RunFolder::finish(bool complete) {
  const std::filesystem::path open_list = folder_ / kOpenWrittenFilesList;
  std::set<std::string> names;
  {
    std::ifstream in(open_list);
    for (std::string line; std::getline(in, line);) {
      if (!in.eof() && lies_within(line)) names.insert(line);
    }
  }
  Replaced replaced;
  replaced.any = any_older_;
  for (const std::string& name : changed_) {
    if (!names.contains(name)) replaced.changed.push_back(name);
  }
  for (const auto& [name, before] : older_) {
    State now;
    if (names.contains(name) || !read(folder_ / name, now)) continue;
    if (now != before) {
      replaced.changed.push_back(name);
    } else if (complete) {
      remove(name);
      replaced.removed.push_back(name);
    } else {
      replaced.left.push_back(name);
      names.insert(name);
    }
  }
  write_list(names);
  ::unlink(open_list.c_str());
  return replaced;
}

}  // namespace waymark::host
