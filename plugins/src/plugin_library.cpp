// SPDX-License-Identifier: Apache-2.0
#include "plugin_library.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <map>
#include <mutex>
#include <system_error>

#define BOOST_DLL_USE_STD_FS
#include <boost/dll/shared_library.hpp>

namespace waymark {
namespace {

constexpr const char* kSymbol = "waymark_plugin";

using Library = std::shared_ptr<const boost::dll::shared_library>;

struct OpenLibraries {
  std::mutex mutex;
  std::map<std::filesystem::path, Library> by_path;
};

// Never destroyed: a library that is unloaded at exit would take away the code of objects that still wait for their
// destructor.
OpenLibraries& open_libraries() {
  static auto& libraries = *new OpenLibraries;
  return libraries;
}

// The dynamic linker's own words, without the file that they may start with.
std::string load_error(const std::filesystem::path& path, const std::error_code& error) {
  const char* words = dlerror();
  if (words == nullptr) return error.message();
  const std::string_view reason = words;
  const std::string prefix = path.string() + ": ";
  return std::string(reason.starts_with(prefix) ? reason.substr(prefix.size()) : reason);
}

Library load(const std::filesystem::path& path) {
  using boost::dll::load_mode::rtld_local;
  using boost::dll::load_mode::rtld_now;
  std::error_code error;
  auto library = std::make_shared<boost::dll::shared_library>();
  library->load(path, rtld_now | rtld_local, error);
  if (error) throw PluginError(fmt::format("cannot be loaded: {}", load_error(path, error)));
  return library;
}

std::filesystem::path canonical_path(const std::filesystem::path& file) {
  std::error_code error;
  auto path = std::filesystem::canonical(file, error);
  if (error) throw PluginError(error.message());
  if (!std::filesystem::is_regular_file(path, error)) throw PluginError("is not a file");
  return path;
}

PluginLibrary open(const std::filesystem::path& file) {
  const auto path = canonical_path(file);
  auto& libraries = open_libraries();
  const std::lock_guard lock(libraries.mutex);
  auto found = libraries.by_path.find(path);
  if (found == libraries.by_path.end()) found = libraries.by_path.emplace(path, load(path)).first;
  const Library& library = found->second;
  if (!library->has(kSymbol)) {
    throw PluginError(fmt::format(
        "is a library, but not a waymark plugin: it does not export \"{}\" (is the line WAYMARK_PLUGIN(...) missing?)",
        kSymbol));
  }
  return {library, &library->get<const PluginDescriptor>(kSymbol)};
}

}  // namespace

PluginLibrary open_plugin_library(const std::filesystem::path& file) {
  try {
    return open(file);
  } catch (const PluginError& error) {
    throw PluginError(fmt::format("{}: {}", file.string(), error.what()));
  }
}

std::string misfit(const PluginDescriptor& descriptor) {
  if (descriptor.abi != kPluginAbi) {
    return fmt::format("built for plugin ABI {}, this program has {}; rebuild the plugin", descriptor.abi, kPluginAbi);
  }
  if (descriptor.build_key == nullptr || descriptor.kind == nullptr || descriptor.name == nullptr ||
      descriptor.version == nullptr || descriptor.create == nullptr) {
    return "its descriptor is incomplete; use WAYMARK_PLUGIN(...)";
  }
  if (std::string_view(descriptor.build_key) != kBuildKey) {
    return fmt::format("built with \"{}\", this program with \"{}\"; rebuild the plugin", descriptor.build_key,
                       kBuildKey);
  }
  if (descriptor.eigen_max_align != EIGEN_MAX_ALIGN_BYTES) {
    return fmt::format("built with an Eigen alignment of {} bytes, this program with {}; different -march?",
                       descriptor.eigen_max_align, EIGEN_MAX_ALIGN_BYTES);
  }
  return {};
}

std::string plugin_name_of(const std::filesystem::path& file) {
  constexpr std::string_view kPrefix = "waymark_";
  const std::string stem = file.stem().string();
  if (file.extension() != ".so" || !stem.starts_with(kPrefix)) return {};
  return stem.substr(kPrefix.size());
}

}  // namespace waymark
