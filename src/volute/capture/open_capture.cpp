// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/open_capture.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <regex>
#include <set>
#include <unordered_map>

#include "volute/base/file_name.hpp"
#include "volute/base/read_text.hpp"
#include "volute/capture/clocks.hpp"
#include "volute/capture/image_name.hpp"
#include "volute/capture/importers.hpp"
#include "volute/io/film_frames.hpp"
#include "volute/io/json_file.hpp"
#include "volute/io/stored_picture.hpp"

namespace volute {
namespace {

bool isOpenCvJson(const nlohmann::json& json) {
  return json.is_object() && std::ranges::any_of(json, [](const nlohmann::json& value) {
           return value.is_object() && value.contains("type_id");
         });
}

Result<CaptureDraft> readJsonCapture(const std::filesystem::path& file, std::uint64_t maxMemory) {
  VOLUTE_ASSIGN(const auto json, readJson(file, {.memory = maxMemory}));
  if (json.is_object() && json.contains("format"))
    return readCaptureJson(file, json);
  if (isOpenCvJson(json))
    return readOpenCv(file);
  if (json.is_object() && json.contains("train_videos"))
    return readFilmedFluid(file, json);
  if (json.is_object() && json.contains("DetectorRowCount"))
    return readAstra(file, json);
  if (json.is_object() && json.contains("frames"))
    return readNerfTransforms(file, json);
  return fail(
      ErrorCode::kInvalidData,
      "{}: no capture; expected \"format\": \"volute-capture-1\", a NeRF transforms.json "
      "with \"frames\", an info.json with \"train_videos\", ASTRA's \"cone_vec\", or OpenCV's "
      "matrices",
      file.string());
}

Result<CaptureDraft> readDraft(const std::filesystem::path& file, std::uint64_t maxMemory) {
  std::error_code error;
  if (!std::filesystem::exists(file, error))
    return fail(ErrorCode::kNotFound, "{}: there is no such file", file.string());
  if (std::filesystem::is_directory(file, error))
    return readColmap(file, maxMemory);
  const std::string extension = extensionOf(file);
  if (extension == ".json")
    return readJsonCapture(file, maxMemory);
  if (extension == ".yml" || extension == ".yaml" || extension == ".xml")
    return readOpenCv(file);
  if (extension == ".txt" || extension == ".bin")
    return readColmap(file, maxMemory);
  return fail(ErrorCode::kUnsupported,
              "{}: not a known kind of calibration; expected capture.json, transforms.json, a "
              "COLMAP model's folder, or OpenCV's .yml or .xml",
              file.string());
}

bool isFilm(const std::string& path) {
  constexpr std::array<std::string_view, 5> kFilms{".mp4", ".webm", ".mov", ".mkv", ".avi"};
  return std::ranges::find(kFilms, extensionOf(path)) != kFilms.end();
}

bool sameCalibration(const CameraDraft& one, const CameraDraft& other) {
  constexpr double kRounding = 1e-9;
  const Calibration &a = one.calibration, &b = other.calibration;
  return one.angles == other.angles && one.centred == other.centred && a.width == b.width &&
         a.height == b.height && a.distortion == b.distortion && a.K.isApprox(b.K, kRounding) &&
         a.R.isApprox(b.R, kRounding) && (a.t - b.t).norm() <= kRounding * (1 + a.t.norm());
}

/// "images/frame_####_c0.exr" is camera frame_c0 when no pattern says where its name is, and
/// "c0/%04d.png" camera c0.
std::string plainName(const std::string& pictureName) {
  const std::filesystem::path path(pictureName);
  static const std::regex kNumber("%0?[0-9]*d|#+");
  const std::string stem = path.stem().string();
  std::string name = std::regex_replace(stem, kNumber, "");
  if (name == stem)
    return name;
  for (auto at = name.find("__"); at != std::string::npos; at = name.find("__")) name.erase(at, 1);
  const auto isJoint = [](char c) { return c == '_' || c == '-' || c == '.'; };
  while (!name.empty() && isJoint(name.back())) name.pop_back();
  while (!name.empty() && isJoint(name.front())) name.erase(0, 1);
  return name.empty() ? path.parent_path().filename().string() : name;
}

/// Gives each camera a name, and drops further pictures of a camera that stands still.
Status nameCameras(CaptureDraft& draft, const std::optional<ImageName>& images) {
  std::vector<CameraDraft> cameras;
  std::unordered_map<std::string, std::size_t> placeOf;
  for (CameraDraft& camera : draft.cameras) {
    if (camera.name.empty() && images)
      camera.name = images->cameraIn(camera.pictureName).value_or("");
    if (camera.name.empty())
      camera.name = plainName(camera.pictureName);
    const auto [place, isNew] = placeOf.emplace(camera.name, cameras.size());
    if (isNew) {
      cameras.push_back(std::move(camera));
      continue;
    }
    const CameraDraft* before = &cameras[place->second];
    const bool same = !camera.pictureName.empty() && sameCalibration(*before, camera);
    if (!same) {
      return fail(
          ErrorCode::kInvalidData, Hint::set("images").so("with {camera} says where the name is"),
          "{}: a second camera '{}', other than {}; expected cameras that stand still, each "
          "with a name of its own",
          camera.where, camera.name, before->where);
    }
  }
  draft.cameras = std::move(cameras);
  return {};
}

/// Names become parts of files' names.
Status checkNames(const CaptureDraft& draft) {
  for (const CameraDraft& camera : draft.cameras) {
    if (camera.name.empty())
      return fail(ErrorCode::kInvalidData, "{}: has an empty name", camera.where);
    const auto wrong = std::ranges::find_if(camera.name, [](char letter) {
      return letter == '/' || static_cast<unsigned char>(letter) < ' ' || letter == '\x7f';
    });
    if (wrong == camera.name.end())
      continue;
    return fail(ErrorCode::kInvalidData,
                "{}: the camera's name has {} at place {}; expected one that may be part of a "
                "file's name",
                camera.where,
                *wrong == '/' ? std::string("a slash")
                              : fmt::format("the control character {:#04x}", *wrong),
                wrong - camera.name.begin() + 1);
  }
  return {};
}

Status placePictures(CaptureDraft& draft, const std::optional<ImageName>& images) {
  if (!images)
    return {};
  if (!images->hasCamera() && draft.cameras.size() > 1) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: {{camera}} is missing; expected it where the names of the {} cameras stand",
                images->text(), draft.cameras.size());
  }
  for (CameraDraft& camera : draft.cameras) {
    const std::string name = images->ofCamera(camera.name);
    camera.pictures.image = isFilm(name) ? "" : name;
    camera.pictures.video = isFilm(name) ? name : "";
  }
  return {};
}

