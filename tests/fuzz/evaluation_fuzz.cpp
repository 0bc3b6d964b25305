// SPDX-License-Identifier: Apache-2.0
// What `waymark evaluate` reads; the first byte of an input says what the rest is.
#include "apps/waymark/evaluation/relations.hpp"
#include "apps/waymark/evaluation/surfaces.hpp"
#include "apps/waymark/evaluation/trajectory_io.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"

namespace waymark::fuzz::evaluation_harness {
namespace {
void run(std::string_view input) {
  const Choice choice = choose(input, 5);
  const auto file = write("table.txt", choice.rest);
  const Datum datum{49.0, 8.0, 100.0};
  expect_value_or_error(
      [&] {
        switch (choice.which) {
          case 0: {
            const auto trajectory = evaluation::read_trajectory(file, std::nullopt, datum);
            for (const auto& point : trajectory.points) {
              if (!point.pose.p.allFinite() || !point.pose.q.coeffs().allFinite())
                violation("a trajectory has a pose that is not finite");
            }
            break;
          }
          case 1:
            (void)evaluation::read_landmarks(file);
            break;
          case 2:
            (void)evaluation::read_relations(file);
            break;
          case 3:
            (void)evaluation::read_surfaces(file);
            break;
          default:
            (void)evaluation::read_landmarks(file, evaluation::Columns{{"name", 0}, {"x", 1}, {"y", 2}, {"radius", 3}});
        }
      },
      file.string());
}

const Harness kHarness("evaluation", run);

}  // namespace
}  // namespace waymark::fuzz::evaluation_harness
