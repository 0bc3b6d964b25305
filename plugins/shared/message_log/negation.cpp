// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/message_log/negation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <span>
#include <utility>

#include "waymark/config/nearest_name.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::message_log {
namespace {

/// Visits the numbers of a payload that may have a sign: not those of a quaternion, which have one together.
template <class Use>
class SignedNumbers final : public FieldEditor {
 public:
  explicit SignedNumbers(Use use) : use_(std::move(use)) {}
  void field(const FieldInfo& info, const FieldSlot& slot) override {
    const auto* numbers = std::get_if<std::span<double>>(&slot);
    if (numbers == nullptr || numbers->size() == 4) return;
    for (std::size_t i = 0; i < numbers->size(); ++i) use_(info.names.at(i), (*numbers)[i]);
  }
  std::size_t list(const FieldInfo&) override { return 0; }

 private:
  Use use_;
};

}  // namespace

ros::Decoder negated(ros::Decoder decode, std::string_view payload_type, std::vector<std::string> names,
                     const Config& entry) {
  std::vector<std::string> known;
  SignedNumbers list([&known](std::string_view name, double&) { known.emplace_back(name); });
  make_payload(payload_type)->edit(list);
  for (const std::string& name : names) {
    if (std::ranges::find(known, name) != known.end()) continue;
    const std::string nearest = nearest_name(name, known);
    entry.fail("negate",
               known.empty()
                   ? fmt::format("{} has no number with a sign", short_type_name(payload_type))
                   : fmt::format("{} has no number \"{}\" with a sign{}; there are: {}", short_type_name(payload_type),
                                 name, nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest),
                                 fmt::join(known, ", ")));
  }
  return [decode = std::move(decode), names = std::move(names)](ros::WireReader in) {
    ros::Decoded decoded = decode(in);
    if (!decoded.payload) return decoded;
    SignedNumbers turn([&names](std::string_view name, double& value) {
      if (std::ranges::find(names, name) != names.end()) value = -value;
    });
    decoded.payload->edit(turn);
    return decoded;
  };
}

}  // namespace waymark::message_log