std::vector<int> framesInRange(const std::vector<int>& frames, const FrameRange& range) {
  std::vector<int> chosen = selectPositions(frames, {}, range);
  for (int& position : chosen) position = frames[static_cast<std::size_t>(position)];
  return chosen;
}

/// The frames that a camera's picture of a number shows.
std::vector<int> framesShown(const PictureSource& pictures, const std::set<int>& numbers) {
  std::vector<int> frames;
  for (const int number : numbers) {
    const double place = number / pictures.rate + pictures.videoStart - pictures.frameShift;
    if (!(std::abs(place) < 1e9))
      continue;
    constexpr double kMax = 1000;  // frames that one picture may be of
    const int from = static_cast<int>(std::floor(place)),
              to = static_cast<int>(std::ceil(place + std::min(1 / pictures.rate, kMax)));
    for (int frame = std::max(from, 0); frame <= to; ++frame) {
      const PicturePlace shown = pictures.placeOf(frame);
      if (shown.number == number && (shown.share == 0 || numbers.contains(number + 1)))
        frames.push_back(frame);
    }
  }
  return frames;
}

/// The frames of which any camera has a picture, by their clocks. kInvalidData for a camera whose
/// numbers are those of no other: it counts from elsewhere.
Result<std::vector<int>> framesOfFiles(const std::filesystem::path& file, CaptureDraft& draft,
                                       FolderFiles& folders) {
  std::map<int, int> seen;  // how many cameras see a frame
  int earliest = 0;
  std::vector<std::vector<int>> own;
  for (const CameraDraft& camera : draft.cameras) {
    const auto numbers = camera.pictures.numbersThere(folders);
    const bool one = !namesSeries(camera.pictures.image) && camera.pictures.pages == 1;
    if (!one && !numbers.empty()) {  // clocks that are wrong do not enter
      const double begin = numbers.front() / camera.pictures.rate + camera.pictures.videoStart;
      earliest = std::min(earliest, static_cast<int>(std::ceil(std::max(begin, -1e9) - 1e-6)));
    }
    own.push_back(
        one ? numbers
            : framesShown(camera.pictures, std::set<int>(numbers.begin(), numbers.end())));
    for (const int frame : own.back()) ++seen[frame];
  }
  if (earliest < 0)
    draft.remarks.emplace_back(RemarkCode::kLeftOut, framesBeforeZero(earliest));
  for (std::size_t i = 0; i < own.size(); ++i) {
    const bool alone =
        !own[i].empty() && std::ranges::all_of(own[i], [&](int frame) { return seen[frame] == 1; });
    if (!alone)
      continue;  // before all others are gone through
    const auto other = std::ranges::find_if(
        own, [&](const std::vector<int>& frames) { return !frames.empty() && frames != own[i]; });
    if (other == own.end())
      continue;
    const CameraDraft& camera = draft.cameras[i];
    const int by = own[i].front() - other->front();
    return fail(
        ErrorCode::kInvalidData,
        "{}: camera {} has pictures of frames {} to {}, of which no other camera has any ({}: {} "
        "to "
        "{}); if its first picture is that of frame {}, state \"frame_shift\": {} for it, or "
        "\"frames\" for all",
        file.string(), camera.name, own[i].front(), own[i].back(),
        draft.cameras[static_cast<std::size_t>(other - own.begin())].name, other->front(),
        other->back(), other->front(), camera.pictures.frameShift + by);
  }
  std::vector<int> frames;
  for (const auto& [frame, cameras] : seen) frames.push_back(frame);
  return frames;
}

