// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/join.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "volute/base/checksum.hpp"
#include "volute/base/output_file.hpp"
#include "volute/codec/compress.hpp"
#include "volute/codec/container.hpp"
#include "volute/codec/volute_reader.hpp"

namespace volute {
namespace {

struct Part {
  InputFile file;
  FileHead head;
  std::shared_ptr<const VoluteReader> reader;

  std::string name() const { return file.path().string(); }

  const VolumeInfo& info() const { return head.info; }
};

Result<Part> openPart(const std::filesystem::path& path, std::uint64_t maxMemory) {
  VOLUTE_ASSIGN(auto file, InputFile::open(path));
  VOLUTE_ASSIGN(auto head, readHead(file, maxMemory));
  if (head.grids.size() > 1 || head.grids.front().description) {
    return fail(ErrorCode::kUnsupported,
                "{}: holds what a cache says of its grids; only files of one grid by itself can be "
                "joined: extract the frames of all parts into one folder and compress that",
                path.string());
  }
  VoluteReader::Options options;
  options.maxMemory = maxMemory;
  VOLUTE_ASSIGN(auto reader, VoluteReader::open(path, options));
  return Part{std::move(file), std::move(head),
              std::make_shared<const VoluteReader>(std::move(reader))};
}

std::string gridText(const VolumeInfo& info) {
  return fmt::format(
      "{} x {} x {} voxels with {} channel{} of '{}' [{}], {} basis, from ({:.6g}, {:.6g}, {:.6g}) "
      "to ({:.6g}, {:.6g}, {:.6g}) m",
      info.x, info.y, info.z, info.channels, info.channels == 1 ? "" : "s", info.name, info.unit,
      info.basis == Basis::kBox ? "box" : "trilinear", info.bounds.min.x(), info.bounds.min.y(),
      info.bounds.min.z(), info.bounds.max.x(), info.bounds.max.y(), info.bounds.max.z());
}

bool sameGrid(const VolumeInfo& a, const VolumeInfo& b) {
  const double tolerance = 1e-9 * a.bounds.size().maxCoeff();
  return a.x == b.x && a.y == b.y && a.z == b.z && a.channels == b.channels && a.name == b.name &&
         a.unit == b.unit && a.basis == b.basis &&
         (a.bounds.min - b.bounds.min).cwiseAbs().maxCoeff() <= tolerance &&
         (a.bounds.max - b.bounds.max).cwiseAbs().maxCoeff() <= tolerance;
}

Status checkPair(const Part& before, const Part& part) {
  if (!sameGrid(before.info(), part.info())) {
    return fail(ErrorCode::kInvalidData, "{} and {} do not fit together: {}, and {}", before.name(),
                part.name(), gridText(before.info()), gridText(part.info()));
  }
  if (part.info().frameNumbers.front() <= before.info().frameNumbers.back()) {
    return fail(ErrorCode::kInvalidData,
                "{} has frames {} to {} and {} has {} to {}; expected parts that do not overlap",
                before.name(), before.info().frameNumbers.front(),
                before.info().frameNumbers.back(), part.name(), part.info().frameNumbers.front(),
                part.info().frameNumbers.back());
  }
  return {};
}

/// Seconds between frame numbers that follow each other.
double periodOf(const VolumeInfo& info) {
  constexpr double kUsual = 1.0 / 25;
  if (info.frames < 2)
    return kUsual;
  return (info.times.back() - info.times.front()) /
         (info.frameNumbers.back() - info.frameNumbers.front());
}

/// All frames of all parts; times of a part that begin before those of the one before end go on in
/// the first part's steps.
VolumeInfo joinedInfo(const std::vector<Part>& parts) {
  VolumeInfo joined = parts.front().info();
  const double period = periodOf(joined);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const VolumeInfo& info = parts[i].info();
    double shift = 0;
    if (info.times.front() <= joined.times.back()) {
      const double expected =
          joined.times.front() + (info.frameNumbers.front() - joined.frameNumbers.front()) * period;
      shift = std::max(expected, joined.times.back() + period) - info.times.front();
    }
    joined.frameNumbers.insert(joined.frameNumbers.end(), info.frameNumbers.begin(),
                               info.frameNumbers.end());
    for (const double time : info.times) joined.times.push_back(time + shift);
    joined.frames += info.frames;
  }
  return joined;
}

/// Blocks of 16 frames keep their places in the joined file.
bool canCopy(const std::vector<Part>& parts) {
  return std::ranges::all_of(parts.begin(), parts.end() - 1, [](const Part& part) {
    return part.head.info.frames % BlockGrid::kSide == 0;
  });
}

/// The parts of all, as the file lists them; none where all blocks are read alike.
std::vector<FilePart> partsOf(const std::vector<Part>& parts) {
  std::vector<FilePart> all;
  int row = 0;
  for (const Part& part : parts) {
    const FileHead& head = part.head;
    if (head.parts.empty()) {
      all.push_back({row, static_cast<float>(head.header.valueMin),
                     static_cast<float>(head.header.valueMax), head.parameters, head.decoder});
    }
    for (FilePart one : head.parts) {
      one.firstRow += row;
      all.push_back(std::move(one));
    }
    row += BlockGrid(head.info).counts()[0];
  }
  const auto same = [](const FilePart& a, const FilePart& b) {
    return a.parameters == b.parameters && a.valueMin == b.valueMin && a.valueMax == b.valueMax;
  };
  all.erase(std::unique(all.begin(), all.end(), same), all.end());
  if (all.size() == 1)
    all.clear();
  return all;
}

/// What the parts' own errors come to, all values together [absolute].
struct Errors {
  double rms = 0, most = 0;
  double low = 0, high = 0;  ///< range of the values of all parts

