// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/unit_store.hpp"

#include <algorithm>

#include "volute/base/checksum.hpp"
#include "volute/base/input_file.hpp"
#include "volute/base/leftovers.hpp"
#include "volute/base/write_file.hpp"

namespace volute {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = "unit_";

/// The checksum of what follows it, and that.
Status writeChecked(const fs::path& path, std::span<const std::byte> content) {
  std::vector<std::byte> bytes(4 + content.size());
  const std::uint32_t crc = crc32(content);
  for (std::size_t i = 0; i < 4; ++i) bytes[i] = static_cast<std::byte>(crc >> 8 * i);
  std::ranges::copy(content, bytes.begin() + 4);
  return writeFile(path, bytes);
}

std::optional<std::vector<std::byte>> readChecked(const fs::path& path) {
  const auto file = InputFile::open(path);
  if (!file || file->size() < 4)
    return std::nullopt;
  std::vector<std::byte> bytes(static_cast<std::size_t>(file->size()));
  if (!file->read(0, bytes))
    return std::nullopt;
  std::uint32_t crc = 0;
  for (std::size_t i = 0; i < 4; ++i) crc |= static_cast<std::uint32_t>(bytes[i]) << 8 * i;
  bytes.erase(bytes.begin(), bytes.begin() + 4);
  if (crc32(bytes) != crc)
    return std::nullopt;
  return bytes;
}

}  // namespace

Result<UnitStore> UnitStore::open(const fs::path& folder, const std::string& key) {
  VOLUTE_ASSIGN(auto shared, SharedFolder::open(folder, "finished units"));
  return UnitStore(std::move(shared), key);
}

fs::path UnitStore::fileOf(int pass, std::int64_t unit, const char* extension) const {
  return folder_.path() / fmt::format("{}{}_{:02}_{:06}.{}", kPrefix, key_, pass, unit, extension);
}

std::optional<std::vector<std::byte>> UnitStore::record(int pass, std::int64_t unit) const {
  return readChecked(fileOf(pass, unit, "record"));
}

std::optional<std::vector<std::byte>> UnitStore::bytes(int pass, std::int64_t unit) const {
  return readChecked(fileOf(pass, unit, "bytes"));
}

Status UnitStore::store(int pass, std::int64_t unit, std::span<const std::byte> record,
                        std::span<const std::byte> bytes) const {
  if (!bytes.empty())
    VOLUTE_TRY(writeChecked(fileOf(pass, unit, "bytes"), bytes));
  return writeChecked(fileOf(pass, unit, "record"), record);
}

void UnitStore::dropBytes(int pass, std::int64_t unit) const {
  std::error_code error;
  fs::remove(fileOf(pass, unit, "bytes"), error);
}

void UnitStore::remove() const {
  folder_.remove([](const std::string& name) {
    return name.starts_with(kPrefix) ||
           (processOfPart(name) && name.starts_with(fmt::format(".{}", kPrefix)));
  });
}

}  // namespace volute