tl::unexpected<Error> ofCamera(const CameraDraft& camera, const Error& error) {
  return fail(error.code, error.hints, "camera {}: {}", camera.name, error.message);
}

/// Remarks on several cameras, of which all that read alike are one.
class SharedRemarks {
 public:
  void add(const std::string& camera, RemarkCode code, const std::string& sentence) {
    auto& names = names_[{sentence, code}];
    if (names.empty() || names.back() != camera)  // cameras come one after the other
      names.push_back(camera);
  }

  void moveTo(std::vector<Remark>& remarks) const {
    for (const auto& [what, names] : names_)
      remarks.emplace_back(what.second, fmt::format("camera{} {}: {}", names.size() > 1 ? "s" : "",
                                                    fmt::join(names, ", "), what.first));
  }

 private:
  std::map<std::pair<std::string, RemarkCode>, std::vector<std::string>> names_;
};

/// Whether a picture states a curve that clearly differs from that which counts.
Result<bool> contradicts(const PictureKind& kind, const std::optional<Response>& response) {
  constexpr double kClearly = 0.02;  // of white; sRGB's curve and 2.2 differ by 0.008
  constexpr int kPlaces = 16;
  if (kind.stated.empty() || !response)
    return false;
  Response stated = Response::srgb();
  if (kind.curve) {
    VOLUTE_ASSIGN(stated, Response::table(*kind.curve));
  }
  double most = 0;
  for (int i = 1; i < kPlaces; ++i) {
    const double at = static_cast<double>(i) / kPlaces;
    most = std::max(most, std::abs(stated.linear(at) - response->linear(at)));
  }
  return most > kClearly;
}

