// SPDX-License-Identifier: Apache-2.0
// What the harnesses have in common: an input as files, and what a parser may do with it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace waymark::fuzz {

/// An input: what libFuzzer gives to a harness.
std::string_view text_of(const std::uint8_t* data, std::size_t size);

/// The first byte of an input, which selects one of `count` cases, and the rest. An empty input selects case 0.
struct Choice {
  std::size_t which = 0;
  std::string_view rest;
};
Choice choose(std::string_view input, std::size_t count);

/// The folder that holds the files of inputs; one per process, below TMPDIR, removed at the end.
const std::filesystem::path& folder();

/// Writes a file into `folder()`, with the folders above it, and returns its path.
std::filesystem::path write(const std::filesystem::path& name, std::string_view content);

/// Calls `parse`. It may end well, or throw a waymark::Error with one line; with `place` the line contains that text.
/// Any other exception ends the program, as does `violation`.
void expect_value_or_error(const std::function<void()>& parse, std::string_view place = {});

/// Prints what is wrong with the result of a parser and aborts: libFuzzer keeps the input.
[[noreturn]] void violation(std::string_view what);

}  // namespace waymark::fuzz
