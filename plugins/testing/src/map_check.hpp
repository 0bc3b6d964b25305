// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "findings.hpp"
#include "waymark/interface/particle_map.hpp"

namespace waymark::testing {

/// All numbers of a refinement, exactly; the association is the map's business.
std::string numbers_of(const Refinement& refinement);

/// All that a map shows, exactly.
std::string description_of(const ParticleMap& map);

/// Finite values, information symmetric and positive semi-definite.
void check_refinement(const Refinement& refinement, std::string_view where, Findings& findings);

/// Finite values, covariances positive semi-definite, ids that occur once.
void check_description(const ParticleMap& map, Findings& findings);

}  // namespace waymark::testing