/// Members that count stored values: against what a picture can hold.
Status checkStoredSize(const CameraDraft& camera, const PictureKind& kind, SharedRemarks& remarks) {
  const PictureSource& pictures = camera.pictures;
  if (pictures.saturation.value_or(0) > 1 && !kind.linear)
    return fail(ErrorCode::kInvalidData,
                "camera {}: its \"saturation\" is {:g}; expected a stored value up to 1 = white: "
                "250 of 255 is 0.98",
                camera.name, *pictures.saturation);
  if (pictures.bits != 0 && !kind.linear && kind.largest > 0 &&
      kind.largest < std::ldexp(1.0, pictures.bits) - 1)
    remarks.add(camera.name, RemarkCode::kLeftOut,
                fmt::format("\"bits\": {} has no effect: pictures hold values up to {:.0f}",
                            pictures.bits, kind.largest));
  return {};
}

/// What the first whole picture of each camera says of all of them. What is wrong with others is
/// told when they are read.
Status completeKinds(CaptureDraft& draft, FolderFiles& folders, std::uint64_t maxMemory) {
  SharedRemarks remarks;
  for (CameraDraft& camera : draft.cameras) {
    PictureSource& pictures = camera.pictures;
    const std::string extension = extensionOf(pictures.video);
    if (pictures.image.empty() && (extension == ".tif" || extension == ".tiff")) {
      pictures.image = pictures.video.string();  // a stack is a film of stills
      pictures.video.clear();
    }
    const auto numbers = pictures.numbersThere(folders);
    if (!pictures.video.empty())
      VOLUTE_TRY(checkStoredSize(camera, {}, remarks));
    if (pictures.image.empty() || numbers.empty())
      continue;
    auto path = pictures.fileOf(numbers.front());
    auto kind = pictureKind(path, maxMemory);
    for (std::size_t i = 1; !kind && i < numbers.size(); ++i) {
      path = pictures.fileOf(numbers[i]);
      kind = pictureKind(path, maxMemory);
    }
    if (!kind)
      continue;
    pictures.linear = kind->linear;
    for (const Remark& remark : kind->remarks)
      remarks.add(camera.name, remark.code, remark.sentence);
    VOLUTE_ASSIGN(const bool other, contradicts(*kind, pictures.response));
    if (other) {
      remarks.add(camera.name, RemarkCode::kDoubtful,
                  fmt::format("pictures state {}, and were said to be {}, which counts: are their "
                              "values really stored so?",
                              kind->stated, pictures.response->name()));
    }
    VOLUTE_TRY(checkStoredSize(camera, *kind, remarks));
    if (kind->pages > 1 && namesSeries(pictures.image)) {
      return fail(
          ErrorCode::kInvalidData,
          "camera {}: {} holds {} pictures; expected one in each numbered file, or one file "
          "without a number whose pages are the frames",
          camera.name, path.string(), kind->pages);
    }
    pictures.pages = kind->pages;
  }
  remarks.moveTo(draft.remarks);
  return {};
}

/// How values are stored is said of integers and films; floats are light as they are, and films
/// have their own bits.
void remarkOnIdleStoring(const CaptureOptions& options, CaptureDraft& draft) {
  SharedRemarks remarks;
  for (const CameraDraft& camera : draft.cameras) {
    const PictureSource& pictures = camera.pictures;
    const auto& response = options.response ? options.response : pictures.response;
    const bool film = pictures.image.empty();
    std::vector<std::string> idle;
    if (pictures.linear && response && response->name() != "linear")
      idle.emplace_back("\"color\"");
    if (pictures.linear && pictures.black != 0)
      idle.emplace_back("\"black\"");
    if ((pictures.linear || film) && pictures.bits != 0)
      idle.emplace_back("\"bits\"");
    if (!idle.empty())
      remarks.add(camera.name, RemarkCode::kLeftOut,
                  fmt::format("{} {} no effect on {}", fmt::join(idle, ", "),
                              idle.size() > 1 ? "have" : "has",
                              film ? "a film" : "pictures of floats, which are light as they are"));
  }
  remarks.moveTo(draft.remarks);
}

