// SPDX-License-Identifier: Apache-2.0
#include "fusion/measurement_archive.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <bit>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "waymark/base/error.hpp"
#include "waymark/base/overloaded.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::fusion {
namespace {

/// Numbers are written as their bits, since those of a payload need not be finite.
void write_bits(OutArchive& out, double number) { out(std::bit_cast<std::uint64_t>(number)); }
void write_bits(OutArchive& out, float number) { out(std::bit_cast<std::uint32_t>(number)); }
void read_bits(InArchive& in, double& number) {
  std::uint64_t bits = 0;
  in(bits);
  number = std::bit_cast<double>(bits);
}
void read_bits(InArchive& in, float& number) {
  std::uint32_t bits = 0;
  in(bits);
  number = std::bit_cast<float>(bits);
}

/// Lists grow element by element, so that a damaged count takes no more memory than the stream has content.
template <class T, class Read>
void read_list(InArchive& in, std::vector<T>& list, const Read& read) {
  std::uint64_t size = 0;
  in(size);
  list.clear();
  for (std::uint64_t i = 0; i < size; ++i) read(list.emplace_back());
}

class FieldWriter final : public FieldVisitor {
 public:
  explicit FieldWriter(OutArchive& out) : out_(out) {}
  void field(const FieldInfo&, const FieldValue& value) override {
    std::visit(Overloaded{[&](std::span<const double> numbers) {
                            for (const double number : numbers) write_bits(out_, number);
                          },
                          [&](std::int64_t number) { out_(number); }, [&](bool flag) { out_(flag); },
                          [&](FieldWord word) { out_(static_cast<std::int32_t>(word.number)); },
                          [&](std::span<const float> list) {
                            out_(static_cast<std::uint64_t>(list.size()));
                            for (const float number : list) write_bits(out_, number);
                          },
                          [&](std::span<const Eigen::Vector3f> points) {
                            out_(static_cast<std::uint64_t>(points.size()));
                            for (const Eigen::Vector3f& p : points) {
                              for (int i = 0; i < 3; ++i) write_bits(out_, p[i]);
                            }
                          },
                          [&](std::span<const std::uint8_t> data) {
                            out_(static_cast<std::uint64_t>(data.size()));
                            for (const std::uint8_t byte : data) out_(byte);
                          }},
               value);
  }
  void list(const FieldInfo&, std::size_t size) override { out_(static_cast<std::uint64_t>(size)); }

 private:
  OutArchive& out_;
};

class FieldReader final : public FieldEditor {
 public:
  explicit FieldReader(InArchive& in) : in_(in) {}
  void field(const FieldInfo& info, const FieldSlot& slot) override {
    std::visit(
        Overloaded{
            [&](std::span<double> numbers) {
              for (double& number : numbers) read_bits(in_, number);
            },
            [&](int* number) {
              std::int64_t value = 0;
              in_(value);
              *number = static_cast<int>(value);
            },
            [&](bool* flag) { in_(*flag); },
            [&](WordSlot word) {
              std::int32_t number = 0;
              in_(number);
              if (number < 0 || static_cast<std::size_t>(number) >= info.words.size())
                throw DataError(fmt::format("the checkpoint has an unknown {}", info.name()));
              word.assign(word.value, number);
            },
            [&](std::vector<float>* list) { read_list(in_, *list, [&](float& v) { read_bits(in_, v); }); },
            [&](std::vector<Eigen::Vector3f>* points) {
              read_list(in_, *points, [&](Eigen::Vector3f& p) {
                for (int i = 0; i < 3; ++i) read_bits(in_, p[i]);
              });
            },
            [&](std::vector<std::uint8_t>* data) { read_list(in_, *data, [&](std::uint8_t& byte) { in_(byte); }); }},
        slot);
  }
  /// A list is resized at once: its size is bounded.
  std::size_t list(const FieldInfo&) override {
    constexpr std::uint64_t kMost = 1'000'000;
    std::uint64_t size = 0;
    in_(size);
    if (size > kMost) throw DataError("the checkpoint has a list that is too long");
    return static_cast<std::size_t>(size);
  }

 private:
  InArchive& in_;
};

}  // namespace

void write_measurement(OutArchive& out, const Measurement& measurement) {
  out(measurement.stamp, measurement.arrival, measurement.sensor, measurement.sequence,
      std::string(measurement.payload->type()));
  FieldWriter writer(out);
  if (!measurement.payload->visit(writer))
    throw Error(
        fmt::format("{} has no registered fields: a checkpoint cannot contain it", measurement.payload->type()));
}

Measurement read_measurement(InArchive& in) {
  Measurement measurement;
  std::string type;
  in(measurement.stamp, measurement.arrival, measurement.sensor, measurement.sequence, type);
  const std::shared_ptr<Payload> payload = make_payload(type);
  if (!payload) throw DataError(fmt::format("the checkpoint has a measurement of the unknown type \"{}\"", type));
  FieldReader reader(in);
  payload->edit(reader);
  measurement.payload = payload;
  return measurement;
}

}  // namespace waymark::fusion
