// SPDX-License-Identifier: Apache-2.0
// Reports of gpsd, one a line.
#include <optional>
#include <string>

#include "plugins/sources/gpsd/epoch_reports.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "waymark/base/time.hpp"

namespace waymark::fuzz::gpsd_harness {
namespace {

void check(const std::optional<gpsd::TimedFix>& fix) {
  if (!fix) return;
  if (!is_stamp(fix->stamp)) violation("the time of a fix is not a stamp");
  const std::string problem = fix->fix->problem();
  if (!problem.empty()) violation("a fix has bad values: " + problem);
}

void run(std::string_view input) {
  gpsd::EpochReports reports;
  while (!input.empty()) {
    const std::size_t end = std::min(input.find('\n'), input.size());
    check(reports.take(std::string(input.substr(0, end))));
    input.remove_prefix(std::min(end + 1, input.size()));
  }
  if (reports.is_waiting()) check(reports.finish());
}

const Harness kHarness("gpsd", run);

}  // namespace
}  // namespace waymark::fuzz::gpsd_harness