  double relative(double error) const { return high > low ? error / (high - low) : error; }
};

Errors errorsOf(const std::vector<Part>& parts) {
  Errors errors{0, 0, parts.front().head.header.valueMin, parts.front().head.header.valueMax};
  double squares = 0, frames = 0;
  for (const Part& part : parts) {
    const VoluteHeader& header = part.head.header;
    const double range = header.valueMax - header.valueMin;
    const double rms = header.reachedRms * (range > 0 ? range : 1);
    squares += rms * rms * part.info().frames;
    frames += part.info().frames;
    errors.most = std::max(errors.most, header.reachedMaxError);
    errors.low = std::min(errors.low, header.valueMin);
    errors.high = std::max(errors.high, header.valueMax);
  }
  errors.rms = std::sqrt(squares / frames);
  return errors;
}

/// "a; b", each once.
std::string joinedProvenance(const std::vector<Part>& parts) {
  std::string text;
  std::set<std::string> seen;
  for (const Part& part : parts) {
    const std::string& one = part.head.header.provenance;
    if (!one.empty() && seen.insert(one).second)
      text += (text.empty() ? "" : "; ") + one;
  }
  return text;
}

/// What was asked of all parts together: the weakest of what was asked of each, which holds for the
/// whole since its range is no smaller; where different things were, the RMS that is reached.
void joinTargets(const std::vector<Part>& parts, VoluteHeader& header) {
  const std::string kind = header.targetKind;
  const bool same = std::ranges::all_of(
      parts, [&](const Part& part) { return part.head.header.targetKind == kind; });
  if (!same) {
    header.targetKind = "rms";
    header.targetValue = header.reachedRms;
    return;
  }
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const double value = parts[i].head.header.targetValue;
    double& all = header.targetValue;
    all = kind == "size"                      ? all + value
          : kind == "psnr" || kind == "ratio" ? std::min(all, value)
                                              : std::max(all, value);
  }
}

class JoinedFrames final : public FrameSource {
 public:
  explicit JoinedFrames(const std::vector<Part>& parts) : info_(joinedInfo(parts)) {
    for (const Part& part : parts) sources_.push_back(frameSource(part.reader));
  }

  const VolumeInfo& info() const override { return info_; }

  Status readFrame(int index, std::span<float> values) override {
    std::size_t part = 0;
    while (index >= sources_[part]->info().frames) index -= sources_[part++]->info().frames;
    return sources_[part]->readFrame(index, values);
  }

 private:
  VolumeInfo info_;
  std::vector<std::unique_ptr<FrameSource>> sources_;
};

