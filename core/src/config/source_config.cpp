// SPDX-License-Identifier: Apache-2.0
#include "waymark/config/source_config.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include "waymark/config/nearest_name.hpp"

namespace waymark {

Channel channel_to_sensor(const Config& entry, const Rig& rig, std::string_view payload, std::string_view giver) {
  const std::string sensor = entry.text({"sensor", "name of the sensor under `sensors` that takes the measurements"});
  const int index = rig.find(sensor);
  if (index < 0) {
    std::vector<std::string> names;
    names.reserve(rig.mountings().size());
    for (const Mounting& mounting : rig.mountings()) names.push_back(mounting.name);
    const std::string nearest = nearest_name(sensor, names);
    entry.fail("sensor", fmt::format("there is no sensor \"{}\" under sensors{}; there are: {}", sensor,
                                     nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest),
                                     fmt::join(names, ", ")));
  }
  const std::string& takes = rig.mountings()[static_cast<std::size_t>(index)].payload;
  if (!takes.empty() && takes != payload)
    entry.fail("sensor", fmt::format("sensor \"{}\" takes {}, but {} gives {}", sensor, takes, giver, payload));
  return {sensor, std::string(payload)};
}

std::filesystem::path readable_file(const Config& config, const Config::Key& key) {
  std::filesystem::path file = config.file().parent_path() / config.text(key);
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored))
    config.fail(key.name, file.string() + " is a folder, a file is expected");
  if (::access(file.c_str(), R_OK) != 0)
    config.fail(key.name, file.string() + " cannot be read: " + std::strerror(errno));
  return file;
}

}  // namespace waymark
