// SPDX-License-Identifier: Apache-2.0
#include "waymark/io/written_files.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <string>

namespace waymark {

void note_written(const std::filesystem::path& file) {
  constexpr int kMostFolders = 8;
  const std::filesystem::path normal = file.lexically_normal();
  std::filesystem::path folder = normal.parent_path();
  std::filesystem::path name = normal.filename();
  if (name.string().find('\n') != std::string::npos) return;  // a name is a line
  for (int i = 0; i < kMostFolders; ++i) {
    const std::filesystem::path list = folder / kOpenWrittenFilesList;
    const int descriptor = ::open(list.c_str(), O_WRONLY | O_APPEND | O_NOFOLLOW | O_CLOEXEC);
    if (descriptor >= 0) {
      const std::string line = name.string() + '\n';
      // A line that is cut off names no file.
      [[maybe_unused]] const ssize_t written = ::write(descriptor, line.data(), line.size());
      ::close(descriptor);
      return;
    }
    if (folder.empty() || folder == folder.parent_path()) return;
    name = folder.filename() / name;
    folder = folder.parent_path();
  }
}

}  // namespace waymark
