// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/cdr/definition.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <utility>

#include "plugins/shared/cdr/definition_text.hpp"
#include "plugins/shared/cdr/message.hpp"

namespace waymark::ros {
namespace {

constexpr std::size_t kMostFields = 5000;
constexpr std::size_t kDeepest = 32;
constexpr std::size_t kLongestArray = 1 << 20;
constexpr std::size_t kLongestNamedArray = 64;
/// As in DDS. Every path of a number repeats the names above it.
constexpr std::size_t kLongestName = 255;

std::string_view trim(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

/// Cuts the next line off.
std::string_view next_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  return line;
}

}  // namespace

/// Unfolds the text into a tree.
class Definition::Parser {
 public:
  Parser(std::string_view type, std::string_view text) {
    std::string name = short_message_name(type);
    std::vector<FieldLine>* fields = &types_[name];
    while (!text.empty()) {
      const std::string_view line = trim(next_line(text));
      if (line.size() >= 3 && line.find_first_not_of('=') == std::string_view::npos) {
        const std::string_view header = trim(next_line(text));
        if (!header.starts_with("MSG:")) throw Unusable("a definition lacks a line with MSG: behind ===");
        fields = &types_[short_message_name(trim(header.substr(4)))];
        fields->clear();
      } else if (auto field = field_of(line)) {
        fields->push_back(std::move(*field));
      }
    }
    root_ = std::move(name);
  }

  Node unfold() { return message(root_, 0); }

  std::string layout;
  std::vector<std::string> paths;

 private:
  struct FieldLine {
    std::string type;
    std::string name;
  };

  /// Nothing for a comment, a constant or an empty line.
  static std::optional<FieldLine> field_of(std::string_view line) {
    line = trim(line.substr(0, line.find('#')));
    if (line.empty()) return std::nullopt;
    const std::size_t space = line.find_first_of(" \t");
    if (space == std::string_view::npos)
      throw Unusable(fmt::format("\"{}\" is not a field of a definition", line.substr(0, 60)));
    const std::string_view rest = trim(line.substr(space));
    const std::string_view name = rest.substr(0, rest.find_first_of(" \t="));
    const std::string_view behind = trim(rest.substr(name.size()));
    if (!behind.empty() && behind.front() == '=') return std::nullopt;
    if (name.size() > kLongestName)
      throw Unusable(fmt::format("\"{}…\" is too long for the name of a field", name.substr(0, 60)));
    return FieldLine{std::string(line.substr(0, space)), std::string(name)};
  }

  Node message(const std::string& name, std::size_t depth) {
    const auto found = types_.find(name);
    if (found == types_.end()) throw Unusable(fmt::format("a definition lacks the type \"{}\"", name.substr(0, 60)));
    if (depth > kDeepest) throw Unusable(fmt::format("the type \"{}\" is nested too deeply", name.substr(0, 60)));
    Node node;
    const std::string package = name.substr(0, name.find('/'));
    const std::string outer = prefix_;
    for (const FieldLine& line : found->second) {
      if (++fields_ > kMostFields) throw Unusable("a definition has too many fields");
      prefix_ = outer.empty() ? line.name : outer + "." + line.name;
      node.fields.push_back(field(line, package, depth));
      node.least_size +=
          node.fields.back().is_list ? sizeof(std::uint32_t) : node.fields.back().count * node.fields.back().least_size;
    }
    prefix_ = outer;
    // ROS gives an empty message one byte, since CDR has none.
    if (node.fields.empty()) {
      node.fields.push_back({Primitive::u1, {}, false, 1, true, 1});
      node.least_size = 1;
      layout += "u1 ";
      add_path(prefix_.empty() ? "structure_needs_at_least_one_member"
                               : prefix_ + ".structure_needs_at_least_one_member");
    }
    return node;
  }

  void add_path(std::string path) {
    if (unnamed_ > 0) return;
    if (paths.size() >= kMostFields) throw Unusable("a definition has too many fields");
    paths.push_back(std::move(path));
  }

