// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/capture_check.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <numeric>
#include <optional>
#include <unordered_map>

#include "volute/capture/capture_images.hpp"
#include "volute/capture/geometry_check.hpp"
#include "volute/io/stored_picture.hpp"

namespace volute {

namespace {

/// What two cameras' pictures of a frame have in common.
enum class Alike { kNothing, kBytes, kFile };

/// Nothing where either has no picture of it.
std::optional<Alike> alikeAt(const PictureSource& a, const PictureSource& b, int frame) {
  const PicturePlace first = a.placeOf(frame), second = b.placeOf(frame);
  const bool sameNumber = first.number == second.number && first.share == second.share;
  if (!a.video.empty() || !b.video.empty())
    return a.video == b.video && sameNumber ? Alike::kFile : Alike::kNothing;
  if (!a.isThere(first.number) || !b.isThere(second.number))
    return std::nullopt;
  const auto one = a.fileOf(first.number), other = b.fileOf(second.number);
  std::error_code error;
  if (std::filesystem::file_size(one, error) != std::filesystem::file_size(other, error))
    return Alike::kNothing;
  if (!(a.pages == 1 && b.pages == 1) && first.number != second.number)
    return Alike::kNothing;
  if (std::filesystem::equivalent(one, other, error))
    return Alike::kFile;
  std::ifstream bytes(one, std::ios::binary), otherBytes(other, std::ios::binary);
  using Bytes = std::istreambuf_iterator<char>;
  return bytes && otherBytes && std::equal(Bytes(bytes), Bytes(), Bytes(otherBytes), Bytes())
             ? Alike::kBytes
             : Alike::kNothing;
}

/// Whether a picture has one value all over, as darkness has.
bool isEven(const PictureSource& source, int frame, std::uint64_t maxMemory) {
  const PicturePlace place = source.placeOf(frame);
  if (!source.video.empty() || !source.isThere(place.number))
    return false;
  const auto read = readStoredPicture(source.fileOf(place.number), maxMemory,
                                      source.pages == 1 ? 0 : place.number);
  if (!read || read->image.pixels.empty())
    return false;
  const auto [least, most] = std::ranges::minmax(read->image.pixels);
  return least == most;
}

/// What cameras share that see one picture in the first frame: its file's length and beginning.
/// Nothing where it has no picture of that frame.
std::optional<std::string> beginningOf(const PictureSource& source, int frame) {
  const PicturePlace place = source.placeOf(frame);
  if (!source.video.empty())
    return source.video.string();
  if (!source.isThere(place.number))
    return std::nullopt;
  const auto file = source.fileOf(place.number);
  std::error_code error;
  std::string beginning(4096, '\0');
  std::ifstream bytes(file, std::ios::binary);
  bytes.read(beginning.data(), static_cast<std::streamsize>(beginning.size()));
  beginning.resize(static_cast<std::size_t>(bytes.gcount()));
  return fmt::format("{} {}", std::filesystem::file_size(file, error), beginning);
}

/// For each camera those before it that may have its pictures, so that thousands of cameras are not
/// compared each with each.
std::vector<std::vector<std::size_t>> alike(const Capture& capture) {
  std::vector<std::vector<std::size_t>> others(capture.cameras.size());
  std::unordered_map<std::string, std::vector<std::size_t>> seen;
  std::vector<std::size_t> late;  // without a picture of the first frame
  for (std::size_t i = 0; i < capture.cameras.size() && !capture.frames.empty(); ++i) {
    const PictureSource& pictures = capture.cameras[i].pictures;
    const auto beginning = beginningOf(pictures, capture.frames.front());
    if (beginning) {
      auto& same = seen[*beginning];
      others[i] = same;
      others[i].insert(others[i].end(), late.begin(), late.end());
      same.push_back(i);
    } else if (std::ranges::any_of(capture.frames, [&](int frame) {
                 return pictures.isThere(pictures.placeOf(frame).number);
               })) {
      others[i].resize(i);
      std::iota(others[i].begin(), others[i].end(), std::size_t{0});
      late.push_back(i);
    }
  }
  return others;
}

/// Two cameras in different places do not see the same, all the time, but nothing; of what is
/// symmetric they may have equal pictures, but not one file.
struct PicturesOfOthers {
  std::vector<std::string> faults;
  std::vector<std::pair<std::string, std::string>> copies;  // names of cameras
};

PicturesOfOthers picturesOfOthers(const Capture& capture, std::uint64_t maxMemory) {
  PicturesOfOthers found;
  const auto others = alike(capture);
  for (std::size_t i = 0; i < capture.cameras.size(); ++i) {
    for (const std::size_t j : others[i]) {
      const CaptureCamera &camera = capture.cameras[i], &other = capture.cameras[j];
      std::size_t files = 0, same = 0;
      const bool differ = std::ranges::any_of(capture.frames, [&](int frame) {
        const auto is = alikeAt(camera.pictures, other.pictures, frame);
        files += is == Alike::kFile ? 1 : 0;
        same += is && is != Alike::kNothing ? 1 : 0;
        return is == Alike::kNothing;
      });
      if (differ || same == 0)
        continue;
      if (std::ranges::all_of(capture.frames,
                              [&](int frame) { return isEven(camera.pictures, frame, maxMemory); }))
        continue;
      if (files == 0) {
        found.copies.emplace_back(other.name, camera.name);
        break;
      }
      const bool one = capture.frames.size() == 1;
      found.faults.push_back(
          fmt::format("cameras {} and {} take their picture{} from the same file{}; expected "
                      "different ones, as they look from different places",
                      other.name, camera.name, one ? "" : "s", one ? "" : "s at all frames"));
      break;
    }
  }
  return found;
}

}  // namespace

bool isGrey(const Capture& capture, std::uint64_t maxMemory) {
  for (const int frame : capture.frames) {
    for (const CaptureCamera& camera : capture.cameras) {
      const PictureSource& pictures = camera.pictures;
      if (!pictures.video.empty())
        return false;
      const PicturePlace place = pictures.placeOf(frame);
      for (int number = place.number; number <= place.number + (place.share > 0 ? 1 : 0);
           ++number) {
        if (!pictures.isThere(number))
          continue;
        const auto kind =
            pictureKind(pictures.fileOf(number), maxMemory, pictures.pages == 1 ? 0 : number);
        if (kind && kind->channels == 3)
          return false;
      }
    }
  }
  return true;
}

Status checkCapture(const Capture& capture, const std::vector<std::string>& heldOut, bool force,
                    std::uint64_t maxMemory, Progress& progress) {
  constexpr int kFewest = 3;
  const auto fitted = std::ranges::count_if(capture.cameras, [&](const CaptureCamera& camera) {
    return std::ranges::find(heldOut, camera.name) == heldOut.end();
  });
  std::vector<std::string> faults;
  if (fitted < kFewest) {
    faults.push_back(
        fmt::format("{} view{} {} too few to tell where light is along a ray; expected at least {}",
                    fitted, fitted == 1 ? "" : "s", fitted == 1 ? "is" : "are", kFewest));
  }
  for (const GeometryFault& fault : checkGeometry(capture)) faults.push_back(fault.message);
  PicturesOfOthers pictures = picturesOfOthers(capture, maxMemory);
  std::ranges::move(pictures.faults, std::back_inserter(faults));
  if (!faults.empty() && !force)
    return fail(ErrorCode::kInvalidData, Hint::set("force").so("goes on"), "{}: {}",
                capture.file.string(), faults.front());
  for (const auto& fault : faults) progress.remark({RemarkCode::kDoubtful, "warning: " + fault});
  if (!pictures.copies.empty()) {
    const auto& [one, other] = pictures.copies.front();
    const std::size_t more = pictures.copies.size() - 1;
    progress.remark(
        {RemarkCode::kDoubtful,
         fmt::format(
             "warning: cameras {} and {} have equal pictures{}{}: is one a copy, or "
             "what they see symmetric?",
             one, other, capture.frames.size() == 1 ? "" : " at all frames",
             more == 0 ? "" : fmt::format(", and {} more pair{}", more, more == 1 ? "" : "s"))});
  }
  if (fitted == 0)
    return fail(ErrorCode::kInvalidArgument, "no camera is left to reconstruct from");
  VOLUTE_ASSIGN(const auto missing, checkPicturesThere(capture, force, maxMemory));
  for (const auto& text : missing) progress.remark({RemarkCode::kLeftOut, "warning: " + text});
  return {};
}

}  // namespace volute
