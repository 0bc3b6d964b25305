// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/import/clouds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <system_error>

#include "apps/waymark/import/point_file.hpp"
#include "apps/waymark/import/whole_file.hpp"
#include "plugins/shared/cloud_file/cloud_writer.hpp"
#include "waymark/base/error.hpp"

namespace waymark::imports {
namespace {

/// "1305031102.175304.pcd.gz" or "1305031102175304000.csv".
Time time_in_name(const std::filesystem::path& file) {
  std::filesystem::path stem = file.filename();
  for (const std::string_view ending : {".gz", ".pcd", ".csv", ".txt", ".xyz"}) {
    if (stem.extension() == ending) stem = stem.stem();
  }
  const std::string text = stem.string();
  constexpr std::size_t kNanosecondDigits = 16;
  try {
    const bool is_whole = !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
    return parse_time(is_whole && text.size() >= kNanosecondDigits ? text + "e-9" : text);
  } catch (const DataError& error) {
    throw DataError(fmt::format("{}: its name is no time: {}", file.string(), error.what()));
  }
}

/// The first column of a table: a time on each line. A first line that is none is a header.
std::vector<Time> read_times(const std::filesystem::path& file) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 28;
  const std::string content = read_whole(file, kMostBytes, "256 MiB");
  std::vector<Time> times;
  std::size_t line_number = 0;
  for (std::size_t at = 0; at < content.size();) {
    const std::size_t end = std::min(content.find('\n', at), content.size());
    const std::string line = content.substr(at, end - at);
    at = end + 1;
    ++line_number;
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string::npos || line[begin] == '#') continue;
    try {
      times.push_back(parse_time(line.substr(begin, line.find_first_of(" \t\r,;", begin) - begin)));
    } catch (const DataError& error) {
      if (times.empty() && line_number == 1) continue;
      throw DataError(fmt::format("{}:{}: {}", file.string(), line_number, error.what()));
    }
  }
  return times;
}

std::vector<Time> times_of(const CloudImport& settings) {
  std::vector<Time> times;
  if (!settings.times.empty()) {
    times = read_times(settings.times);
    if (times.size() != settings.files.size()) {
      throw DataError(fmt::format("{}: has {} times; there are {} files", settings.times.string(), times.size(),
                                  settings.files.size()));
    }
    return times;
  }
  times.reserve(settings.files.size());
  for (std::size_t i = 0; i < settings.files.size(); ++i) {
    if (settings.times_in_names) {
      times.push_back(time_in_name(settings.files[i]));
      continue;
    }
    const auto after = stamp_after(i, settings.period);
    const auto stamp = after ? moved(settings.start.value_or(Time{}), after->time_since_epoch()) : std::nullopt;
    if (!stamp) throw DataError(fmt::format("{}: its time is no stamp", settings.files[i].string()));
    times.push_back(*stamp);
  }
  return times;
}

}  // namespace

ImportedClouds import_clouds(const CloudImport& settings) {
  if (settings.files.empty()) throw DataError("no file is given");
  if (settings.files.size() > std::numeric_limits<std::uint32_t>::max()) throw DataError("too many files");
  for (const std::filesystem::path& file : settings.files) {
    std::error_code ignored;
    if (std::filesystem::equivalent(file, settings.out, ignored))
      throw DataError(settings.out.string() + ": is one of the files that are read; another name is expected");
  }
  const std::vector<Time> times = times_of(settings);
  ImportedClouds imported;
  imported.first = times.front();
  imported.last = times.back();
  std::unique_ptr<cloud_file::CloudWriter> writer;
  for (std::size_t i = 0; i < settings.files.size(); ++i) {
    const std::string name = settings.files[i].string();
    if (i > 0 && times[i] <= times[i - 1]) {
      throw DataError(fmt::format("{}: its time, {}, is not later than that of the file before, {}", name,
                                  format_time(times[i]), format_time(times[i - 1])));
    }
    PointFile file = read_point_file(settings.files[i], times[i]);
    const bool intensities = !file.cloud.intensities.empty();
    const bool has_times = !file.cloud.offsets_s.empty();
    if (!writer) {
      imported.intensities = intensities;
      imported.times = has_times;
      writer = std::make_unique<cloud_file::CloudWriter>(
          settings.out,
          cloud_file::CloudWriter::Contents{static_cast<std::uint32_t>(settings.files.size()), intensities, has_times});
    } else if (!file.cloud.points_m.empty() && intensities != imported.intensities) {
      throw DataError(fmt::format("{}: has {}intensities, unlike {}", name, intensities ? "" : "no ",
                                  settings.files.front().string()));
    } else if (!file.cloud.points_m.empty() && has_times != imported.times) {
      throw DataError(fmt::format("{}: has {}times of points, unlike {}", name, has_times ? "" : "no ",
                                  settings.files.front().string()));
    }
    writer->add(times[i], file.cloud);
    ++imported.clouds;
    imported.points += file.cloud.points_m.size();
    if (file.not_finite > 0)
      imported.notes.push_back(fmt::format("{}: {} points are not finite and were left out", name, file.not_finite));
    imported.notes.insert(imported.notes.end(), file.notes.begin(), file.notes.end());
  }
  writer->finish();
  return imported;
}

}  // namespace waymark::imports
