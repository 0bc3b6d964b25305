// SPDX-License-Identifier: Apache-2.0
#include "waymark/plugin_inspection.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <string_view>

#include "plugin_file.hpp"

namespace waymark {
namespace {

// What of a plugin that fits would be refused at load.
std::string other_problem(const PluginInfo& info, const PluginRecord& record) {
  constexpr std::string_view kKinds[] = {"sensor", "map_module", "source", "sink"};
  if (std::ranges::find(kKinds, info.kind) == std::end(kKinds)) {
    return fmt::format("is a plugin of kind \"{}\"; there are {}", info.kind, fmt::join(kKinds, ", "));
  }
  const std::string of_file = plugin_name_of(info.file);
  if (of_file.empty()) {
    return fmt::format("its file is not called waymark_{}.so, so no search finds it", info.name);
  }
  if (of_file != info.name)
    return fmt::format("calls itself \"{}\", but its file name says \"{}\"", info.name, of_file);
  const auto abi = read_symbol_abi(info.file);
  if (!abi) return not_a_plugin().what();
  return *abi == record.abi ? "" : "its symbol \"waymark_plugin\" has another ABI than its section; rebuild the plugin";
}

}  // namespace

PluginInspection inspect_plugin(const std::filesystem::path& file) {
  const PluginRecord record = read_plugin_record(file);
  PluginInspection found;
  found.file = file;
  found.abi = record.abi;
  found.problem = misfit(record);
  if (record.abi != kPluginAbi) return found;
  found.eigen_max_align = record.eigen_max_align;
  found.build_key = record_text(record.build_key);
  found.kind = record_text(record.kind);
  found.name = record_text(record.name);
  found.version = record_text(record.version);
  if (found.problem.empty()) found.problem = other_problem(found, record);
  return found;
}

}  // namespace waymark
