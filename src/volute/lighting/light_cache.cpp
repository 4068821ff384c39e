// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/light_cache.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <system_error>

#include "volute/base/checksum.hpp"
#include "volute/base/input_file.hpp"
#include "volute/base/output_file.hpp"

namespace volute {
namespace {

constexpr const char* kExtension = ".light";
constexpr char kMagic[8] = {'V', 'L', 'T', 'L', 'I', 'T', 'E', '1'};

/// What stands before the values, in this machine's byte order: the files do not travel.
struct Header {
  char magic[8];
  char key[32];
  std::uint64_t count;
  std::uint32_t valuesChecksum;
  std::uint32_t headerChecksum;  ///< of all before it
};

static_assert(sizeof(Header) == 56);

Header headerOf(const std::string& key, std::span<const float> values) {
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  key.copy(header.key, sizeof header.key);
  header.count = values.size();
  header.valuesChecksum = crc32(std::as_bytes(values));
  header.headerChecksum =
      crc32(std::as_bytes(std::span(&header, 1)).first(offsetof(Header, headerChecksum)));
  return header;
}

}  // namespace

Result<LightCache> LightCache::open(const std::filesystem::path& folder, std::uint64_t limit) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder, error)) {
    return fail(ErrorCode::kIo, "{}: cannot make a folder for light that was computed",
                folder.string());
  }
  return LightCache(folder, limit);
}

std::filesystem::path LightCache::usualFolder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache && std::filesystem::path(cache).is_absolute())
    return std::filesystem::path(cache) / "volute" / "light";
  const char* home = std::getenv("HOME");
  return home && *home ? std::filesystem::path(home) / ".cache" / "volute" / "light"
                       : std::filesystem::path();
}

std::filesystem::path LightCache::fileOf(const std::string& key) const {
  return folder_ / (key + kExtension);
}

std::optional<std::vector<float>> LightCache::find(const std::string& key,
                                                   std::size_t count) const {
  const auto file = InputFile::open(fileOf(key));
  if (!file || file->size() != sizeof(Header) + count * sizeof(float))
    return std::nullopt;
  Header header{};
  std::vector<float> values(count);
  if (!file->read(0, std::as_writable_bytes(std::span(&header, 1))) ||
      !file->read(sizeof header, std::as_writable_bytes(std::span(values))))
    return std::nullopt;
  const Header expected = headerOf(key, values);
  if (std::memcmp(&header, &expected, sizeof header) != 0)
    return std::nullopt;
  std::error_code ignored;  // it only decides what goes first
  std::filesystem::last_write_time(fileOf(key), std::filesystem::file_time_type::clock::now(),
                                   ignored);
  return values;
}

Status LightCache::store(const std::string& key, std::span<const float> values) const {
  if (sizeof(Header) + values.size_bytes() > limit_)
    return {};
  VOLUTE_ASSIGN(auto file, OutputFile::create(fileOf(key)));
  const Header header = headerOf(key, values);
  VOLUTE_TRY(file.write(std::as_bytes(std::span(&header, 1))));
  VOLUTE_TRY(file.write(std::as_bytes(values)));
  VOLUTE_TRY(file.commit());
  removeOldest();
  return {};
}

void LightCache::removeOldest() const {
  struct Kept {
    std::filesystem::path path;
    std::filesystem::file_time_type used;
    std::uint64_t bytes;
  };

  std::vector<Kept> files;
  std::uint64_t total = 0;
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder_, error), end; !error && it != end;
       it.increment(error)) {
    if (it->path().extension() != kExtension)
      continue;
    // Another program may remove it meanwhile.
    std::error_code gone;
    const Kept kept{it->path(), it->last_write_time(gone), it->file_size(gone)};
    if (gone)
      continue;
    total += kept.bytes;
    files.push_back(kept);
  }
  std::ranges::sort(files, {}, &Kept::used);
  for (const Kept& kept : files) {
    if (total <= limit_)
      return;
    std::filesystem::remove(kept.path, error);
    total -= kept.bytes;
  }
}

}  // namespace volute
