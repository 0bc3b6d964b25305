// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/cdr/payload_cdr.hpp"

#include <fmt/format.h>

#include <array>
#include <limits>
#include <optional>
#include <utility>

#include "plugins/shared/cdr/definition_text.hpp"
#include "plugins/shared/cdr/message.hpp"
#include "plugins/shared/cdr/ros/geometry_msgs.hpp"
#include "waymark/base/overloaded.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::ros {
namespace {

/// Type of the elements of a payload's list: "LandmarkObservationsLandmarks".
std::string element_type(std::string_view message, std::string_view list) {
  std::string name(message);
  bool upper = true;
  for (const char c : list) {
    if (c == '_') {
      upper = true;
    } else {
      name += upper && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
      upper = false;
    }
  }
  return name;
}

/// Collects the lines of a definition, whichever way the fields are passed.
class DefinitionLines {
 public:
  explicit DefinitionLines(std::string message) : message_(std::move(message)) { parts_.emplace_back(message_, ""); }

  void numbers(const FieldInfo& info, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) line("float64", info.names.at(i), i == 0 ? &info : nullptr);
  }
  void one(std::string_view type, const FieldInfo& info) { line(type, info.name(), &info); }
  void points(const FieldInfo& info) {
    one("geometry_msgs/Point32[]", info);
    uses_points_ = true;
  }
  void begin_list(const FieldInfo& info, std::size_t size) {
    if (part_ != 0) throw Unusable("a list within a list of a payload has no definition");
    if (size < 2) throw Unusable(fmt::format("the fields of the elements of \"{}\" are not known", info.name()));
    std::string type = element_type(message_, info.name());
    one(type + "[]", info);
    parts_.emplace_back(std::move(type), "");
    part_ = parts_.size() - 1;
    elements_ = size;
    fields_of_element_ = 0;
  }
  /// The fields of the first element are counted, so that the end of the last one is known.
  void element(std::size_t index) {
    element_ = index;
    fields_left_ = fields_of_element_;
  }

  std::string text() {
    if (uses_points_) detail::add_definition<geometry_msgs::Point32>(parts_);
    return join_definition(parts_);
  }

 private:
  /// `info` is null for the further names of a vector.
  void line(std::string_view type, std::string_view name, const FieldInfo* info) {
    if (part_ != 0 && element_ == 0) {
      ++fields_of_element_;
    } else if (part_ != 0) {
      if (--fields_left_ == 0 && element_ + 1 == elements_) part_ = 0;
      return;
    }
    std::string& lines = parts_[part_].second;
    lines += fmt::format("{} {}", type, name);
    if (info != nullptr) {
      lines += fmt::format("  # {}{}{}", info->meaning, info->unit.empty() ? "" : ", ", info->unit);
      if (!info->unknown.empty()) lines += fmt::format("; unknown: {}", info->unknown);
      for (std::size_t i = 0; i < info->words.size(); ++i)
        lines += fmt::format("{}{} {}", i == 0 ? "; " : ", ", i, info->words[i]);
    }
    lines += '\n';
  }

  std::string message_;
  DefinitionParts parts_;
  std::size_t part_ = 0;
  std::size_t elements_ = 0;
  std::size_t element_ = 0;
  std::size_t fields_of_element_ = 0;
  std::size_t fields_left_ = 0;
  bool uses_points_ = false;
};

class DefiningVisitor final : public FieldVisitor {
 public:
  explicit DefiningVisitor(DefinitionLines& lines) : lines_(&lines) {}
  void field(const FieldInfo& info, const FieldValue& value) override {
    std::visit(Overloaded{[&](std::span<const double> numbers) { lines_->numbers(info, numbers.size()); },
                          [&](std::int64_t) { lines_->one("int32", info); }, [&](bool) { lines_->one("bool", info); },
                          [&](FieldWord) { lines_->one("int32", info); },
                          [&](std::span<const float>) { lines_->one("float32[]", info); },
                          [&](std::span<const Eigen::Vector3f>) { lines_->points(info); },
                          [&](std::span<const std::uint8_t>) { lines_->one("uint8[]", info); }},
               value);
  }
  void list(const FieldInfo& info, std::size_t size) override { lines_->begin_list(info, size); }
  void element(std::size_t index) override { lines_->element(index); }

 private:
  DefinitionLines* lines_;
};

/// Gives every list two elements, whose fields `DefiningVisitor` then gets to see.
class TwoElementsEach final : public FieldEditor {
 public:
  void field(const FieldInfo&, const FieldSlot&) override {}
  std::size_t list(const FieldInfo&) override { return 2; }
};

