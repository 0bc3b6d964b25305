// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/reference.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <tuple>

#include "waymark/base/error.hpp"
#include "waymark/host/robot.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/plugin/map_module.hpp"
#include "waymark/plugin/sensor.hpp"
#include "waymark/plugin/sink.hpp"
#include "waymark/plugin/source.hpp"

namespace waymark::host {

namespace {

/// What keys that take text are tried with: the name of a sensor, of a table's file, and of a column in it.
constexpr const char* kText = "sample";
constexpr const char* kOtherSensor = "other_sample";

/// A folder with that table.
class SampleFolder {
 public:
  SampleFolder() : folder_(create()) { std::ofstream(folder_ / kText) << kText << ",b,c,d\n1,2,3,4\n2,3,4,5\n"; }
  ~SampleFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  SampleFolder(const SampleFolder&) = delete;
  SampleFolder& operator=(const SampleFolder&) = delete;

  /// The configuration that lies in it, in name only.
  std::string config_file() const { return (folder_ / "trial.yaml").string(); }

 private:
  static std::filesystem::path create() {
    std::string name = (std::filesystem::temp_directory_path() / "waymark_keys_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      throw Error("cannot create a folder in " + std::filesystem::temp_directory_path().string());
    return name;
  }

  std::filesystem::path folder_;
};

/// A robot with a sensor for whatever a plugin asks for.
Rig any_rig() {
  std::vector<Mounting> mountings;
  const Intrinsics camera{640, 480, 500.0, 500.0, 320.0, 240.0, {}};
  const Pose above_ground{Eigen::Quaterniond::Identity(), {0.0, 0.0, 1.0}};
  mountings.push_back({kText, "", above_ground, camera});
  mountings.push_back({kOtherSensor, "", above_ground, camera});
  for (const std::string_view payload : {LaserScan::kType, PointCloud::kType, Image::kType, LandmarkObservations::kType,
                                         Ranges::kType, RadarTargets::kType})
    mountings.push_back({std::string(payload), std::string(payload), above_ground, camera});
  return Rig(std::move(mountings));
}

KeyTrials trials_of_sensor() { return {{fmt::format("name={}", kText)}, {kText}, {}}; }

/// A source asks for the fields of a payload, so it is tried with each.
KeyTrials trials_of_source() {
  KeyTrials trials{{}, {kText, kOtherSensor}, {}};
  const auto add = [&](std::string_view type) { trials.texts.emplace_back(short_type_name(type)); };
  std::apply([&]<class... P>(const P&...) { (add(P::kType), ...); }, CorePayloads());
  return trials;
}

std::vector<KeyTrials> trials_of_map() {
  const auto with = [](const std::string& inputs) {
    return KeyTrials{{"name=map", fmt::format("inputs=[{}]", inputs)}, {kText}, {}};
  };
  const auto quoted = [](std::string_view payload) { return fmt::format("\"{}\"", payload); };
  return {with(quoted(LaserScan::kType)),
          with(quoted(LaserScan::kType) + ", " + quoted(Image::kType)),
          with(quoted(LandmarkObservations::kType)),
          with(quoted(PointCloud::kType)),
          with(quoted(Ranges::kType)),
          with(quoted(RadarTargets::kType))};
}

void append_new(std::vector<DescribedKey>& keys, std::vector<DescribedKey> more) {
  for (DescribedKey& key : more) {
    if (find_key(keys, key.asked.path) == nullptr) keys.push_back(std::move(key));
  }
}

template <class Interface>
std::vector<DescribedKey> keys_of(const PluginLoader& loader, const std::string& name,
                                  const std::vector<KeyTrials>& trials) {
  const Rig rig = any_rig();
  const SampleFolder sample;
  std::vector<DescribedKey> keys;
  for (KeyTrials each : trials) {
    each.file = sample.config_file();
    append_new(keys, describe_keys([&](const Config& config) { loader.create<Interface>(name, config, rig); }, each));
  }
  return keys;
}

std::string parent(const std::string& path) {
  const std::size_t dot = path.rfind('.');
  return dot == std::string::npos ? "" : path.substr(0, dot);
}

/// What must be given beside a key for it to be read: "with `model: ackermann`"; empty if the meaning states it.
std::string condition(const DescribedKey& key, const std::vector<DescribedKey>& all) {
  using Type = Config::Asked::Type;
  std::string text;
  for (const std::string& given : key.given) {
    const std::string path = given.substr(0, given.find('='));
    if (parent(path) != parent(key.asked.path) || path == key.asked.path) continue;
    const DescribedKey* of = find_key(all, path);
    if (of == nullptr || of->asked.type == Type::text || of->asked.type == Type::none) continue;
    const bool shows_value = of->asked.type == Type::choice || of->asked.type == Type::boolean;
    const std::string name = path.substr(path.rfind('.') + 1);
    const std::string condition =
        fmt::format("`{}{}`", name, shows_value ? ": " + given.substr(given.find('=') + 1) : "");
    if (key.asked.meaning.find(condition) != std::string::npos) continue;
    text += fmt::format("{} {}", text.empty() ? "with" : ",", condition);
  }
  return text;
}

/// A default that was computed, such as from degrees, in as many digits as a person reads.
std::string readable(const std::string& value) {
  char* end = nullptr;
  const double number = std::strtod(value.c_str(), &end);
  const bool is_number = !value.empty() && *end == '\0';
  return is_number && value.size() > 8 ? fmt::format("{:.4g}", number) : value;
}

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) result += c == '|' ? std::string("\\|") : std::string(1, c);
  return result;
}

}  // namespace

std::vector<DescribedKey> robot_keys() {
  const PluginLoader none({});
  const auto read = [&none](const Config& yaml) {
    plugin_loader(yaml);
    Robot::load(yaml, none);
  };
  return describe_keys(read, {{}, {"x"}, "trial"});
}

std::vector<DescribedKey> plugin_keys(const PluginLoader& loader, const PluginInfo& plugin) {
  if (plugin.kind == PluginKind<Sensor>::kName) return keys_of<Sensor>(loader, plugin.name, {trials_of_sensor()});
  if (plugin.kind == PluginKind<MapModule>::kName) return keys_of<MapModule>(loader, plugin.name, trials_of_map());
  if (plugin.kind == PluginKind<Source>::kName) return keys_of<Source>(loader, plugin.name, {trials_of_source()});
  return keys_of<Sink>(loader, plugin.name, {{{}, {kText}, {}}});
}

std::string key_table(const std::vector<DescribedKey>& keys) {
  std::string table = "| key | value | unit | default | meaning |\n|---|---|---|---|---|\n";
  for (const DescribedKey& key : keys) {
    const Config::Asked& asked = key.asked;
    if (asked.meaning.empty()) continue;  // of the host, or only looked for
    std::string meaning = asked.meaning;
    if (const std::string given = condition(key, keys); !given.empty()) meaning += "; " + given;
    const std::string fallback = asked.is_required ? "required" : readable(asked.fallback.value_or(""));
    table += fmt::format("| `{}` | {} | {} | {} | {} |\n", asked.path, escaped(asked.expectation()), asked.unit,
                         escaped(fallback), escaped(meaning));
  }
  return table;
}

}  // namespace waymark::host
