// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace waymark::test {

/// The JSON document within the page of a report.
inline nlohmann::json report_document(const std::string& page) {
  constexpr std::string_view kMark = "<script id=\"data\" type=\"application/json\">";
  const std::size_t from = page.find(kMark) + kMark.size();
  return nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from));
}

}  // namespace waymark::test
