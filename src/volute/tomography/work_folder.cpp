// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/work_folder.hpp"

#include <unistd.h>

#include <cstring>

#include "volute/base/checksum.hpp"
#include "volute/base/input_file.hpp"
#include "volute/base/leftovers.hpp"
#include "volute/base/write_file.hpp"
#include "volute/codec/packing.hpp"
#include "volute/io/json_depth.hpp"
#include "volute/io/json_file.hpp"

namespace volute {
namespace {

namespace fs = std::filesystem;

fs::path valuesFile(const fs::path& folder, int frame) {
  return folder / fmt::format("frame_{:06d}.values", frame);
}

/// Written last: a frame is there when its record is.
fs::path recordFile(const fs::path& folder, int frame) {
  return folder / fmt::format("frame_{:06d}.json", frame);
}

Result<std::vector<std::byte>> readFile(const fs::path& path) {
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  std::vector<std::byte> bytes(file.size());
  VOLUTE_TRY(file.read(0, bytes));
  return bytes;
}

/// Only what is ours: the folder may hold what somebody put there.
void removeFrames(const fs::path& folder) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    const auto process = processOfPart(name);
    const bool used = process && *process != ::getpid() && isRunning(*process);
    const bool ours = name.starts_with("frame_") || name.starts_with(".frame_");
    if (ours && !used && entry.is_regular_file(error))
      fs::remove(entry.path(), error);
  }
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
  std::error_code error;
  fs::create_directory(folder, error);
  if (!fs::is_directory(folder, error)) {
    return fail(ErrorCode::kIo, "{}: cannot make this folder for finished frames", folder.string());
  }
  return WorkFolder(folder, output == "-");
}

bool WorkFolder::has(int frame, const std::string& key) const {
  std::error_code error;
  if (!fs::exists(recordFile(path_, frame), error) || !fs::exists(valuesFile(path_, frame), error))
    return false;
  const auto json = readJson(recordFile(path_, frame));
  return json && json->is_object() && json->value("key", "") == key;
}

bool WorkFolder::any() const {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(path_, error)) {
    if (entry.path().extension() == ".values")
      return true;
  }
  return false;
}

Status WorkFolder::store(int frame, const std::string& key, std::span<const float> values,
                         const nlohmann::ordered_json& record) const {
  const auto packed = pack({std::as_bytes(values)});
  nlohmann::ordered_json stored = {{"key", key}, {"crc", crc32(packed)}, {"record", record}};
  const std::string text = stored.dump();
  std::error_code error;
  fs::remove(recordFile(path_, frame), error);  // must not vouch for values that are not its own
  VOLUTE_TRY(writeFile(valuesFile(path_, frame), packed));
  return writeFile(recordFile(path_, frame), text);
}

Result<std::vector<float>> WorkFolder::values(int frame, std::size_t count) const {
  const auto path = valuesFile(path_, frame);
  VOLUTE_ASSIGN(const auto packed, readFile(path));
  VOLUTE_ASSIGN(const auto json, readJson(recordFile(path_, frame)));
  const auto damaged = [&] {
    return fail(ErrorCode::kInvalidData, "{}: this finished frame is damaged; remove {}",
                path.string(), path_.string());
  };
  if (!json.is_object() || !json.contains("crc") || json["crc"] != crc32(packed) || packed.empty())
    return damaged();
  const auto bytes = unpack(packed, sizeof(float) * count);
  if (!bytes || bytes->size() != sizeof(float) * count)
    return damaged();
  std::vector<float> values(count);
  std::memcpy(values.data(), bytes->data(), bytes->size());
  return values;
}

Result<nlohmann::ordered_json> WorkFolder::record(int frame) const {
  const auto path = recordFile(path_, frame);
  VOLUTE_ASSIGN(const auto bytes, readFile(path));
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  VOLUTE_TRY(checkJsonDepth(text, path.string()));
  const auto json = nlohmann::ordered_json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("record")) {
    return fail(ErrorCode::kInvalidData,
                "{}: this record of a finished frame is damaged; remove {}", path.string(),
                path_.string());
  }
  return json["record"];
}

void WorkFolder::remove() const {
  removeFrames(path_);
  std::error_code error;
  fs::remove(path_, error);  // stays when somebody else's files are in it
}

bool WorkFolder::leave(bool done) const {
  const bool stays = !done && !temporary_ && any();
  if (!stays)
    remove();
  return stays;
}

}  // namespace volute
