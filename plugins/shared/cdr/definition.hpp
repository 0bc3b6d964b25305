// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/shared/cdr/wire_reader.hpp"

namespace waymark::ros {

/// A definition read from its text (`ros2msg`): the types of the fields on the wire, for messages that no struct stands
/// for, and to compare a recorded definition with ours.
class Definition {
 public:
  /// `type`: "dvl_msgs/msg/DVL". Throws Unusable if the text is not a definition, lacks a type, or unfolds to more than
  /// some thousand fields.
  Definition(std::string_view type, std::string_view text);

  /// The types on the wire, field by field, without their names: equal for two definitions of which each reads what the
  /// other writes.
  const std::string& layout() const { return layout_; }

  /// Names of all fields that are numbers: "velocity.x", "covariance[3]"; none within lists and long arrays.
  const std::vector<std::string>& number_paths() const { return paths_; }

  /// The numbers of a message in CDR, one for each of `number_paths`. Throws Unusable.
  std::vector<double> numbers(Bytes message) const;
  std::vector<double> numbers(WireReader in) const;

 private:
  enum class Primitive : std::uint8_t { u1, i1, u2, i2, u4, i4, u8, i8, f4, f8, boolean, text };
  struct Node {
    std::optional<Primitive> primitive;  ///< nothing: of `fields`
    std::vector<Node> fields;
    bool is_list = false;   ///< a count, then so many of them
    std::size_t count = 1;  ///< otherwise
    bool is_named = true;   ///< its numbers are among the paths, unless it lies within a list
    std::size_t least_size = 0;
  };
  class Parser;

  static double number(Primitive primitive, WireReader& in);
  static void read_one(const Node& node, WireReader& in, std::vector<double>* numbers);
  static void read(const Node& node, WireReader& in, std::vector<double>* numbers);

  std::string type_;
  Node root_;
  std::string layout_;
  std::vector<std::string> paths_;
};

}  // namespace waymark::ros
