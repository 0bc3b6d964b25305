// SPDX-License-Identifier: Apache-2.0
#include "waymark/config/key_reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <exception>
#include <set>

#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using Asked = Config::Asked;
using Type = Asked::Type;

/// Keys and values, a mapping before what is in it.
using Values = std::vector<std::pair<std::string, std::string>>;

/// One configuration to try.
struct Trial {
  Values revealing;  ///< what made it worth trying
  Values required;   ///< without which that would not be read
};

bool contains(const Values& values, const std::string& path) {
  return std::ranges::any_of(values, [&path](const auto& value) { return value.first == path; });
}

void set(Values& values, const std::string& path, const std::string& value) {
  std::erase_if(values, [&path](const auto& known) { return known.first == path; });
  values.emplace_back(path, value);
}

/// "files[].scan.step_deg" as an override's key: "files.0.scan.step_deg".
std::string as_override_key(std::string path) {
  for (std::size_t at = path.find("[]"); at != std::string::npos; at = path.find("[]")) path.replace(at, 2, ".0");
  return path;
}

std::string legal_number(const Asked& asked) {
  double value = std::clamp(1.0, asked.low, asked.high);
  if (asked.type == Type::integer) value = std::ceil(value);
  return fmt::format("{}", value);
}

std::string legal_numbers(int count) {
  std::string list;
  constexpr int kFitsMost = 12;  // pairs, triples, …
  for (int i = 1; i <= (count < 0 ? kFitsMost : count); ++i) list += fmt::format("{}{}", i == 1 ? "" : ", ", i);
  return fmt::format("[{}]", list);
}

/// The values to try a key with; the first is the one for a required key.
std::vector<std::string> legal_values(const Asked& asked, const KeyTrials& trials) {
  switch (asked.type) {
    case Type::none:
      return {"1"};
    case Type::number:
    case Type::integer:
      return {legal_number(asked)};
    case Type::boolean:
      return {"false", "true"};
    case Type::text:
      if (asked.is_required) return trials.texts;
      return {trials.texts.front()};
    case Type::choice:
      return asked.words;
    case Type::numbers:
      return {legal_numbers(asked.count)};
    case Type::texts: {
      std::vector<std::string> lists;
      for (const std::string& text : trials.texts) lists.push_back(fmt::format("[\"{}\"]", text));
      return lists;
    }
    case Type::mapping:
      return {"{}"};
    case Type::items:
      return {"[{}]"};
  }
  return {};
}

class Explorer {
 public:
  Explorer(const std::function<void(const Config&)>& read, const KeyTrials& trials) : read_(read), trials_(trials) {}

  std::vector<DescribedKey> explore() {
    pending_.emplace_back();
    for (int i = 0; i < trials_.most && !pending_.empty(); ++i) {
      const Trial trial = std::move(pending_.front());
      pending_.pop_front();
      carry_out(trial);
    }
    if (!pending_.empty())
      throw Error(fmt::format("the keys are not all found after {} configurations that were tried", trials_.most));
    return std::move(found_);
  }

 private:
  static constexpr int kMostRequired = 50;

  /// Runs the reader, and again with every required key that was missing.
  void carry_out(Trial trial) {
    for (int i = 0; i < kMostRequired; ++i) {
      const std::vector<Asked> asked = run(trial);
      for (const Asked& key : asked) note(key, trial);
      const auto missing = std::ranges::find_if(asked, [&](const Asked& key) {
        return key.is_required && key.type != Type::none && !contains(trial.required, key.path) &&
               !contains(trial.revealing, key.path) && !is_given(key.path);
      });
      if (missing == asked.end()) {
        for (const Asked& key : asked) plan(key, trial);
        return;
      }
      trial.required.emplace_back(missing->path, legal_values(*missing, trials_).front());
    }
  }

  bool is_given(const std::string& path) const {
    return std::ranges::any_of(trials_.given, [key = as_override_key(path) + '='](const std::string& given) {
      return given.starts_with(key);
    });
  }

  std::vector<Asked> run(const Trial& trial) const {
    Values values = trial.required;
    for (const auto& [path, value] : trial.revealing) set(values, path, value);
    std::ranges::stable_sort(values, {}, [](const auto& value) { return std::ranges::count(value.first, '.'); });
    std::vector<Config::Override> overrides = trials_.given;
    for (const auto& [path, value] : values) overrides.push_back(as_override_key(path) + '=' + value);
    try {
      const Config config = Config::parse("{}", trials_.file, overrides);
      try {
        read_(config);
      } catch (const std::exception&) {  // what was asked before counts
      }
      return config.asked();
    } catch (const std::exception&) {  // the values do not fit together
      return {};
    }
  }

  void note(const Asked& asked, const Trial& trial) {
    DescribedKey* known = find_key(found_, asked.path);
    if (known == nullptr) {
      known = &found_.emplace_back(DescribedKey{asked, {}});
      for (const auto& [path, value] : trial.revealing) known->given.push_back(fmt::format("{}={}", path, value));
    } else {
      if (asked.type != Type::none) drop_conditions(*known, trial);
      const bool is_better =
          known->asked.type == Type::none || (known->asked.meaning.empty() && !asked.meaning.empty());
      if (!is_better) return;
      known->asked = asked;  // it was only looked for, or its declaration stands elsewhere
    }
    // What is read only where it is given may be left out.
    if (contains(trial.revealing, asked.path)) known->asked.is_required = false;
  }

  /// Those of keys without which the trial read this one as well. Another value of the same key refutes nothing: what
  /// two of three choices read still depends on the choice.
  static void drop_conditions(DescribedKey& key, const Trial& trial) {
    std::erase_if(key.given, [&trial](const std::string& given) {
      const std::string path = given.substr(0, given.find('='));
      return !contains(trial.revealing, path) && !contains(trial.required, path);
    });
  }

  /// What the reader must decide by, such as the kind of a payload: the same key is worth trying again with another.
  std::string context(const Trial& trial) const {
    if (trial.revealing.empty()) return {};
    const auto& [path, value] = trial.revealing.front();
    const DescribedKey* key = find_key(found_, path);
    const bool decides =
        key != nullptr && key->asked.is_required && (key->asked.type == Type::choice || key->asked.type == Type::text);
    return decides ? path + '=' + value : "";
  }

  void plan(const Asked& asked, const Trial& trial) {
    if (contains(trial.revealing, asked.path) && asked.type == Type::none) return;
    // A number decides what else is read by being there at all, whatever the context.
    const bool is_numeric = asked.type == Type::number || asked.type == Type::integer || asked.type == Type::numbers;
    const std::string where = is_numeric ? "" : context(trial);
    for (const std::string& value : legal_values(asked, trials_)) {
      if (value == asked.fallback || !planned_.insert({where, asked.path, value}).second) continue;
      Trial next = trial;
      set(next.revealing, asked.path, value);
      pending_.push_back(std::move(next));
    }
  }

  const std::function<void(const Config&)>& read_;
  const KeyTrials& trials_;
  std::deque<Trial> pending_;
  std::set<std::array<std::string, 3>> planned_;
  std::vector<DescribedKey> found_;
};

}  // namespace

std::vector<DescribedKey> describe_keys(const std::function<void(const Config&)>& read, const KeyTrials& trials) {
  return Explorer(read, trials).explore();
}

}  // namespace waymark
