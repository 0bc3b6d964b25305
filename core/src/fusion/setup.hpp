// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "estimation/georeference.hpp"
#include "fusion/sensor_record.hpp"
#include "fusion/start_finder.hpp"
#include "monitoring/health_monitor.hpp"
#include "waymark/host/fusion_settings.hpp"

/// How the parts of a robot fit together, settled once when the host is made.
namespace waymark::fusion {

/// Throws ConfigError if the parts do not fit together.
void check_parts(const FusionSettings& settings, const std::vector<SensorSlot>& sensors,
                 const std::vector<MapSlot>& maps);

/// False for a sensor that is only there to find the start, or to be scored against.
bool is_fused_after_start(const SensorSlot& slot);

/// Who appends states: the sensors in the order of the YAML; then the georeference, if there is one.
std::vector<StateLayout::Owner> block_owners(const FusionSettings& settings, const std::vector<SensorSlot>& sensors,
                                             const std::vector<MapSlot>& maps);
/// The georeference among the owners of `layout`: the one after the `sensors`.
std::optional<estimation::Georeference> georeference_of(const StateLayout& layout, std::size_t sensors);

StartKnowledge start_knowledge(const std::vector<SensorSlot>& sensors, const std::vector<MapSlot>& maps);
ParticleFilterSettings filter_settings(const FusionSettings& settings, const std::vector<MapSlot>& maps);
std::vector<std::shared_ptr<MapModule>> modules_of(const std::vector<MapSlot>& maps);
std::vector<SensorRecord> make_records(const std::vector<SensorSlot>& sensors, const std::vector<MapSlot>& maps);
std::vector<monitoring::HealthMonitor::Role> roles_of(const std::vector<SensorRecord>& sensors,
                                                      const std::vector<MapSlot>& maps);

}  // namespace waymark::fusion