/// Frames between others of which no camera has a picture.
void remarkOnGaps(const std::vector<int>& frames, std::vector<Remark>& remarks) {
  if (const std::string text = missingNumbers(frames); !text.empty())
    remarks.emplace_back(
        RemarkCode::kDoubtful,
        text + ": no camera has a picture of them; \"frames\" names those that are meant");
}

/// All frames of the capture: those that are stated, else those of which there are pictures; of
/// films those that the range names, else those that all of them have.
Result<std::vector<int>> findFrames(const std::filesystem::path& file, CaptureDraft& draft,
                                    const FrameRange& range, FolderFiles& folders,
                                    std::uint64_t maxMemory) {
  if (draft.frames)
    return *draft.frames;
  const bool film = std::ranges::any_of(
      draft.cameras, [](const CameraDraft& camera) { return !camera.pictures.video.empty(); });
  VOLUTE_ASSIGN(std::vector<int> frames, framesOfFiles(file, draft, folders));
  if (frames.empty() && film && range.end) {
    for (int frame = static_cast<int>(std::ceil(range.begin.value_or(0))); frame < *range.end;
         ++frame)
      frames.push_back(frame);
  } else if (frames.empty()) {
    if (film)
      return framesOfFilms(draft, maxMemory);
    return fail(ErrorCode::kNotFound, Hint::set("images").so("says where they are"),
                "{}: no picture is called {}", file.string(), draft.cameras.front().pictures.image);
  }
  return frames;
}

Result<std::vector<int>> chooseFrames(const std::vector<int>& frames, const FrameRange& range) {
  auto chosen = framesInRange(frames, range);
  if (chosen.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "frames {} select nothing; the capture has frames {} to {}", toString(range),
                frames.front(), frames.back());
  }
  return chosen;
}

/// One picture cannot be that of several frames; of one it may be, which is remarked on where the
/// capture has more.
Status checkNumbers(CaptureDraft& draft, const std::vector<int>& all,
                    const std::vector<int>& chosen) {
  for (const CameraDraft& camera : draft.cameras) {
    const std::string& image = camera.pictures.image;
    if (image.empty() || namesSeries(image) || camera.pictures.pages > 1 || all.size() < 2)
      continue;
    if (chosen.size() > 1) {
      return fail(
          ErrorCode::kInvalidData, Hint::set("frames"),
          "{} ({}): its picture {} has no frame number in its name, and there are {} frames; "
          "expected %04d, %d or #### where the number stands, or one frame",
          camera.where, camera.name, image, chosen.size());
    }
    draft.remarks.emplace_back(
        RemarkCode::kAssumed,
        fmt::format("camera {}: {} has no frame number and is taken for frame {}", camera.name,
                    image, chosen.front()));
  }
  return {};
}

/// What goes by the size of the pictures, once it is known.
void completeIntrinsics(CameraDraft& camera) {
  Mat3& K = camera.calibration.K;
  const std::array<int, 2> sides{camera.calibration.width, camera.calibration.height};
  for (int axis = 0; axis < 2; ++axis) {
    if (K(axis, axis) == 0 && camera.angles[axis] > 0)
      K(axis, axis) = 0.5 * sides[axis] / std::tan(0.5 * camera.angles[axis]);
    if (camera.centred[axis])
      K(axis, 2) = 0.5 * sides[axis];
  }
  if (K(1, 1) == 0)
    K(1, 1) = K(0, 0);
}

