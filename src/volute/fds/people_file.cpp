// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/people_file.hpp"

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <vector>

#include "volute/fds/fds_input.hpp"
#include "volute/fds/particle_file.hpp"

namespace volute {
namespace {

constexpr double kOffset = 1;  // of an evacuation mesh's middle above its floor, FDS's default [m]

Status addFile(const std::filesystem::path& path, double offset, std::uint64_t most,
               std::string& table) {
  auto file = FdsParticleFile::openPeople(path);
  if (!file) {
    return fail(file.error().code,
                "{}; expected people of FDS+Evac, or the index of their case (.smv)",
                file.error().message);
  }
  for (std::size_t frame = 0; frame < file->frames().times.size(); ++frame) {
    VOLUTE_ASSIGN(const auto classes, file->readFrame(frame));
    for (const FdsParticles& people : classes) {
      for (std::size_t i = 0; i < people.places.size(); ++i) {
        const auto& [x, y, z] = people.places[i];
        fmt::format_to(std::back_inserter(table), "{},{},{},{},{}\n", people.numbers[i],
                       file->frames().times[frame], x, y, z - offset);
      }
    }
    if (table.size() > most) {
      return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                  "{}: has more places of people than fit into {} MiB", path.string(), most >> 20);
    }
  }
  return {};
}

}  // namespace

bool mayHoldPeople(const std::filesystem::path& path) {
  if (isSmvPath(path.string()))
    return true;
  std::array<std::int32_t, 3> first{};  // the record of a 1
  std::ifstream file(path, std::ios::binary);
  return file.read(reinterpret_cast<char*>(first.data()), sizeof first) &&
         first == std::array<std::int32_t, 3>{4, 1, 4};
}

Result<std::string> fdsPeopleTable(const std::filesystem::path& path, std::uint64_t most) {
  std::string table = "id,time,x,y,floor\n";
  if (!isSmvPath(path.string())) {
    VOLUTE_TRY(addFile(path, kOffset, most, table));
    return table;
  }
  VOLUTE_ASSIGN(const SmvIndex index, SmvIndex::read(path, most));
  if (index.people.empty()) {
    return fail(ErrorCode::kNotFound,
                "{}: names no people: expected a case of FDS+Evac, with particles (PRT5) of an "
                "evacuation mesh",
                path.string());
  }
  const auto& offsets = inputOf(index).evacuationOffsets;
  for (const FdsPeopleEntry& entry : index.people) {
    const auto stated = offsets.find(entry.mesh);
    VOLUTE_TRY(
        addFile(entry.file, stated == offsets.end() ? kOffset : stated->second, most, table));
  }
  return table;
}

}  // namespace volute
