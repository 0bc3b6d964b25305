// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "waymark/base/api.hpp"

namespace waymark {

/// What the name of a file ends in until the file is complete.
inline constexpr std::string_view kPartialSuffix = ".partial";

/// A file that appears under its name only when it is complete: text is written to `<name>.partial`, and `commit`
/// renames it. If the disk is full, all complete lines are kept under the name, and Error is thrown.
class WAYMARK_API OutputFile {
 public:
  /// Throws Error if the file cannot be created.
  explicit OutputFile(std::filesystem::path path);
  /// Without `commit` the partial file is removed.
  ~OutputFile();
  OutputFile(OutputFile&&) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;

  /// Appends text; buffered. Throws Error naming the file and the system's reason.
  void write(std::string_view text);
  /// Writes the buffer, syncs and renames. Throws Error; the complete lines are then kept.
  void commit();

 private:
  void flush();
  [[noreturn]] void fail(const char* doing, int system_error);

  std::filesystem::path path_;
  std::filesystem::path partial_;
  std::string buffer_;
  int descriptor_ = -1;
  std::size_t written_ = 0;
  std::size_t last_line_end_ = 0;
};

/// Whether a file belongs to the results of a run: then the next run in the folder replaces it (written_files.hpp).
enum class Belongs { to_run, to_nobody };

/// Writes a whole file, or none. Throws Error.
WAYMARK_API void write_file(const std::filesystem::path& path, std::string_view content,
                            Belongs belongs = Belongs::to_run);

/// Creates a folder and its missing parents. Throws Error with its path, `what`, and the system's reason.
WAYMARK_API void create_folder(const std::filesystem::path& folder, std::string_view what = "folder");

}  // namespace waymark
