// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <string_view>

#include "waymark/base/error.hpp"
#include "waymark/interface/measurement.hpp"
#include "waymark/io/archive.hpp"
#include "waymark/testing/violations.hpp"

namespace waymark::testing {

/// Collects violations; of each rule only the first one, with where it happened.
class Findings {
 public:
  /// Notes that `rule` does not hold, with the details of this case.
  void add(std::string_view rule, std::string_view detail = {}) {
    if (!rules_.emplace(rule).second) return;
    violations_.push_back(detail.empty() ? std::string(rule) : std::string(rule) + ": " + std::string(detail));
  }
  void require(bool holds, std::string_view rule, std::string_view detail = {}) {
    if (!holds) add(rule, detail);
  }

  /// Runs a part of a check; an exception out of it is a violation and ends that part only.
  template <class Part>
  void part(std::string_view name, const Part& run) {
    try {
      run();
    } catch (const std::exception& error) {
      add(std::string(name) + " threw", error.what());
    } catch (...) {
      add(std::string(name) + " threw", "something that is not a std::exception");
    }
  }

  Violations take() { return std::move(violations_); }

 private:
  std::set<std::string, std::less<>> rules_;
  Violations violations_;
};

/// The bytes that `object.save` writes.
template <class T>
std::string saved(const T& object) {
  std::ostringstream stream;
  OutArchive archive(stream);
  object.save(archive);
  return std::move(stream).str();
}

/// Gives `bytes` to `load(InArchive&)`; returns what of them was not read.
template <class Load>
std::size_t load_from(const std::string& bytes, const Load& load) {
  std::istringstream stream(bytes);
  InArchive archive(stream);
  load(archive);
  return bytes.size() - static_cast<std::size_t>(stream.tellg());
}

/// True if `load(InArchive&)` refuses every one of some beginnings of `bytes` with an Error.
template <class Load>
bool refuses_truncated(const std::string& bytes, const Load& load) {
  if (bytes.empty()) return true;
  for (const std::size_t missing : {std::size_t{1}, (bytes.size() + 1) / 2, bytes.size()}) {
    try {
      load_from(bytes.substr(0, bytes.size() - missing), load);
      return false;
    } catch (const Error&) {
      continue;
    } catch (...) {
      return false;
    }
  }
  return true;
}

/// A payload that no plugin takes.
struct ForeignPayload : PayloadOf<ForeignPayload> {
  static constexpr std::string_view kType = "waymark_testing/Foreign@1";
};

/// True if `use(measurement)` throws DataError for a payload that it cannot know.
template <class Use>
bool refuses_foreign_payload(Measurement measurement, const Use& use) {
  measurement.payload = std::make_shared<ForeignPayload>();
  try {
    use(measurement);
  } catch (const DataError&) {
    return true;
  } catch (...) {
    return false;
  }
  return false;
}

}  // namespace waymark::testing