/// The head of the joined file: tier by tier, and in each part after part.
FileHead headOf(const std::vector<Part>& parts, const Errors& errors) {
  FileHead head = parts.front().head;
  head.info = joinedInfo(parts);
  head.parts = partsOf(parts);
  head.header.valueMin = errors.low;
  head.header.valueMax = errors.high;
  head.header.provenance = joinedProvenance(parts);
  head.header.reachedRms = errors.relative(errors.rms);
  head.header.reachedMaxError = errors.most;
  joinTargets(parts, head.header);
  head.segments.clear();
  for (std::size_t tier = 0; tier < head.decoder->tierLevels().size(); ++tier) {
    for (const Part& part : parts) {
      const auto blocks = static_cast<std::ptrdiff_t>(BlockGrid(part.info()).count());
      const auto begin = part.head.segments.begin() + static_cast<std::ptrdiff_t>(tier) * blocks;
      head.segments.insert(head.segments.end(), begin, begin + blocks);
    }
  }
  return head;
}

Status copySegment(const Part& part, const SegmentEntry& segment, OutputFile& out) {
  std::vector<std::byte> bytes(segment.size);
  VOLUTE_TRY(part.file.read(segment.offset, bytes));
  if (crc32(bytes) != segment.crc) {
    return fail(ErrorCode::kInvalidData, "{}: is damaged at byte {}; it cannot be joined",
                part.name(), segment.offset);
  }
  return out.write(bytes);
}

Result<JoinReport> copyBlocks(const std::vector<Part>& parts, const std::filesystem::path& target,
                              Progress& progress) {
  const Errors errors = errorsOf(parts);
  FileHead head = headOf(parts, errors);
  VOLUTE_ASSIGN(auto out, OutputFile::create(target));
  VOLUTE_TRY(out.write(writeHead(head)));
  const std::size_t tiers = head.decoder->tierLevels().size();
  double done = 0;
  for (std::size_t tier = 0; tier < tiers; ++tier) {
    for (const Part& part : parts) {
      if (progress.cancelled())
        return fail(ErrorCode::kCancelled, "stopped: {} was not written", target.string());
      const std::size_t blocks = BlockGrid(part.info()).count();
      for (std::size_t block = 0; block < blocks; ++block)
        VOLUTE_TRY(copySegment(part, part.head.segment(tier, block, blocks), out));
      progress.report("copying", ++done, static_cast<double>(tiers * parts.size()));
    }
  }
  VOLUTE_TRY(out.commit());
  return JoinReport{head.info.frames, true, 0, head.header.reachedRms, head.header.reachedMaxError,
                    head.fileBytes};
}

Result<JoinReport> encodeAgain(const std::vector<Part>& parts, const std::filesystem::path& target,
                               const JoinOptions& options, Progress& progress) {
  constexpr double kFinest = 1e-6;
  const Errors errors = errorsOf(parts);
  JoinedFrames frames(parts);
  CompressOptions how;
  how.target = {ErrorTarget::Kind::kRms,
                options.rms.value_or(std::max(kFinest, errors.relative(errors.rms)))};
  how.provenance = joinedProvenance(parts);
  how.maxMemory = options.maxMemory;
  how.sourceRms = errors.rms;
  how.sourceMaxError = errors.most;
  VOLUTE_ASSIGN(const auto written, compress(frames, target, how, progress));
  return JoinReport{frames.info().frames,
                    false,
                    written.relativeRms,
                    written.relativeRms + errors.relative(errors.rms),
                    written.maxError + errors.most,
                    written.fileBytes};
}

}  // namespace

Result<JoinReport> join(const std::vector<std::filesystem::path>& paths,
                        const std::filesystem::path& target, const JoinOptions& options,
                        Progress& progress) {
  if (paths.empty())
    return fail(ErrorCode::kInvalidArgument, "there is nothing to join; expected .volute files");
  std::vector<Part> parts;
  for (const auto& path : paths) {
    VOLUTE_ASSIGN(auto part, openPart(path, options.maxMemory));
    parts.push_back(std::move(part));
  }
  std::ranges::stable_sort(parts, {},
                           [](const Part& part) { return part.info().frameNumbers.front(); });
  for (std::size_t i = 1; i < parts.size(); ++i) VOLUTE_TRY(checkPair(parts[i - 1], parts[i]));
  VOLUTE_TRY(joinedInfo(parts).validate("the joined sequence"));
  return canCopy(parts) ? copyBlocks(parts, target, progress)
                        : encodeAgain(parts, target, options, progress);
}

}  // namespace volute