/// Calibrations that leave the size out mean that of the pictures; a side that they state stays.
Status completeSize(CameraDraft& camera, FolderFiles& folders, std::uint64_t maxMemory) {
  Calibration& calibration = camera.calibration;
  if (calibration.width > 0 && calibration.height > 0)
    return {};
  const auto take = [&](int width, int height) {
    calibration.width = calibration.width > 0 ? calibration.width : width;
    calibration.height = calibration.height > 0 ? calibration.height : height;
    completeIntrinsics(camera);
    return Status{};
  };
  if (!camera.pictures.video.empty()) {
    const auto film = FilmReader::open(camera.pictures.video, maxMemory);
    if (!film)
      return ofCamera(camera, film.error());
    return take(film->info().width, film->info().height);
  }
  const auto numbers = camera.pictures.numbersThere(folders);
  if (numbers.empty()) {
    return fail(ErrorCode::kNotFound, Hint::set("images").so("says where they are"),
                "{}: states no image size, and there is no picture{} to take it from", camera.where,
                camera.pictures.image.empty() ? "" : " " + camera.pictures.image);
  }
  const auto picture = readStoredPicture(camera.pictures.fileOf(numbers.front()), maxMemory);
  if (!picture)
    return ofCamera(camera, picture.error());
  return take(picture->image.width, picture->image.height);
}

/// What may be so, and hardly is; the first camera stands for the others.
void remarkOnAngles(CaptureDraft& draft) {
  for (const CameraDraft& camera : draft.cameras) {
    constexpr double kWide = 140;  // [degrees]; lenses of more are no pinholes
    const Calibration& calibration = camera.calibration;
    const double angle =
        2 * std::atan(calibration.width / (2 * calibration.K(0, 0))) * 180 / std::numbers::pi;
    if (!(angle > kWide))
      continue;
    draft.remarks.emplace_back(
        RemarkCode::kDoubtful,
        fmt::format("camera {}: a focal length of {:.4g} pixels is an angle of view of {:.0f} "
                    "degrees over {} pixels: is it in mm?",
                    camera.name, calibration.K(0, 0), angle, calibration.width));
    return;
  }
}

Result<CaptureCamera> makeCamera(CameraDraft& draft) {
  auto camera = Camera::calibrated(draft.calibration);
  if (!camera) {
    return fail(ErrorCode::kInvalidData, "{} ({}): {}", draft.where, draft.name,
                camera.error().message);
  }
  return CaptureCamera{draft.name, *camera, std::move(draft.pictures), draft.reprojectionError};
}

Result<CaptureVolume> chooseVolume(const std::filesystem::path& file, const CaptureDraft& draft,
                                   const CaptureOptions& options) {
  const auto bounds = options.bounds ? options.bounds : draft.bounds;
  auto resolution = options.resolution ? options.resolution : draft.resolution;
  if (!bounds) {
    return fail(ErrorCode::kInvalidArgument, Hint::set("bounds"),
                "{}: does not say where the volume is; state its outer faces in metres",
                file.string());
  }
  if (!resolution) {
    return fail(ErrorCode::kInvalidArgument, Hint::set("resolution"),
                "{}: does not say how fine the volume is; state its voxels: about "
                "one for every two pixels that the volume is wide in a picture",
                file.string());
  }
  if ((*resolution)[1] == 0)
    resolution = cubicResolution(*bounds, (*resolution)[0]);
  return CaptureVolume{*bounds, *resolution};
}

std::string conventionText(const CaptureDraft& draft) {
  const std::string kind = draft.kind == "capture.json" ? "" : draft.kind + ": ";
  std::string text = fmt::format("{}{} cameras, pixel centres at {}", kind, draft.cameras.size(),
                                 draft.pixelCentre);
  if (draft.kind == "NeRF transforms" || draft.kind == "filmed fluid")
    text += ", OpenGL's camera axes turned to x right, y down, z forward";
  return text;
}

