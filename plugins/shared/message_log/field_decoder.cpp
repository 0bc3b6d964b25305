// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/message_log/field_decoder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "plugins/shared/cdr/definition.hpp"
#include "waymark/config/nearest_name.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::message_log {
namespace {

/// Where a number of the payload comes from.
struct NumberSource {
  std::string field;  // of the payload
  bool is_constant = false;
  double factor = 1.0;    // of a number of the message; or the constant
  std::size_t index = 0;  // in the paths of the definition
};

/// The fields of a payload that consist of numbers.
class NumberFields final : public FieldEditor {
 public:
  struct One {
    std::string name;
    bool is_required;
  };
  void field(const FieldInfo& info, const FieldSlot& slot) override {
    if (const auto* numbers = std::get_if<std::span<double>>(&slot)) {
      for (std::size_t i = 0; i < numbers->size(); ++i)
        fields.push_back({std::string(info.names.at(i)), info.required});
    } else if (std::holds_alternative<int*>(slot) || std::holds_alternative<bool*>(slot)) {
      fields.push_back({std::string(info.name()), info.required});
    } else if (info.required && !std::holds_alternative<WordSlot>(slot)) {
      lists += fmt::format("{}{}", lists.empty() ? "" : ", ", info.name());
    }
  }
  std::size_t list(const FieldInfo& info) override {
    lists += fmt::format("{}{}", lists.empty() ? "" : ", ", info.name());
    return 0;
  }

  std::vector<One> fields;
  std::string lists;  // that are required
};

/// Sets the numbers of a payload.
class NumberSetter final : public FieldEditor {
 public:
  NumberSetter(const std::vector<NumberSource>& sources, const std::vector<double>& message)
      : sources_(&sources), message_(&message) {}
  void field(const FieldInfo& info, const FieldSlot& slot) override {
    if (const auto* numbers = std::get_if<std::span<double>>(&slot)) {
      for (std::size_t i = 0; i < numbers->size(); ++i) {
        if (const auto value = number(info.names.at(i))) (*numbers)[i] = *value;
      }
    } else if (int* const* whole = std::get_if<int*>(&slot)) {
      if (const auto value = number(info.name())) **whole = whole_number(*value, info.name());
    } else if (bool* const* truth = std::get_if<bool*>(&slot)) {
      if (const auto value = number(info.name())) **truth = *value != 0.0;
    }
  }
  std::size_t list(const FieldInfo&) override { return 0; }

 private:
  std::optional<double> number(std::string_view name) const {
    const auto source = std::ranges::find(*sources_, name, &NumberSource::field);
    if (source == sources_->end()) return std::nullopt;
    return source->is_constant ? source->factor : source->factor * message_->at(source->index);
  }
  static int whole_number(double value, std::string_view name) {
    if (!(std::abs(value) < 2147483648.0))
      throw ros::Unusable(fmt::format("{} is {}, a whole number of 32 bits is expected", name, value));
    return static_cast<int>(value);
  }

  const std::vector<NumberSource>* sources_;
  const std::vector<double>* message_;
};

NumberSource read_source(const std::string& field, const std::string& text, const std::vector<std::string>& paths,
                         const Config& fields) {
  NumberSource source;
  source.field = field;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), source.factor);
  if (error == std::errc() && end == text.data() + text.size()) {
    source.is_constant = true;
    return source;
  }
  const bool negative = text.starts_with('-');
  const std::string path = text.substr(negative ? 1 : 0);
  source.factor = negative ? -1.0 : 1.0;
  const auto found = std::ranges::find(paths, path);
  if (found == paths.end()) {
    const std::string nearest = nearest_name(path, paths);
    fields.fail(field, fmt::format("the message has no number \"{}\"{}; there are: {}", path,
                                   nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest),
                                   fmt::join(paths, ", ")));
  }
  source.index = static_cast<std::size_t>(found - paths.begin());
  return source;
}

/// A recorded definition may give the numbers of a stamp any type.
std::optional<Time> stamp_of(double seconds, double nanoseconds) {
  constexpr double kLastSecond = 4294967296.0;  // of 32 bits, which count as unsigned
  constexpr double kSecond = 1e9;
  if (!(seconds >= -2147483648.0 && seconds < kLastSecond && nanoseconds >= 0.0 && nanoseconds < kSecond))
    throw ros::Unusable(fmt::format("its stamp of {} s and {} ns is not a time", seconds, nanoseconds));
  return ros::to_time(
      {static_cast<std::int32_t>(static_cast<std::int64_t>(seconds)), static_cast<std::uint32_t>(nanoseconds)});
}

std::optional<std::size_t> index_of(const std::vector<std::string>& paths, std::string_view path) {
  const auto found = std::ranges::find(paths, path);
  return found == paths.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - paths.begin()));
}

std::vector<NumberSource> read_sources(std::string_view payload_type, const std::vector<std::string>& paths,
                                       const Config& entry) {
  const auto payload = make_payload(payload_type);
  NumberFields known;
  payload->edit(known);
  const Config fields = entry.child("fields");
  if (!known.lists.empty()) {
    entry.fail("fields",
               fmt::format("{} cannot be made of numbers: it needs {}", short_type_name(payload_type), known.lists));
  }
  std::vector<NumberSource> sources;
  std::vector<std::string> names;
  for (const auto& one : known.fields) names.push_back(one.name);
  for (const std::string& field : fields.keys()) {
    if (std::ranges::find(names, field) == names.end()) {
      const std::string nearest = nearest_name(field, names);
      fields.fail(field, fmt::format("{} has no number \"{}\"{}; there are: {}", short_type_name(payload_type), field,
                                     nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest),
                                     fmt::join(names, ", ")));
    }
    sources.push_back(read_source(field, fields.text(field), paths, fields));
  }
  for (const auto& one : known.fields) {
    if (one.is_required && std::ranges::find(sources, one.name, &NumberSource::field) == sources.end())
      entry.fail("fields", fmt::format("{} is missing, which {} needs", one.name, short_type_name(payload_type)));
  }
  return sources;
}

}  // namespace

ros::Decoder make_field_decoder(std::string_view type, const std::string& definition, std::string_view payload_type,
                                const Config& entry) {
  std::shared_ptr<const ros::Definition> known;
  try {
    known = std::make_shared<const ros::Definition>(type, definition);
  } catch (const ros::Unusable& unusable) {
    entry.fail("fields", fmt::format("the recorded definition of {} cannot be used: {}", type, unusable.what()));
  }
  const std::vector<std::string>& paths = known->number_paths();
  const auto seconds = index_of(paths, "header.stamp.sec");
  const auto nanoseconds = index_of(paths, "header.stamp.nanosec");
  return [known, seconds, nanoseconds, sources = read_sources(payload_type, paths, entry),
          name = std::string(payload_type)](ros::WireReader in) {
    const std::vector<double> message = known->numbers(in);
    ros::Decoded decoded;
    if (seconds && nanoseconds) decoded.stamp = stamp_of(message.at(*seconds), message.at(*nanoseconds));
    const auto payload = make_payload(name);
    NumberSetter setter(sources, message);
    payload->edit(setter);
    decoded.payload = payload;
    return decoded;
  };
}

}  // namespace waymark::message_log
