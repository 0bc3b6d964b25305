// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "waymark/base/time.hpp"

namespace waymark::run_views {

/// "9.6 s", "2 min 50 s", "1 h 05 min".
std::string duration_text(double seconds);

/// "2011-09-26 13:02 UTC"; empty if the stamp does not count from 1970 (it lies before 1990).
std::string date_text(Time stamp);

/// A standard deviation with two digits that count: "0.0042", "0.11", "12".
std::string sigma_text(double sigma);

/// A value with as many decimals as its standard deviation has: "12.340 ± 0.0042".
std::string value_text(double value, double sigma);

}  // namespace waymark::run_views
