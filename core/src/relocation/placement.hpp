// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waymark::relocation {

/// What the robot sees, against the loaded map where the robot is believed to be.
enum class Placement {
  fits,       ///< or there is no such map
  doubtful,   ///< it fits worse than usual
  misplaced,  ///< it does not fit
  ambiguous,  ///< nor does it single out another place
};

}  // namespace waymark::relocation
