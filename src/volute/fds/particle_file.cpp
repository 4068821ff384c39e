// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/particle_file.hpp"

#include <cmath>

#include "volute/fds/frame_scan.hpp"
#include "volute/fds/text_lines.hpp"

namespace volute {
namespace {

constexpr int kMaxQuantities = 1000;  // of a class

}  // namespace

Result<FdsParticleFile> FdsParticleFile::open(const FdsParticleEntry& entry) {
  VOLUTE_ASSIGN(auto opened, FortranFile::open(entry.file));
  FdsParticleFile particles(std::move(opened));
  const auto classes = static_cast<std::int64_t>(entry.classes.size());
  VOLUTE_ASSIGN(const std::uint64_t offset, particles.readHeader(classes, classes));
  VOLUTE_TRY(particles.findFrames(offset));
  return particles;
}

Result<FdsParticleFile> FdsParticleFile::openPeople(const std::filesystem::path& path) {
  constexpr std::int64_t kMaxClasses = 1000;
  VOLUTE_ASSIGN(auto opened, FortranFile::open(path));
  FdsParticleFile people(std::move(opened));
  people.floats_ = 7;
  VOLUTE_ASSIGN(const std::uint64_t offset, people.readHeader(1, kMaxClasses));
  VOLUTE_TRY(people.findFrames(offset));
  return people;
}

/// Finds the frames behind a header.
Status FdsParticleFile::findFrames(std::uint64_t offset) {
  const auto countAll = [&](std::uint64_t& place, std::size_t frame) -> Result<std::uint64_t> {
    std::uint64_t all = 0;
    for (std::size_t one = 0; one < classes(); ++one) {
      std::uint64_t count = 0;
      VOLUTE_TRY(readClass(place, one, frame, nullptr, count));
      all += count;
    }
    return all;
  };
  VOLUTE_TRY(scanFrames(file_, offset, frames_,
                        [&](std::uint64_t& place, std::size_t frame) -> Result<double> {
                          VOLUTE_ASSIGN(const double time, readTime(file_, place, frame));
                          VOLUTE_TRY(countAll(place, frame));
                          return time;
                        }));
  for (std::size_t frame = 0; frame < frames_.times.size(); ++frame) {
    std::uint64_t place = frames_.offsets[frame];
    VOLUTE_TRY(readTime(file_, place, frame));
    VOLUTE_ASSIGN(const std::uint64_t all, countAll(place, frame));
    counts_.push_back(all);
  }
  return {};
}

Result<std::uint64_t> FdsParticleFile::readHeader(std::int64_t least, std::int64_t most) {
  std::uint64_t offset = 0;
  VOLUTE_TRY(readCount(file_, offset, "the header's first word", 1, 1));
  VOLUTE_TRY(readCount(file_, offset, "the version of FDS", 0, 1 << 30));
  VOLUTE_ASSIGN(const int number, readCount(file_, offset, "the number of classes", least, most));
  for (int one = 0; one < number; ++one) {
    std::array<std::int32_t, 2> sizes{};
    const std::uint64_t begin = offset;
    VOLUTE_ASSIGN(offset, file_.readInto(offset, std::span(sizes), "the quantities of a class"));
    if (sizes[0] < 0 || sizes[0] > kMaxQuantities) {
      return fail(ErrorCode::kInvalidData,
                  "{}: byte {}: class {} has {} quantities: the file is damaged",
                  file_.path().string(), begin + 4, one + 1, sizes[0]);
    }
    std::vector<FdsLabels>& quantities = quantities_.emplace_back();
    for (int i = 0; i < sizes[0]; ++i) {
      FdsLabels& labels = quantities.emplace_back();
      for (std::string* into : {&labels.quantity, &labels.unit}) {
        std::array<char, kFdsLabel> text{};
        VOLUTE_ASSIGN(offset, file_.readInto(offset, std::span(text), "a quantity"));
        *into = trimmed(std::string_view(text.data(), text.size()));
      }
    }
  }
  return offset;
}

Status FdsParticleFile::readClass(std::uint64_t& offset, std::size_t one, std::size_t frame,
                                  FdsParticles* into, std::uint64_t& count) const {
  const std::string what = frameName("particles", frame);
  constexpr std::int64_t kMax = (std::int64_t{1} << 31) - 1;
  VOLUTE_ASSIGN(const int number,
                readCount(file_, offset, frameName("number of particles", frame), 0, kMax));
  count = static_cast<std::uint64_t>(number);
  const std::uint64_t quantities = quantities_[one].size();
  if (count == 0) {
    // Empty records follow, or none.
    for (int record = 0; record < (quantities > 0 ? 3 : 2); ++record) {
      const Result<std::uint64_t> next =
          offset < file_.size() ? file_.skip(offset, 0, what) : offset;
      if (!next && next.error().code == ErrorCode::kTruncated)
        return tl::unexpected<Error>(next.error());
      if (!next || *next == offset)
        break;
      offset = *next;
    }
    return {};
  }
  if (into == nullptr) {
    VOLUTE_ASSIGN(offset, file_.skip(offset, 4 * floats_ * count, what));
  } else {
    std::vector<float> places(floats_ * count);  // all x, all y, all z
    VOLUTE_ASSIGN(offset, file_.readInto(offset, std::span(places), what));
    into->places.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      into->places[i] = {places[i], places[count + i], places[2 * count + i]};
      for (const float place : into->places[i]) {
        if (!std::isfinite(place)) {
          return fail(ErrorCode::kInvalidData,
                      "{}: frame {} (t = {} s): a particle is at {} m: the file is damaged",
                      file_.path().string(), frame, frames_.times[frame], place);
        }
      }
    }
  }
  const std::string numbers = frameName("numbers of particles", frame);
  if (into != nullptr && floats_ > 3) {
    into->numbers.resize(count);
    VOLUTE_ASSIGN(offset, file_.readInto(offset, std::span(into->numbers), numbers));
  } else {
    VOLUTE_ASSIGN(offset, file_.skip(offset, 4 * count, numbers));
  }
  if (quantities == 0)
    return {};
  if (into == nullptr) {
    VOLUTE_ASSIGN(offset, file_.skip(offset, 4 * quantities * count, frameName("values", frame)));
    return {};
  }
  std::vector<float> values(quantities * count);
  VOLUTE_ASSIGN(offset, file_.readInto(offset, std::span(values), frameName("values", frame)));
  for (std::uint64_t i = 0; i < quantities; ++i) {
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(i * count);
    into->values.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(count));
  }
  return {};
}

Result<std::vector<FdsParticles>> FdsParticleFile::readFrame(std::size_t frame) const {
  std::uint64_t offset = frames_.offsets[frame];
  VOLUTE_TRY(readTime(file_, offset, frame));
  std::vector<FdsParticles> all(classes());
  for (std::size_t one = 0; one < all.size(); ++one) {
    std::uint64_t count = 0;
    VOLUTE_TRY(readClass(offset, one, frame, &all[one], count));
  }
  return all;
}

}  // namespace volute
