// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/dds/names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace waymark::dds {
namespace {

constexpr std::size_t kLongestTopic = 255;  // of DDS
constexpr std::string_view kInfix = "::dds_::";

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

bool is_word(std::string_view word) {
  return !word.empty() && !is_digit(word.front()) &&
         std::ranges::all_of(word, [](char c) { return is_letter(c) || is_digit(c) || c == '_'; });
}

/// Words between slashes.
bool is_path(std::string_view path) {
  for (std::size_t slash = path.find('/'); slash != std::string_view::npos; slash = path.find('/')) {
    if (!is_word(path.substr(0, slash))) return false;
    path.remove_prefix(slash + 1);
  }
  return is_word(path);
}

}  // namespace

std::string topic_name(std::string_view ros_topic) {
  const std::string_view path = ros_topic.starts_with('/') ? ros_topic.substr(1) : ros_topic;
  if (!is_path(path) || path.size() > kLongestTopic - 3) {
    throw std::invalid_argument(
        fmt::format("\"{}\" is no topic of ROS; words of letters, digits and _ between slashes "
                    "are expected, as in /imu/data",
                    ros_topic.substr(0, 100)));
  }
  return fmt::format("rt/{}", path);
}

std::string type_name(std::string_view ros_type) {
  const std::size_t first = ros_type.find('/');
  const std::size_t last = ros_type.rfind('/');
  const bool is_type = is_path(ros_type) && first != std::string_view::npos &&
                       (first == last || ros_type.substr(first, last - first) == "/msg");
  if (!is_type || ros_type.size() > kLongestTopic) {
    throw std::invalid_argument(
        fmt::format("\"{}\" is no type of a message; a name like sensor_msgs/msg/Imu is "
                    "expected",
                    ros_type.substr(0, 100)));
  }
  return fmt::format("{}::msg{}{}_", ros_type.substr(0, first), kInfix, ros_type.substr(last + 1));
}

std::string ros_type(std::string_view dds_type) {
  const std::size_t infix = dds_type.find(kInfix);
  if (infix == std::string_view::npos || !dds_type.ends_with('_')) return std::string(dds_type);
  const std::string_view name = dds_type.substr(infix + kInfix.size());
  std::string package(dds_type.substr(0, infix));
  for (std::size_t at = package.find("::"); at != std::string::npos; at = package.find("::", at))
    package.replace(at, 2, "/");
  return fmt::format("{}/{}", package, name.substr(0, name.size() - 1));
}

}  // namespace waymark::dds
