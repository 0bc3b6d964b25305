// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/flight_record.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <system_error>

#include "waymark/base/error.hpp"
#include "waymark/io/file_stems.hpp"
#ifdef WAYMARK_HAS_MCAP
#include "plugins/shared/mcap/mcap_log.hpp"
#endif

namespace waymark::host {

bool is_flight_record(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  return name.ends_with(".mcap") || name.ends_with(".mcap.gz") || name.ends_with(".mcap.zst");
}

#ifdef WAYMARK_HAS_MCAP
namespace {

/// What the source of a replay takes the place of, and what only a running robot has.
constexpr std::array<std::string_view, 4> kOfLiveRun{"source:", "sources:", "live:", "record:"};

/// An effective configuration is written with its top level at the start of the lines.
std::string without_live_parts(std::string_view yaml) {
  std::string rest;
  bool keeps = true;
  while (!yaml.empty()) {
    const std::size_t end = std::min(yaml.find('\n'), yaml.size() - 1) + 1;
    const std::string_view line = yaml.substr(0, end);
    yaml.remove_prefix(end);
    if (!line.starts_with(' '))
      keeps = std::ranges::none_of(kOfLiveRun, [&](std::string_view key) { return line.starts_with(key); });
    if (keeps) rest += line;
  }
  return rest;
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"' || text[i] == '\\') result += '\\';
    if (text.compare(i, 2, "${") == 0) result += '$';  // or it would be taken for a variable
    result += text[i];
  }
  return result + '"';
}

/// The YAML of the run, where it was then; empty if that was not recorded.
std::filesystem::path config_file_of(mcap::McapFile& record) {
  for (const mcap::Metadata& metadata : record.metadata()) {
    for (const auto& [key, value] : metadata.metadata) {
      if (key == "config_file") return value;
    }
  }
  return {};
}

/// From which relative paths count.
std::filesystem::path folder_of(const std::filesystem::path& config_file, const std::filesystem::path& record) {
  std::error_code error;
  const std::filesystem::path folder = config_file.parent_path();
  return std::filesystem::is_directory(folder, error) ? folder : std::filesystem::absolute(record).parent_path();
}

/// A record is data, and may come from anybody: it brings no code, and none of what only a running robot has. Throws
/// Error.
void require_harmless(const Config& recorded, const std::vector<Config::Override>& overrides, const std::string& name) {
  for (const std::string_view key : kOfLiveRun) {
    if (recorded.has(std::string(key.substr(0, key.size() - 1))))
      throw Error(fmt::format("{}: \"{}\" is not written as a run writes it", name, key));
  }
  const auto is_of_path = [](const std::string& override) { return override.starts_with("plugin_path"); };
  if (!recorded.has("plugin_path") || std::ranges::any_of(overrides, is_of_path)) return;
  const std::vector<std::string> folders = recorded.texts("plugin_path");
  if (folders.empty()) return;
  throw Error(
      fmt::format("{}: plugin_path: the record names folders whose plugins would run: {}; --set plugin_path=[FOLDER] "
                  "permits that, --set plugin_path=[] does without",
                  name, fmt::join(folders, ", ")));
}

}  // namespace

RecordedRun recorded_run(const std::filesystem::path& file, std::vector<Config::Override> overrides) {
  mcap::McapLog log({file});
  mcap::McapFile& record = log.files().front();
  const auto attached = record.attachment(kEffectiveConfigFile);
  if (!attached)
    throw Error(fmt::format(
        "{}: it is not a flight record: it has no attachment {}; other MCAP files are the `file` of a source "
        "mcap in a YAML",
        file.string(), kEffectiveConfigFile));
  const std::string yaml = without_live_parts({reinterpret_cast<const char*>(attached->data()), attached->size()});
  const std::string source =
      fmt::format("source:\n  plugin: mcap\n  file: {}\n", quoted(std::filesystem::absolute(file).string()));
  if (yaml.find("plugin: recorder") != std::string::npos)
    overrides.insert(overrides.begin(), "sinks.recorder.enabled=false");
  const std::filesystem::path config_file = config_file_of(record);
  const std::filesystem::path name =
      folder_of(config_file, file) / fmt::format("{}: {}", file.filename().string(), kEffectiveConfigFile);
  require_harmless(Config::parse(yaml, name.string()), overrides, name.string());
  return {Config::parse(yaml + source, name.string(), overrides), (config_file.empty() ? file : config_file).stem()};
}
#else
RecordedRun recorded_run(const std::filesystem::path& file, std::vector<Config::Override>) {
  throw Error(fmt::format("{}: this build cannot read MCAP: zlib, liblz4 or libzstd was missing", file.string()));
}
#endif

}  // namespace waymark::host
