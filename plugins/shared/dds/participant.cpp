// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/dds/participant.hpp"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <string_view>
#include <utility>

#include "plugins/shared/dds/names.hpp"
#include "waymark/base/error.hpp"

namespace waymark::dds {
namespace {

/// The line in which CycloneDDS explains a failure of a call; it would print it.
class Explanation {
 public:
  Explanation() {
    current = this;
    dds_set_log_sink(keep, nullptr);
  }
  ~Explanation() { current = nullptr; }
  Explanation(const Explanation&) = delete;
  Explanation& operator=(const Explanation&) = delete;

  /// ": lo: not found", or nothing.
  std::string text() const { return text_.empty() ? "" : ": " + text_; }

 private:
  /// Of other threads nothing is kept: what they report shows in the counts of readers and writers.
  static void keep(void*, const dds_log_data_t* line) {
    if (current == nullptr || line->message == nullptr || !current->text_.empty()) return;
    std::string_view text(line->message, std::min<std::size_t>(line->size, 300));
    if (line->hdrsize < text.size()) text.remove_prefix(line->hdrsize);
    current->text_ = text.substr(0, text.find('\n'));
  }

  static thread_local Explanation* current;
  std::string text_;
};
thread_local Explanation* Explanation::current = nullptr;

/// Of the participants of this process, so that a domain is made, and ended, once. Every plugin has its own copy, but
/// a host makes and destroys them in one thread.
std::mutex domain_mutex;

constexpr std::string_view kInterfaceProperty = "waymark.interface";

/// The interface through which this process is in a domain; empty: it is not, or through another library.
std::string interface_in_use(dds_domainid_t domain) {
  std::array<dds_entity_t, 32> participants{};
  const auto count = dds_lookup_participant(domain, participants.data(), participants.size());
  for (int i = 0; i < std::min<int>(count, participants.size()); ++i) {
    dds_qos_t* const qos = dds_create_qos();
    char* value = nullptr;
    std::string name;
    if (dds_get_qos(participants[static_cast<std::size_t>(i)], qos) == DDS_RETCODE_OK &&
        dds_qget_prop(qos, kInterfaceProperty.data(), &value))
      name = value;
    dds_free(value);
    dds_delete_qos(qos);
    if (!name.empty()) return name;
  }
  return {};
}

}  // namespace

std::string text_of_failure(std::int32_t code) { return dds_strretcode(-code); }

OwnedEntity& OwnedEntity::operator=(OwnedEntity&& other) noexcept {
  std::swap(handle_, other.handle_);
  return *this;
}

void OwnedEntity::reset() {
  if (const Entity handle = std::exchange(handle_, 0); handle > 0) dds_delete(handle);
}

Participant::Participant(DomainSettings settings, std::size_t most_bytes)
    : settings_(std::move(settings)), reception_(std::make_shared<Reception>()) {
  reception_->most_bytes = most_bytes;
  const std::lock_guard lock(domain_mutex);
  const std::string used = interface_in_use(settings_.id);
  if (!used.empty() && used != settings_.interface) {
    throw Error(
        fmt::format("interface {}: another plugin of this run uses domain {} through {}; one interface for all "
                    "is expected",
                    settings_.interface, settings_.id, used));
  }
  const Explanation explanation;
  const auto domain = dds_create_domain(settings_.id, domain_configuration(settings_).c_str());
  if (domain < 0 && domain != DDS_RETCODE_PRECONDITION_NOT_MET) {
    throw Error(fmt::format("DDS: domain {} through {} cannot be used{}", settings_.id, settings_.interface,
                            explanation.text()));
  }
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_prop(qos, kInterfaceProperty.data(), settings_.interface.c_str());
  constexpr std::string_view kEnclave = "enclave=/;";  // of a node without security
  dds_qset_userdata(qos, kEnclave.data(), kEnclave.size());
  entity_ = OwnedEntity(dds_create_participant(settings_.id, qos, nullptr));
  dds_delete_qos(qos);
  if (handle() < 0) {
    const std::string reason = explanation.text();
    if (domain > 0) dds_delete(domain);
    throw Error(fmt::format("DDS: domain {} through {}: {}{}", settings_.id, settings_.interface,
                            text_of_failure(handle()), reason));
  }
  publications_ = OwnedEntity(dds_create_reader(handle(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr));
  subscriptions_ = OwnedEntity(dds_create_reader(handle(), DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr));
}

Participant::~Participant() {
  const std::lock_guard lock(domain_mutex);
  publications_.reset();
  subscriptions_.reset();
  const dds_entity_t domain = dds_get_parent(handle());
  entity_.reset();
  if (dds_lookup_participant(settings_.id, nullptr, 0) == 0) dds_delete(domain);
}

std::unique_ptr<Participant> join_domain(const Config& config, const DomainSettings& settings, std::size_t most_bytes) {
  try {
    return std::make_unique<Participant>(settings, most_bytes);
  } catch (const ConfigError&) {
    throw;
  } catch (const Error& error) {
    config.fail("interface", error.what());
  }
}

TopicEntity Participant::make_topic(const std::string& topic, const std::string& type,
                                    std::shared_ptr<Losses> losses) const {
  ddsi_sertype* raw = make_raw_type(type_name(type), reception_, std::move(losses));
  TopicEntity result;
  const dds_entity_t entity =
      dds_create_topic_sertype(handle(), topic_name(topic).c_str(), &raw, nullptr, nullptr, nullptr);
  if (entity < 0) {
    ddsi_sertype_unref(raw);
    throw Error(fmt::format("DDS: topic {} with {}: {}", topic, type, text_of_failure(entity)));
  }
  result.entity = OwnedEntity(entity);
  result.type = raw;
  return result;
}

std::vector<std::string> Participant::types_on(const std::string& topic, bool of_writers) const {
  std::vector<std::string> types;
  const std::string name = topic_name(topic);
  constexpr std::size_t kMost = 256;
  std::array<void*, kMost> samples{};
  std::array<dds_sample_info_t, kMost> infos;
  const dds_entity_t reader = (of_writers ? publications_ : subscriptions_).handle();
  const auto count = dds_read(reader, samples.data(), infos.data(), kMost, kMost);
  for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(count, 0)); ++i) {
    const auto& endpoint = *static_cast<const dds_builtintopic_endpoint_t*>(samples.at(i));
    if (!infos.at(i).valid_data || infos.at(i).instance_state != DDS_IST_ALIVE || endpoint.topic_name != name) continue;
    std::string found = ros_type(endpoint.type_name);
    if (std::ranges::find(types, found) == types.end()) types.push_back(std::move(found));
  }
  if (count > 0) dds_return_loan(reader, samples.data(), count);
  return types;
}

}  // namespace waymark::dds
