// SPDX-License-Identifier: Apache-2.0
// What a run left in its folder.
#pragma once

#include <map>
#include <set>
#include <string>

#include "tests/report_document.hpp"
#include "tests/system/command.hpp"

namespace waymark::system_test {

/// What a report shows, without the name and the text of the configuration: an equal run may have another one.
inline std::string report_data(const std::string& page) {
  nlohmann::json data = test::report_document(page);
  data.erase("name");
  data.erase("config");
  return data.dump();
}

/// The content of every file of a folder by name, without those in `left_out`; of a report what it shows. The list of
/// what the run wrote has the report's size, so it is left out.
inline std::map<std::string, std::string> contents(const std::filesystem::path& folder,
                                                   const std::set<std::string>& left_out = {}) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (left_out.contains(name) || name == ".waymark_files") continue;
    files[name] = name == "report.html" ? report_data(read_text(entry.path())) : read_text(entry.path());
  }
  return files;
}

/// Passes if both folders hold the same files, byte for byte. Files are long, so only the first difference is reported.
inline testing::AssertionResult same_bytes(const std::map<std::string, std::string>& left,
                                           const std::map<std::string, std::string>& right) {
  for (const auto& [name, text] : left) {
    const auto other = right.find(name);
    if (other == right.end()) return testing::AssertionFailure() << name << " is missing in the second";
    if (other->second == text) continue;
    const auto differ = std::mismatch(text.begin(), text.end(), other->second.begin(), other->second.end());
    const auto at = differ.first - text.begin();
    const auto from = static_cast<std::size_t>(at < 60 ? 0 : at - 60);
    return testing::AssertionFailure() << name << " differs from byte " << at << " on:\n"
                                       << text.substr(from, 120) << "\nversus\n"
                                       << other->second.substr(from, 120);
  }
  for (const auto& [name, text] : right) {
    if (!left.contains(name)) return testing::AssertionFailure() << name << " is missing in the first";
  }
  return testing::AssertionSuccess();
}

/// The folder of the recordings, empty if WAYMARK_DATA is not set.
inline std::string data_folder() {
  const char* folder = std::getenv("WAYMARK_DATA");
  return folder == nullptr ? "" : folder;
}

}  // namespace waymark::system_test
