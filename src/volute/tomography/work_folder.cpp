// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/work_folder.hpp"

#include <unistd.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "volute/base/checksum.hpp"
#include "volute/base/input_file.hpp"
#include "volute/base/write_file.hpp"
#include "volute/codec/packing.hpp"
#include "volute/io/json_check.hpp"

namespace volute {
namespace {

namespace fs = std::filesystem;

fs::path valuesFile(const fs::path& folder, int frame, const std::string& key) {
  return folder / fmt::format("frame_{:06d}.{}.values", frame, key);
}

/// Written last: a frame is there when its record is.
fs::path recordFile(const fs::path& folder, int frame, const std::string& key) {
  return folder / fmt::format("frame_{:06d}.{}.json", frame, key);
}

Result<std::vector<std::byte>> readFile(const fs::path& path) {
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  std::vector<std::byte> bytes(file.size());
  VOLUTE_TRY(file.read(0, bytes));
  return bytes;
}

}  // namespace

std::string digestOf(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x100000001b3u;
  }
  return fmt::format("{:016x}", hash);
}

Result<WorkFolder> WorkFolder::open(const fs::path& output) {
  fs::path folder = output;
  folder += ".work";
  if (output == "-")
    folder = fs::temp_directory_path() / fmt::format("volute-{}.work", ::getpid());
  VOLUTE_ASSIGN(auto shared, SharedFolder::open(folder, "finished frames"));
  return WorkFolder(std::move(shared), output == "-");
}

bool WorkFolder::has(int frame, const std::string& key) const {
  std::error_code error;
  return fs::exists(recordFile(path(), frame, key), error) &&
         fs::exists(valuesFile(path(), frame, key), error);
}

bool WorkFolder::any() const {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(path(), error)) {
    if (entry.path().extension() == ".values")
      return true;
  }
  return false;
}

Status WorkFolder::store(int frame, const std::string& key, std::span<const float> values,
                         const nlohmann::ordered_json& record) const {
  const auto packed = pack({std::as_bytes(values)});
  const nlohmann::ordered_json stored = {{"crc", crc32(packed)}, {"record", record}};
  const std::string text = stored.dump();
  VOLUTE_TRY(writeFile(valuesFile(path(), frame, key), packed));
  return writeFile(recordFile(path(), frame, key), text);
}

Result<std::vector<std::byte>> WorkFolder::packed(int frame, const std::string& key) const {
  const auto file = valuesFile(path(), frame, key);
  VOLUTE_ASSIGN(auto packed, readFile(file));
  VOLUTE_ASSIGN(const auto json, stored(frame, key));
  if (!json.contains("crc") || json["crc"] != crc32(packed) || packed.empty())
    return damaged(file);
  return packed;
}

bool WorkFolder::sound(int frame, const std::string& key) const {
  return packed(frame, key).has_value();
}

Result<std::vector<float>> WorkFolder::values(int frame, const std::string& key,
                                              std::size_t count) const {
  VOLUTE_ASSIGN(const auto packed, this->packed(frame, key));
  const auto bytes = unpack(packed, sizeof(float) * count);
  if (!bytes || bytes->size() != sizeof(float) * count)
    return damaged(valuesFile(path(), frame, key));
  std::vector<float> values(count);
  std::memcpy(values.data(), bytes->data(), bytes->size());
  return values;
}

Result<nlohmann::ordered_json> WorkFolder::stored(int frame, const std::string& key) const {
  const auto file = recordFile(path(), frame, key);
  VOLUTE_ASSIGN(const auto bytes, readFile(file));
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!checkJson(text, file.string()))
    return damaged(file);
  auto json = nlohmann::ordered_json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("record"))
    return damaged(file);
  return json;
}

tl::unexpected<Error> WorkFolder::damaged(const fs::path& file) const {
  return fail(ErrorCode::kInvalidData, "{}: this finished frame is damaged; remove {}",
              file.string(), path().string());
}

Result<nlohmann::ordered_json> WorkFolder::record(int frame, const std::string& key) const {
  VOLUTE_ASSIGN(const auto json, stored(frame, key));
  return json["record"];
}

void WorkFolder::remove() const {
  folder_.remove([](const std::string& name) {
    return name.starts_with("frame_") || name.starts_with(".frame_");
  });
}

bool WorkFolder::leave(bool done) const {
  const bool stays = !done && !temporary_ && any();
  if (!stays)
    remove();
  return stays;
}

}  // namespace volute
