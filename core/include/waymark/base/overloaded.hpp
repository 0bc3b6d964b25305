// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waymark {

/// One visitor of a variant out of several lambdas.
template <class... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};
template <class... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;

}  // namespace waymark
