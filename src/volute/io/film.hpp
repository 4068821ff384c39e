// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/image/image.hpp"

namespace volute {

/// How a film is encoded.
struct FilmStyle {
  /// 8 or 10 bits a channel. Of the dithering of 8 bits encoders drop a part, so that dark
  /// gradients have weak bands; 10 bits have four times as many levels, and not every player shows
  /// them.
  int bits = 8;
  /// Constant rate factor of the encoder, 0 (best, large) to 51; nothing: 16 for .mp4, 20 for
  /// .webm.
  std::optional<double> rateFactor{};
};

/// Writes a film: H.264 into .mp4, VP9 into .webm, both 4:2:0 with BT.709 colours and a constant
/// quality. The same frames give the same bytes in every run and on any number of cores.
class FilmWriter {
 public:
  /// @param width, height  [pixels] of every frame; odd sizes are padded by one row or column.
  /// @param framesPerSecond  > 0.
  /// @param comment  what the film says about itself; empty: nothing.
  [[nodiscard]] static Result<std::unique_ptr<FilmWriter>> create(const std::filesystem::path& path,
                                                                  int width, int height,
                                                                  double framesPerSecond,
                                                                  const std::string& comment = {},
                                                                  const FilmStyle& style = {});

  virtual ~FilmWriter() = default;

  /// Appends linear RGB, or grey with one channel, encoded as sRGB and clamped to 0..1, with
  /// dithering to the film's bits.
  [[nodiscard]] virtual Status addFrame(const Image& linear) = 0;

  /// After the last frame; without it no file appears.
  [[nodiscard]] virtual Status finish() = 0;
};

/// Size and rate of a film.
struct FilmInfo {
  int width = 0;   ///< [pixels]
  int height = 0;  ///< [pixels]
  double framesPerSecond = 0;
  bool interlaced = false;  ///< its frames are two fields, of two times
  int otherStreams = 0;     ///< of video, besides the one that is read
  int turned = 0;  ///< its pictures are stored otherwise than they are to be shown, and were
                   ///< turned clockwise by so many degrees
  double pixelAspect = 1;  ///< width of a pixel / its height, after turning
};

/// Decodes one film with libav; what a plug-in offers to FilmReader, which runs it in a child
/// process.
class FilmDecoder {
 public:
  virtual ~FilmDecoder() = default;
  [[nodiscard]] virtual Result<FilmInfo> open(const std::filesystem::path& path) = 0;
  /// Linear RGB, shape (height, width, 3); false after the last frame.
  [[nodiscard]] virtual Result<bool> next(std::span<float> pixels) = 0;
  /// Passes over at most `count` coded pictures: when each is shown [s], in the order in which they
  /// are stored; NaN where the film does not say. Fewer after the last.
  [[nodiscard]] virtual Result<std::vector<double>> skip(int count) = 0;
};

/// Reads a film frame by frame, each as linear RGB. The decoder runs in a child process with
/// limits, so a damaged film is an error at worst.
class FilmReader {
 public:
  /// @param maxMemory  [bytes] that decoding may take.
  [[nodiscard]] static Result<FilmReader> open(const std::filesystem::path& path,
                                               std::uint64_t maxMemory = std::uint64_t{1} << 30);

  ~FilmReader();
  FilmReader(FilmReader&&) noexcept;
  FilmReader& operator=(FilmReader&&) noexcept;

  const FilmInfo& info() const;

  /// The next frame; nothing after the last.
  [[nodiscard]] Result<std::optional<Image>> next();

  /// When the frames that follow are shown [s], ascending, without decoding them: what the file
  /// says of its coded pictures, so that a damaged one counts too. NaN, all of them, where it does
  /// not say that of each. Nothing can be read after it.
  /// @param enough  no more are looked for
  [[nodiscard]] Result<std::vector<double>> restOfTimes(int enough);

 private:
  struct Impl;
  explicit FilmReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Functions of the plug-in for films.
struct FilmPlugin {
  Result<std::unique_ptr<FilmWriter>> (*makeWriter)(const std::filesystem::path& path, int width,
                                                    int height, double framesPerSecond,
                                                    const std::string& comment,
                                                    const FilmStyle& style);
  std::unique_ptr<FilmDecoder> (*makeDecoder)();
};

}  // namespace volute