/// Frames go by the numbers of a pattern, whatever times entries have.
void remarkOnTimes(CaptureDraft& draft) {
  std::set<double> times;
  for (const CameraDraft& camera : draft.cameras) {
    if (camera.time)
      times.insert(*camera.time);
  }
  if (times.size() > 1)
    draft.remarks.emplace_back(
        RemarkCode::kLeftOut,
        fmt::format("entries have {} times (\"time\"), which are not used: with a pattern of the "
                    "pictures' names the number in a name tells the frame",
                    times.size()));
}

/// Names, sizes and cameras: all but frames and volume.
Result<CaptureDraft> openDraft(const std::filesystem::path& file, const CaptureOptions& options,
                               std::optional<ImageName>& images) {
  if (options.images) {
    VOLUTE_ASSIGN(images, ImageName::parse(*options.images));
  }
  VOLUTE_ASSIGN(auto draft, readDraft(file, options.maxMemory));
  constexpr std::uint64_t kBytesOfACamera = 1024;  // with its text and its names
  if (draft.cameras.size() > options.maxMemory / kBytesOfACamera) {
    return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                "{}: {} cameras need {} MiB, more than the {} MiB allowed", file.string(),
                draft.cameras.size(), draft.cameras.size() * kBytesOfACamera >> 20,
                options.maxMemory >> 20);
  }
  if (draft.cameras.empty())
    return fail(ErrorCode::kInvalidData, "{}: has no cameras", file.string());
  if (!images)
    VOLUTE_TRY(groupEntries(draft));
  else
    remarkOnTimes(draft);
  VOLUTE_TRY(nameCameras(draft, images));
  VOLUTE_TRY(checkNames(draft));
  VOLUTE_TRY(placePictures(draft, images));
  settleClocks(draft, options.maxMemory);
  for (CameraDraft& camera : draft.cameras) {
    if (options.response)
      camera.pictures.response = *options.response;
  }
  return draft;
}

Result<Capture> makeCapture(const std::filesystem::path& file, CaptureDraft& draft,
                            FolderFiles& folders, const CaptureOptions& options) {
  Capture capture;
  capture.file = file;
  capture.kind = draft.kind;
  capture.measured = draft.measured;
  capture.pixelCentre = draft.pixelCentre;
  if (draft.framesPerSecond)
    capture.framesPerSecond = *draft.framesPerSecond;
  capture.white = draft.white;
  capture.noiseSigma = options.noiseSigma ? options.noiseSigma : draft.noiseSigma;
  capture.emptyFrames = draft.emptyFrames;
  capture.lighting = draft.lighting;
  capture.spectrum = draft.spectrum;
  for (CameraDraft& camera : draft.cameras)
    VOLUTE_TRY(completeSize(camera, folders, options.maxMemory));
  remarkOnAngles(draft);
  capture.remarks = draft.remarks;
  capture.remarks.insert(capture.remarks.begin(), conventionText(draft));
  for (CameraDraft& camera : draft.cameras) {
    VOLUTE_ASSIGN(auto made, makeCamera(camera));
    capture.cameras.push_back(std::move(made));
  }
  return capture;
}

}  // namespace

std::array<int, 3> cubicResolution(const Box3& bounds, int longest) {
  const double voxel = bounds.size().maxCoeff() / longest;
  std::array<int, 3> voxels{};
  for (int axis = 0; axis < 3; ++axis)
    voxels[axis] = std::max(1, static_cast<int>(std::lround(bounds.size()[axis] / voxel)));
  return voxels;
}

