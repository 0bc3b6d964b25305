// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "plugins/shared/dds/domain.hpp"
#include "plugins/shared/dds/raw_type.hpp"

namespace waymark::dds {

/// A handle of CycloneDDS.
using Entity = std::int32_t;

/// An entity of CycloneDDS, with all that was made of it.
class OwnedEntity {
 public:
  OwnedEntity() = default;
  explicit OwnedEntity(Entity handle) : handle_(handle) {}
  ~OwnedEntity() { reset(); }
  OwnedEntity(OwnedEntity&& other) noexcept : handle_(other.handle_) { other.handle_ = 0; }
  OwnedEntity& operator=(OwnedEntity&& other) noexcept;
  OwnedEntity(const OwnedEntity&) = delete;
  OwnedEntity& operator=(const OwnedEntity&) = delete;

  Entity handle() const { return handle_; }
  void reset();

 private:
  Entity handle_ = 0;
};

/// How samples of a topic are passed on. The words are those of ROS 2.
struct Quality {
  bool reliable = true;  ///< what was lost is sent again
  bool latched = false;  ///< transient local: who comes later gets the last `depth` samples, too
  int depth = 10;        ///< keep last
};

/// A type as one reader or writer uses it.
struct TopicEntity {
  OwnedEntity entity;
  const ddsi_sertype* type = nullptr;
};

/// What a plugin is in a domain. All plugins of a process in one domain share its configuration.
class Participant {
 public:
  /// Throws Error if the interface does not exist, or if this process uses the domain through another one.
  explicit Participant(DomainSettings settings, std::size_t most_bytes = kMostBytes);
  /// Everything that was made of it must be gone. The domain ends with the last participant of the process.
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  Entity handle() const { return entity_.handle(); }
  const DomainSettings& settings() const { return settings_; }

  /// Throws Error. `topic`, `type`: as ROS has them.
  TopicEntity make_topic(const std::string& topic, const std::string& type, std::shared_ptr<Losses> losses) const;
  /// Types (of ROS) with which others publish or read a topic, as far as they have been found.
  std::vector<std::string> types_on(const std::string& topic, bool of_writers) const;

 private:
  DomainSettings settings_;
  std::shared_ptr<Reception> reception_;
  OwnedEntity entity_;
  OwnedEntity publications_, subscriptions_;  // what was found
};

/// Joins, with the settings that were read of `config`. Throws ConfigError at `interface`.
std::unique_ptr<Participant> join_domain(const Config& config, const DomainSettings& settings,
                                         std::size_t most_bytes = kMostBytes);

/// "bad parameter" of a negative return value.
std::string text_of_failure(std::int32_t code);

}  // namespace waymark::dds
