// SPDX-License-Identifier: Apache-2.0
#include "axis_orders.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

namespace waymark::host::diagnosis {

std::vector<Order> wrong_orders() {
  std::vector<Order> orders;
  orders.reserve(47);
  std::array<Eigen::Index, 3> axes{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Order order = Order::Zero();
      for (Eigen::Index i = 0; i < 3; ++i)
        order(i, axes[static_cast<std::size_t>(i)]) = ((signs >> i) & 1) != 0 ? -1.0 : 1.0;
      if (!order.isIdentity()) orders.push_back(order);
    }
  } while (std::ranges::next_permutation(axes).found);
  return orders;
}

std::string columns_of(const WatchedSensor& sensor, const Order& order, const std::string& columns) {
  std::vector<std::string> names;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (order(i, i) <= 0.0)
      names.push_back(fmt::format(fmt::runtime(columns), axis_along(sensor, Order::Identity().col(i))));
  }
  std::ranges::sort(names);
  const bool is_sign = order.cwiseAbs().isIdentity();
  return fmt::format("{} of {} of {}",
                     !is_sign           ? "the order or the signs"
                     : names.size() > 1 ? "the signs"
                                        : "the sign",
                     fmt::join(names, " and "), sensor.name);
}

}  // namespace waymark::host::diagnosis
