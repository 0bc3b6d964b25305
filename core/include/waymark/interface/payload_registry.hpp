// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/interface/measurement.hpp"
#include "waymark/interface/payload_description.hpp"

/// The payloads that this program can make by their names (`make_payload`): those of core, and those that a plugin
/// registers. Sources that read any payload, checkpoints and reference pages find them here.
namespace waymark {

/// A payload that can be made by its name.
struct KnownPayload {
  std::string_view type;                        ///< versioned name, "example/BeaconRange@1"
  std::shared_ptr<Payload> (*make)();           ///< one with its defaults
  std::vector<FieldDescription> (*describe)();  ///< its fields, in the order in which they are registered
};

/// Makes a plugin's payload known; `WAYMARK_PLUGIN` does so for those that it lists. What a plugin has registered stays
/// for the life of the program. The same payload again, by another plugin, changes nothing. Throws Error if the type is
/// none of the form "vendor/Name@1", if it is one of core's, or if it is registered with other fields.
WAYMARK_API void register_payload(const KnownPayload& payload);

/// The same for payload T, which derives from PayloadOf<T> and registers its fields.
template <HasFields T>
void register_payload() {
  register_payload({T::kType, []() -> std::shared_ptr<Payload> { return std::make_shared<T>(); }, &describe_fields<T>});
}

/// All payloads: those of core in their order, then the registered ones by their names.
WAYMARK_API std::vector<KnownPayload> known_payloads();

/// True for a payload of core.
WAYMARK_API bool is_of_core(std::string_view payload_type);

/// The type that a name in the YAML means: "example/BeaconRange@1" or "BeaconRange". A short name that core uses is
/// core's; of several registered ones it is the first. Empty if there is none.
WAYMARK_API std::string_view find_payload_type(std::string_view name);

}  // namespace waymark