Result<bool> isCapture(const std::filesystem::path& path) {
  const auto isColmap = [](const std::filesystem::path& file) {
    const std::string name = file.filename().string();
    return name == "cameras.txt" || name == "cameras.bin" || name == "images.txt" ||
           name == "images.bin";
  };
  const std::string extension = extensionOf(path);
  if (extension == ".xml") {
    constexpr std::uint64_t kMaxBytes = 16 << 20;
    const auto text = readText(path, kMaxBytes);
    return text && text->find("<opencv_storage") != std::string::npos;
  }
  if (extension == ".yml" || extension == ".yaml" || isColmap(path))
    return true;
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return std::ranges::any_of(std::filesystem::directory_iterator(path, ignored),
                               [&](const auto& entry) { return isColmap(entry.path()); });
  }
  if (extension != ".json")
    return false;
  VOLUTE_ASSIGN(const auto json, readOutermostJson(path));
  const auto format = json.is_object() ? json.value("format", nlohmann::json()) : nlohmann::json();
  const bool scene = format.is_string() && format.get<std::string>().starts_with("volute-scene-");
  if (!json.is_object() || scene)
    return false;
  return json.contains("cameras") || json.contains("frames") || json.contains("camera_matrix") ||
         json.contains("train_videos") || json.contains("DetectorRowCount") ||
         format == "volute-capture-1";
}

void remarkOn(const Capture& capture, Progress& progress) {
  const std::string name = capture.file.string();
  for (Remark remark : capture.remarks) {
    remark.sentence = fmt::format("{}: {}", name, remark.sentence);
    progress.remark(std::move(remark).in(name));
  }
}

std::optional<std::size_t> findCamera(const Capture& capture, const std::string& name) {
  const auto found = std::ranges::find(capture.cameras, name, &CaptureCamera::name);
  if (found == capture.cameras.end())
    return std::nullopt;
  return static_cast<std::size_t>(found - capture.cameras.begin());
}

Result<Capture> openCapture(const std::filesystem::path& file, const CaptureOptions& options) {
  std::optional<ImageName> images;
  VOLUTE_ASSIGN(auto draft, openDraft(file, options, images));
  for (const CameraDraft& camera : draft.cameras) {
    if (camera.pictures.image.empty() && camera.pictures.video.empty()) {
      return fail(ErrorCode::kInvalidArgument, Hint::set("images"),
                  "{} ({}): has no pictures; state a pattern of their names, in which "
                  "{{camera}} is the camera's name and %04d the frame",
                  camera.where, camera.name);
    }
  }
  FolderFiles folders;
  VOLUTE_TRY(completeKinds(draft, folders, options.maxMemory));
  remarkOnIdleStoring(options, draft);
  VOLUTE_ASSIGN(const auto all,
                findFrames(file, draft, options.frames, folders, options.maxMemory));
  VOLUTE_ASSIGN(auto frames, chooseFrames(all, options.frames));
  if (!draft.frames)
    remarkOnGaps(frames, draft.remarks);
  VOLUTE_TRY(checkNumbers(draft, all, frames));
  VOLUTE_ASSIGN(const auto volume, chooseVolume(file, draft, options));
  if (!draft.framesPerSecond && frames.size() > 1)
    draft.remarks.emplace_back(
        RemarkCode::kAssumed,
        fmt::format("no rate is stated: {} frames a second are assumed, by which times and speeds "
                    "go; state it in a capture.json, \"frames_per_second\" beside \"frames\"",
                    kUnstatedRate));
  const bool clocked = std::ranges::any_of(draft.cameras, [](const CameraDraft& camera) {
    return !camera.pictures.video.empty() || camera.pictures.videoStart != 0;
  });
  VOLUTE_ASSIGN(auto capture, makeCapture(file, draft, folders, options));
  capture.frames = std::move(frames);
  capture.statedFrames = draft.frames.value_or(std::vector<int>{});
  capture.firstFrame = clocked ? 0 : all.front();
  capture.volume = volume;
  return capture;
}

Result<Capture> openCalibration(const std::filesystem::path& file, const CaptureOptions& options) {
  std::optional<ImageName> images;
  VOLUTE_ASSIGN(auto draft, openDraft(file, options, images));
  FolderFiles folders;
  VOLUTE_ASSIGN(auto capture, makeCapture(file, draft, folders, options));
  capture.frames = draft.frames.value_or(std::vector<int>{});
  capture.statedFrames = capture.frames;
  if (auto volume = chooseVolume(file, draft, options))
    capture.volume = *volume;
  return capture;
}

}  // namespace volute
