// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/input.hpp"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "waymark/base/error.hpp"

namespace waymark::fuzz {
namespace {

class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "waymark_fuzz_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder for the input");
    path = name;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::filesystem::path path;
};

}  // namespace

std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

Choice choose(std::string_view input, std::size_t count) {
  if (input.empty()) return {};
  return {static_cast<unsigned char>(input.front()) % count, input.substr(1)};
}

const std::filesystem::path& folder() {
  static const Folder kFolder;
  return kFolder.path;
}

std::filesystem::path write(const std::filesystem::path& name, std::string_view content) {
  const std::filesystem::path file = folder() / name;
  if (name.has_parent_path()) std::filesystem::create_directories(file.parent_path());
  std::ofstream out(file, std::ios::binary);
  out << content;
  if (!out.flush()) throw std::runtime_error("the input cannot be written to " + file.string());
  return file;
}

void expect_value_or_error(const std::function<void()>& parse, std::string_view place) {
  try {
    parse();
  } catch (const Error& error) {
    const std::string_view line = error.what();
    if (line.empty() || line.find('\n') != std::string_view::npos)
      violation("an error is not one line: " + std::string(line));
    if (line.find(place) == std::string_view::npos)
      violation("an error does not contain \"" + std::string(place) + "\": " + std::string(line));
  }
}

void violation(std::string_view what) {
  std::fprintf(stderr, "violation: %.*s\n", static_cast<int>(what.size()), what.data());
  std::abort();
}

}  // namespace waymark::fuzz
