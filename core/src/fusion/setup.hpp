// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "estimation/georeference.hpp"
#include "fusion/sensor_record.hpp"
#include "fusion/start_finder.hpp"
#include "monitoring/health_monitor.hpp"
#include "waymark/host/fusion_settings.hpp"

/// Checks and properties of the robot's parts, for the construction of the host.
namespace waymark::fusion {

/// Throws ConfigError if the parts do not fit together: no motion source or two kinds of it, spatial motion without a
/// sensor of roll and pitch, one instrument in two sensors, loaded maps in different frames.
void check_parts(const FusionSettings& settings, const std::vector<SensorSlot>& sensors,
                 const std::vector<MapSlot>& maps);

/// The datum: that of the YAML, else that of the loaded maps; nothing if the first fix decides.
std::optional<Datum> datum_of(const FusionSettings& settings, const std::vector<MapSlot>& maps);

/// False for a sensor that only finds the start, or is held out for scoring.
bool is_fused_after_start(const SensorSlot& slot);

/// Owners of the state blocks: the sensors in the order of the YAML, then the georeference, if there is one.
std::vector<StateLayout::Owner> block_owners(const FusionSettings& settings, const std::vector<SensorSlot>& sensors,
                                             const std::vector<MapSlot>& maps);
/// The georeference of `layout`: the owner after the `sensors`. Nothing if there is none.
std::optional<estimation::Georeference> georeference_of(const StateLayout& layout, std::size_t sensors);

/// Absolute sensors and prior maps that give or constrain the start pose.
StartSources start_sources(const std::vector<SensorSlot>& sensors, const std::vector<MapSlot>& maps);
/// The settings of the particle filter, with the history that it has to store.
ParticleFilterSettings filter_settings(const FusionSettings& settings, const std::vector<SensorSlot>& sensors,
                                       const std::vector<MapSlot>& maps);
/// The modules of the maps, in their order.
std::vector<std::shared_ptr<MapModule>> modules_of(const std::vector<MapSlot>& maps);
/// One record per sensor, in the order of the YAML, with its gates and traits.
std::vector<SensorRecord> make_records(const std::vector<SensorSlot>& sensors, const std::vector<MapSlot>& maps);
/// One role per sensor. Its name points into `sensors`, which must outlive it.
std::vector<monitoring::HealthMonitor::Role> roles_of(const std::vector<SensorRecord>& sensors,
                                                      const std::vector<MapSlot>& maps);

}  // namespace waymark::fusion
