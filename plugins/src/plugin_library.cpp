// SPDX-License-Identifier: Apache-2.0
#include "plugin_library.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <system_error>

#include "plugin_file.hpp"

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
  return path;
}

// Throws unless the symbol agrees with the file's record. `abi` is compared first: the rest is of this program's layout
// only if it is equal.
void require_same(const PluginDescriptor& descriptor, const PluginRecord& record) {
  const auto same = [](const char* text, std::string_view recorded) { return text != nullptr && recorded == text; };
  if (descriptor.abi != record.abi || descriptor.eigen_max_align != record.eigen_max_align ||
      !same(descriptor.build_key, record_text(record.build_key)) || !same(descriptor.kind, record_text(record.kind)) ||
      !same(descriptor.name, record_text(record.name)) || !same(descriptor.version, record_text(record.version))) {
    throw PluginError(fmt::format(
        "its symbol \"{}\" differs from its section \"{}\"; use WAYMARK_PLUGIN(...), and start again if the "
        "plugin was rebuilt meanwhile",
        kSymbol, WAYMARK_PLUGIN_SECTION));
  }
  if (descriptor.create == nullptr) throw PluginError("its descriptor is incomplete; use WAYMARK_PLUGIN(...)");
}

void register_payloads(const PluginDescriptor& descriptor) {
  try {
    descriptor.register_payloads();
  } catch (const Error& error) {
    throw PluginError(error.what());
  }
}

PluginLibrary open(const std::filesystem::path& file, const PluginRecord& record) {
  const auto path = canonical_path(file);
  auto& libraries = open_libraries();
  const std::lock_guard lock(libraries.mutex);
  auto found = libraries.by_path.find(path);
  if (found == libraries.by_path.end()) found = libraries.by_path.emplace(path, load(path)).first;
  const Library& library = found->second;
  if (!library->has(kSymbol)) throw not_a_plugin();
  const auto& descriptor = library->get<const PluginDescriptor>(kSymbol);
  require_same(descriptor, record);
  if (descriptor.register_payloads != nullptr) register_payloads(descriptor);
  return {library, &descriptor};
}

}  // namespace

PluginLibrary open_plugin_library(const std::filesystem::path& file, const PluginRecord& record) {
  try {
    return open(file, record);
  } catch (const PluginError& error) {
    throw PluginError(fmt::format("{}: {}", file.string(), error.what()));
  }
}

}  // namespace waymark