  Node field(const FieldLine& line, const std::string& package, std::size_t depth) {
    std::string_view type = line.type;
    bool is_list = false;
    std::size_t count = 1;
    bool is_array = false;
    if (const std::size_t bracket = type.find('['); bracket != std::string_view::npos) {
      const std::string_view inside = type.substr(bracket + 1, type.find(']') - bracket - 1);
      is_list = inside.empty() || inside.front() == '<';
      is_array = !is_list;
      if (is_array) {
        const auto [end, error] = std::from_chars(inside.data(), inside.data() + inside.size(), count);
        const bool whole = error == std::errc() && end == inside.data() + inside.size();
        if (!whole || count == 0 || count > kLongestArray)
          throw Unusable(fmt::format("\"{}\" is not a type of a field", line.type.substr(0, 60)));
      }
      type = type.substr(0, bracket);
    }
    type = type.substr(0, type.find('<'));  // a text of limited length is a text
    if (is_list) layout += "[] ";
    if (is_array) layout += fmt::format("[{}] ", count);
    const std::string path = prefix_;
    const bool is_named = !is_list && count <= kLongestNamedArray;
    if (!is_named) ++unnamed_;
    Node node;
    if (const auto primitive = primitive_of(type)) {
      node.primitive = primitive;
      node.least_size = kSizes[static_cast<std::size_t>(*primitive)];
      layout += fmt::format("{} ", kNames[static_cast<std::size_t>(*primitive)]);
      if (*primitive != Primitive::text && is_named) {
        for (std::size_t i = 0; i < count; ++i) add_path(is_array ? fmt::format("{}[{}]", path, i) : path);
      }
    } else {
      const std::string name = type.find('/') != std::string_view::npos ? short_message_name(type)
                               : type == "Header"                       ? "std_msgs/Header"
                                                                        : package + "/" + std::string(type);
      // An array of messages unfolds once per element for the paths, all of one layout.
      layout += "( ";
      std::string inside;
      for (std::size_t i = 0; i < count; ++i) {
        if (is_array) prefix_ = fmt::format("{}[{}]", path, i);
        const std::size_t before = layout.size();
        node = message(name, depth + 1);
        inside = layout.substr(before);
        layout.resize(before);
        if (unnamed_ > 0) break;
      }
      layout += inside + ") ";
      prefix_ = path;
    }
    if (!is_named) --unnamed_;
    node.is_list = is_list;
    node.count = count;
    node.is_named = is_named;
    return node;
  }

  static std::optional<Primitive> primitive_of(std::string_view type) {
    static constexpr std::array<std::pair<std::string_view, Primitive>, 16> kTypes{{{"uint8", Primitive::u1},
                                                                                    {"byte", Primitive::u1},
                                                                                    {"char", Primitive::u1},
                                                                                    {"int8", Primitive::i1},
                                                                                    {"uint16", Primitive::u2},
                                                                                    {"int16", Primitive::i2},
                                                                                    {"uint32", Primitive::u4},
                                                                                    {"int32", Primitive::i4},
                                                                                    {"uint64", Primitive::u8},
                                                                                    {"int64", Primitive::i8},
                                                                                    {"float32", Primitive::f4},
                                                                                    {"float64", Primitive::f8},
                                                                                    {"bool", Primitive::boolean},
                                                                                    {"string", Primitive::text},
                                                                                    {"float", Primitive::f4},
                                                                                    {"double", Primitive::f8}}};
    const auto* const found = std::ranges::find(kTypes, type, &std::pair<std::string_view, Primitive>::first);
    return found == kTypes.end() ? std::nullopt : std::optional(found->second);
  }

  static constexpr std::array<std::size_t, 12> kSizes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8, 1, 4};
  static constexpr std::array<std::string_view, 12> kNames{"u1", "i1", "u2", "i2", "u4",   "i4",
                                                           "u8", "i8", "f4", "f8", "bool", "text"};

  std::map<std::string, std::vector<FieldLine>> types_;
  std::string root_;
  std::string prefix_;
  std::size_t fields_ = 0;
  std::size_t unnamed_ = 0;
};

Definition::Definition(std::string_view type, std::string_view text) : type_(type) {
  Parser parser(type, text);
  root_ = parser.unfold();
  layout_ = std::move(parser.layout);
  paths_ = std::move(parser.paths);
}

double Definition::number(Primitive primitive, WireReader& in) {
  switch (primitive) {
    case Primitive::u1:
    case Primitive::boolean:
      return in.value<std::uint8_t>();
    case Primitive::i1:
      return in.value<std::int8_t>();
    case Primitive::u2:
      return in.value<std::uint16_t>();
    case Primitive::i2:
      return in.value<std::int16_t>();
    case Primitive::u4:
      return in.value<std::uint32_t>();
    case Primitive::i4:
      return in.value<std::int32_t>();
    case Primitive::u8:
      return static_cast<double>(in.value<std::uint64_t>());
    case Primitive::i8:
      return static_cast<double>(in.value<std::int64_t>());
    case Primitive::f4:
      return static_cast<double>(in.value<float>());
    default:
      return in.value<double>();
  }
}

void Definition::read_one(const Node& node, WireReader& in, std::vector<double>* numbers) {
  if (!node.primitive) {
    for (const Node& field : node.fields) read(field, in, numbers);
  } else if (*node.primitive == Primitive::text) {
    in.text();
  } else {
    const double value = number(*node.primitive, in);
    if (numbers != nullptr) numbers->push_back(value);
  }
}

void Definition::read(const Node& node, WireReader& in, std::vector<double>* numbers) {
  const std::size_t count = node.is_list ? in.count(node.least_size) : node.count;
  if (!node.is_named) numbers = nullptr;
  if (count > 1 && node.primitive == Primitive::u1 && numbers == nullptr) {
    in.take(count);
    return;
  }
  for (std::size_t i = 0; i < count; ++i) read_one(node, in, numbers);
}

std::vector<double> Definition::numbers(Bytes message) const { return numbers(WireReader::cdr(message)); }

std::vector<double> Definition::numbers(WireReader in) const {
  std::vector<double> values;
  values.reserve(paths_.size());
  read_one(root_, in, &values);
  require_end(in, type_);
  return values;
}

}  // namespace waymark::ros