class PayloadEncoder final : public FieldVisitor {
 public:
  void field(const FieldInfo&, const FieldValue& value) override {
    std::visit(Overloaded{[&](std::span<const double> numbers) { out_.values(numbers); },
                          [&](std::int64_t number) { out_.value(static_cast<std::int32_t>(number)); },
                          [&](bool truth) { write(out_, truth); },
                          [&](FieldWord word) { out_.value(static_cast<std::int32_t>(word.number)); },
                          [&](std::span<const float> numbers) { list_of(numbers); },
                          [&](std::span<const Eigen::Vector3f> points) { list_of_points(points); },
                          [&](std::span<const std::uint8_t> bytes) { list_of(bytes); }},
               value);
  }
  void list(const FieldInfo&, std::size_t size) override { out_.count(size); }
  std::vector<std::uint8_t> take() { return out_.take(); }

 private:
  template <class T>
  void list_of(std::span<const T> values) {
    out_.count(values.size());
    out_.values(values);
  }
  void list_of_points(std::span<const Eigen::Vector3f> points) {
    static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
    out_.count(points.size());
    if (!points.empty()) out_.values(std::span<const float>(points.front().data(), 3 * points.size()));
  }

  WireWriter out_;
};

class PayloadDecoder final : public FieldEditor {
 public:
  explicit PayloadDecoder(WireReader in) : in_(in) {}
  void field(const FieldInfo& info, const FieldSlot& slot) override {
    std::visit(Overloaded{[&](std::span<double> numbers) { in_.values(numbers); },
                          [&](int* number) { *number = in_.value<std::int32_t>(); },
                          [&](bool* truth) { read(in_, *truth); }, [&](const WordSlot& word) { set_word(info, word); },
                          [&](std::vector<float>* numbers) { read(in_, *numbers); },
                          [&](std::vector<Eigen::Vector3f>* points) { read_points(*points); },
                          [&](std::vector<std::uint8_t>* bytes) { read(in_, *bytes); }},
               slot);
  }
  std::size_t list(const FieldInfo&) override {
    // An element has at least one number; its struct is not much larger than its bytes.
    return in_.count(sizeof(double));
  }
  const WireReader& in() const { return in_; }

 private:
  void set_word(const FieldInfo& info, const WordSlot& word) {
    const auto number = in_.value<std::int32_t>();
    if (number < 0 || static_cast<std::size_t>(number) >= info.words.size())
      throw Unusable(fmt::format("{} is not a value of \"{}\"", number, info.name()));
    word.assign(word.value, number);
  }
  void read_points(std::vector<Eigen::Vector3f>& points) {
    points.resize(in_.count(3 * sizeof(float)));
    if (!points.empty()) in_.values(std::span<float>(points.front().data(), 3 * points.size()));
  }

  WireReader in_;
};

std::shared_ptr<Payload> core_payload(std::string_view type) {
  auto payload = make_payload(type);
  if (!payload) throw Unusable(fmt::format("there is no payload \"{}\" in core", type.substr(0, 80)));
  return payload;
}

}  // namespace

std::string payload_message_type(std::string_view payload_type) {
  const std::string_view vendor = payload_type.substr(0, payload_type.find('/'));
  return fmt::format("{}_msgs/msg/{}", vendor, short_type_name(payload_type));
}

std::string payload_definition(const Payload& payload) {
  const auto of_core = make_payload(payload.type());
  if (of_core) {
    TwoElementsEach editor;
    of_core->edit(editor);
  }
  DefinitionLines lines(short_message_name(payload_message_type(payload.type())));
  DefiningVisitor visitor(lines);
  if (!(of_core ? *of_core : payload).visit(visitor))
    throw Unusable(fmt::format("the payload {} registers no fields", payload.type()));
  return lines.text();
}

std::string payload_definition(std::string_view payload_type) {
  return payload_definition(*core_payload(payload_type));
}

std::vector<std::uint8_t> payload_to_cdr(const Payload& payload) {
  PayloadEncoder encoder;
  if (!payload.visit(encoder)) throw Unusable(fmt::format("the payload {} registers no fields", payload.type()));
  return encoder.take();
}

std::shared_ptr<Payload> payload_from_cdr(std::string_view payload_type, Bytes bytes) {
  return payload_from_cdr(payload_type, WireReader::cdr(bytes));
}

std::shared_ptr<Payload> payload_from_cdr(std::string_view payload_type, WireReader in) {
  std::shared_ptr<Payload> payload = core_payload(payload_type);
  PayloadDecoder decoder(in);
  payload->edit(decoder);
  require_end(decoder.in(), payload_type);
  return payload;
}

}  // namespace waymark::ros
