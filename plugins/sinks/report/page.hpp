// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

namespace waymark::report {

/// The page around the data, from the files of page/ and uPlot (page.cmake).
struct Page {
  std::span<const std::string_view> before_data;
  std::span<const std::string_view> after_data;
};

Page page();

}  // namespace waymark::report
