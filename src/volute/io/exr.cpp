// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "volute/base/input_file.hpp"
#include "volute/base/output_file.hpp"
#include "volute/io/frame_file.hpp"
#include "volute/io/image_formats.hpp"
#include "volute/io/stored_color.hpp"

namespace volute {

struct FrameAttributes {
  Imf::Header header;
};

namespace {

/// Lets OpenEXR read through our file, which reports short reads.
class ExrInput final : public Imf::IStream {
 public:
  explicit ExrInput(const InputFile& file) : IStream(file.path().c_str()), file_(file) {}

  bool read(char to[], int count) override {
    const auto bytes = std::as_writable_bytes(std::span(to, static_cast<std::size_t>(count)));
    if (auto status = file_.read(at_, bytes); !status)
      throw std::runtime_error("the file ends too early");
    at_ += static_cast<std::uint64_t>(count);
    return at_ < file_.size();
  }

  std::uint64_t tellg() override { return at_; }

  void seekg(std::uint64_t at) override { at_ = at; }

 private:
  const InputFile& file_;
  std::uint64_t at_ = 0;
};

/// Collects the file in memory: OpenEXR writes its table of lines last, from a destructor that
/// cannot report errors.
class ExrOutput final : public Imf::OStream {
 public:
  ExrOutput() : OStream("picture") {}

  void write(const char from[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (bytes.size() < at_ + size)
      bytes.resize(at_ + size);
    std::memcpy(&bytes[at_], from, size);
    at_ += size;
  }

  std::uint64_t tellp() override { return at_; }

  void seekp(std::uint64_t at) override { at_ = at; }

  std::vector<std::byte> bytes;

 private:
  std::uint64_t at_ = 0;
};

/// The channels to read: R, G, B; or Y; or the only one that there is.
Result<std::vector<std::string>> chooseChannels(const Imf::ChannelList& list,
                                                const std::string& where) {
  const auto usable = [](const Imf::Channel* channel) {
    return channel && channel->type != Imf::UINT && channel->xSampling == 1 &&
           channel->ySampling == 1;
  };
  std::vector<std::string> names;
  for (auto it = list.begin(); it != list.end(); ++it) names.emplace_back(it.name());
  if (usable(list.findChannel("R")) && usable(list.findChannel("G")) &&
      usable(list.findChannel("B"))) {
    return std::vector<std::string>{"R", "G", "B"};
  }
  const bool chroma = list.findChannel("RY") || list.findChannel("BY");
  if (!chroma && usable(list.findChannel("Y")))
    return std::vector<std::string>{"Y"};
  if (names.size() == 1 && usable(list.findChannel(names[0])))
    return names;
  return fail(ErrorCode::kUnsupported,
              "{}: has the channels {}; expected R, G, B, or Y, as half or float", where,
              fmt::join(names, ", "));
}

/// Pixels of the data window, moved into the display window; 0 where the file has none.
Image toDisplay(const Image& data, const Imath::Box2i& dataWindow, const Imath::Box2i& display) {
  Image image(display.max.x - display.min.x + 1, display.max.y - display.min.y + 1, data.channels);
  const int left = std::max(dataWindow.min.x, display.min.x),
            right = std::min(dataWindow.max.x, display.max.x);
  const int top = std::max(dataWindow.min.y, display.min.y),
            bottom = std::min(dataWindow.max.y, display.max.y);
  for (int y = top; y <= bottom && left <= right; ++y) {
    const float* from =
        &data.pixels[(std::size_t(y - dataWindow.min.y) * data.width + (left - dataWindow.min.x)) *
                     data.channels];
    std::copy_n(from, std::size_t(right - left + 1) * data.channels,
                &image.at(left - display.min.x, y - display.min.y));
  }
  return image;
}

Result<Image> readChannels(const InputFile& file, Imf::InputPart& exr,
                           const std::vector<std::string>& channels,
                           const ImageReadOptions& options) {
  const auto& header = exr.header();
  const Imath::Box2i window = header.dataWindow(), display = header.displayWindow();
  const int count = static_cast<int>(channels.size());
  for (const auto& box : {window, display}) {
    VOLUTE_TRY(checkImageSize(file.path(), std::int64_t{box.max.x} - box.min.x + 1,
                              std::int64_t{box.max.y} - box.min.y + 1, count, options.maxMemory));
  }
  if (!exr.isComplete())
    return fail(ErrorCode::kTruncated, "{}: some lines of the picture are missing",
                file.path().string());
  Image image(window.max.x - window.min.x + 1, window.max.y - window.min.y + 1, count);
  Imf::FrameBuffer buffer;
  for (int c = 0; c < count; ++c) {
    buffer.insert(channels[c],
                  Imf::Slice::Make(Imf::FLOAT, image.pixels.data() + c, window,
                                   sizeof(float) * count, sizeof(float) * count * image.width));
  }
  exr.setFrameBuffer(buffer);
  exr.readPixels(window.min.y, window.max.y);
  return window == display ? image : toDisplay(image, window, display);
}

/// From the primaries that a picture states, ACES's for one, to those of sRGB; none: the same.
/// kInvalidData in half a sentence.
Result<std::optional<Mat3>> srgbFrom(const Imf::Header& header) {
  if (!Imf::hasChromaticities(header))
    return std::nullopt;
  const Imf::Chromaticities& its = Imf::chromaticities(header);
  std::array<double, 8> places{};
  std::size_t i = 0;
  for (const auto& place : {its.white, its.red, its.green, its.blue})
    places[i++] = place.x, places[i++] = place.y;
  return srgbFromPrimaries(places);
}

Result<Image> readPixels(const InputFile& file, Imf::InputPart& exr,
                         const ImageReadOptions& options) {
  VOLUTE_ASSIGN(const auto channels, chooseChannels(exr.header().channels(), file.path().string()));
  VOLUTE_ASSIGN(auto image, readChannels(file, exr, channels, options));
  if (channels.size() == 3) {
    const auto toSrgb = srgbFrom(exr.header());
    if (!toSrgb)
      return fail(toSrgb.error().code, "{}: {}", file.path().string(), toSrgb.error().message);
    if (*toSrgb)
      // NOLINTNEXTLINE(bugprone-unchecked-optional-access): asked for above
      transformColors(**toSrgb, image);
  }
  return image;
}

Result<std::optional<Image>> readAlphaChannel(const InputFile& file, Imf::InputPart& exr,
                                              const ImageReadOptions& options) {
  const Imf::Channel* alpha = exr.header().channels().findChannel("A");
  if (!alpha || alpha->type == Imf::UINT || alpha->xSampling != 1 || alpha->ySampling != 1)
    return std::optional<Image>();
  VOLUTE_ASSIGN(auto image, readChannels(file, exr, {"A"}, options));
  return std::optional<Image>(std::move(image));
}

/// Opens a picture and lets `read` read of it; OpenEXR's exceptions become errors.
template <class Read>
auto readWith(const std::filesystem::path& path, const ImageReadOptions& options, Read&& read)
    -> decltype(read(std::declval<const InputFile&>(), std::declval<Imf::MultiPartInputFile&>(),
                     options)) {
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  constexpr int kLongestSide = 1 << 20;
  Imf::Header::setMaxImageSize(kLongestSide, kLongestSide);
  try {
    ExrInput stream(file);
    Imf::MultiPartInputFile exr(stream);
    return read(file, exr, options);
  } catch (const std::exception& error) {
    return fail(ErrorCode::kInvalidData, "{}: not a whole OpenEXR picture: {}", path.string(),
                error.what());
  }
}

PixelWindow windowOf(const Imath::Box2i& box) {
  return {box.min.x, box.min.y, box.max.x + 1, box.max.y + 1};
}

Imath::Box2i boxOf(const PixelWindow& window) {
  return {{window.left, window.top}, {window.right - 1, window.bottom - 1}};
}

/// "depth.Z" of a part "depth" is that, "Z" of it too.
std::string nameIn(const std::string& part, const std::string& channel) {
  return part.empty() || channel.starts_with(part + ".") ? channel : part + "." + channel;
}

Result<FrameInfo> infoOf(const InputFile& file, Imf::MultiPartInputFile& exr,
                         const ImageReadOptions&) {
  FrameInfo info;
  for (int part = 0; part < exr.parts(); ++part) {
    const Imf::Header& header = exr.header(part);
    if (header.hasType() && Imf::isDeepData(header.type())) {
      return fail(ErrorCode::kUnsupported,
                  "{}: a deep picture, with several depths a pixel; expected a flat one, and for "
                  "soft edges a depth of several times its size",
                  file.path().string());
    }
    info.parts.push_back({windowOf(header.dataWindow()), windowOf(header.displayWindow()),
                          header.pixelAspectRatio(),
                          std::make_shared<const FrameAttributes>(FrameAttributes{header})});
    if (const auto* text = header.findTypedAttribute<Imf::StringAttribute>("Software"))
      info.software = text->value();
    if (header.find("BlenderMultiChannel") != header.end())
      info.software = "Blender";
    const std::string name = exr.parts() > 1 && header.hasName() ? header.name() : "";
    const bool chroma = header.channels().findChannel("RY") || header.channels().findChannel("BY");
    for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
      const Imf::Channel& channel = it.channel();
      const bool luma = chroma && std::string_view(it.name()) == "Y";  // without its colours
      if (channel.type != Imf::UINT && channel.xSampling == 1 && channel.ySampling == 1 && !luma)
        info.channels.push_back({nameIn(name, it.name()), it.name(), part});
    }
  }
  return info;
}

/// The part of a file with one picture. Of several parts nobody says which one is meant.
Result<Imf::InputPart> onlyPart(const InputFile& file, Imf::MultiPartInputFile& exr) {
  if (exr.parts() == 1)
    return Imf::InputPart(exr, 0);
  VOLUTE_ASSIGN(const auto info, infoOf(file, exr, {}));
  std::string names;
  for (const FrameChannel& channel : info.channels)
    names += (names.empty() ? "" : ", ") + channel.name;
  return fail(ErrorCode::kUnsupported,
              "{}: has {} parts with the channels {}; expected one part: take it out (exrmultipart "
              "-separate)",
              file.path().string(), exr.parts(), names);
}

Result<Image> readPart(const InputFile& file, Imf::MultiPartInputFile& exr,
                       std::span<const FrameChannel> channels, std::uint64_t maxMemory) {
  const int number = channels.front().part, count = static_cast<int>(channels.size());
  const Imath::Box2i window = exr.header(number).dataWindow();
  VOLUTE_TRY(checkImageSize(file.path(), std::int64_t{window.max.x} - window.min.x + 1,
                            std::int64_t{window.max.y} - window.min.y + 1, count, maxMemory));
  if (!exr.partComplete(number))
    return fail(ErrorCode::kTruncated, "{}: some lines of the picture are missing",
                file.path().string());
  Image image(window.max.x - window.min.x + 1, window.max.y - window.min.y + 1, count);
  Imf::FrameBuffer buffer;
  for (int c = 0; c < count; ++c) {
    buffer.insert(channels[static_cast<std::size_t>(c)].own,
                  Imf::Slice::Make(Imf::FLOAT, image.pixels.data() + c, window,
                                   sizeof(float) * count, sizeof(float) * count * image.width));
  }
  Imf::InputPart part(exr, number);
  part.setFrameBuffer(buffer);
  part.readPixels(window.min.y, window.max.y);
  return image;
}

/// Of a frame with other channels: all that still holds.
Imf::Header headerFor(const FramePart& part) {
  constexpr std::string_view kGone[] = {"tiles",
                                        "type",
                                        "name",
                                        "version",
                                        "chunkCount",
                                        "maxSamplesPerPixel",
                                        "preview",
                                        "view",
                                        "multiView",
                                        "BlenderMultiChannel",
                                        "dwaCompressionLevel"};
  Imf::Header header;
  if (part.attributes) {  // OpenEXR 3.1's Header::erase() does not free what it erases
    const Imf::Header& from = part.attributes->header;
    for (auto it = from.begin(); it != from.end(); ++it) {
      const std::string_view name = it.name();
      if (std::ranges::find(kGone, name) == std::end(kGone) && !name.starts_with("cryptomatte/"))
        header.insert(it.name(), it.attribute());
    }
  }
  header.channels() = Imf::ChannelList();
  header.compression() = Imf::ZIP_COMPRESSION;
  header.lineOrder() = Imf::INCREASING_Y;
  header.dataWindow() = boxOf(part.data);
  header.displayWindow() = boxOf(part.display);
  header.pixelAspectRatio() = static_cast<float>(part.pixelAspect);
  return header;
}

/// Finite values stay finite.
std::vector<half> halvesOf(std::span<const float> values, int first, int step) {
  constexpr float kLargest = HALF_MAX;
  std::vector<half> halves;
  halves.reserve(values.size() / static_cast<std::size_t>(step));
  for (auto i = static_cast<std::size_t>(first); i < values.size();
       i += static_cast<std::size_t>(step)) {
    const float value = values[i];
    halves.emplace_back(std::isfinite(value) ? std::clamp(value, -kLargest, kLargest) : value);
  }
  return halves;
}

/// Writes what `add` lays out.
template <class Add>
Status encode(const std::filesystem::path& path, Imf::Header header, Add&& add) {
  ExrOutput stream;
  try {
    Imf::FrameBuffer buffer;
    add(header, buffer);
    Imf::OutputFile exr(stream, header);
    exr.setFrameBuffer(buffer);
    const Imath::Box2i window = header.dataWindow();
    exr.writePixels(window.max.y - window.min.y + 1);
  } catch (const std::exception& error) {
    return fail(ErrorCode::kIo, "{}: cannot encode the picture: {}", path.string(), error.what());
  }
  VOLUTE_ASSIGN(auto file, OutputFile::create(path));
  VOLUTE_TRY(file.write(stream.bytes));
  return file.commit();
}

}  // namespace

Result<Image> readExr(const std::filesystem::path& path, const ImageReadOptions& options) {
  return readWith(path, options, [](const auto& file, auto& exr, const auto& how) -> Result<Image> {
    VOLUTE_ASSIGN(auto part, onlyPart(file, exr));
    return readPixels(file, part, how);
  });
}

Result<std::optional<Image>> readExrAlpha(const std::filesystem::path& path,
                                          const ImageReadOptions& options) {
  return readWith(path, options,
                  [](const auto& file, auto& exr, const auto& how) -> Result<std::optional<Image>> {
                    VOLUTE_ASSIGN(auto part, onlyPart(file, exr));
                    return readAlphaChannel(file, part, how);
                  });
}

Result<FrameInfo> readFrameInfo(const std::filesystem::path& path) {
  return readWith(path, {}, infoOf);
}

Result<std::optional<Mat3>> srgbFromPrimaries(const FramePart& part) {
  return part.attributes ? srgbFrom(part.attributes->header) : std::nullopt;
}

Result<Image> readFrameChannels(const std::filesystem::path& path,
                                std::span<const FrameChannel> channels, std::uint64_t maxMemory) {
  return readWith(
      path, {}, [&](const InputFile& file, Imf::MultiPartInputFile& exr, const ImageReadOptions&) {
        return readPart(file, exr, channels, maxMemory);
      });
}

Status writeFrame(const std::filesystem::path& path, const FramePixels& pixels) {
  VOLUTE_ASSIGN(const auto toSrgb, srgbFromPrimaries(pixels.part));
  Image own;
  if (toSrgb) {
    own = pixels.color;
    transformColors(toSrgb->inverse(), own);
  }
  std::vector<std::vector<half>> halves;
  return encode(path, headerFor(pixels.part), [&](Imf::Header& header, Imf::FrameBuffer& buffer) {
    const auto add = [&](const char* name, const Image& image, int channel) {
      const Imf::PixelType type = pixels.half ? Imf::HALF : Imf::FLOAT;
      const void* base = image.pixels.data() + channel;
      std::size_t step = sizeof(float) * static_cast<std::size_t>(image.channels);
      if (pixels.half) {
        base = halves.emplace_back(halvesOf(image.pixels, channel, image.channels)).data();
        step = sizeof(half);
      }
      header.channels().insert(name, Imf::Channel(type));
      buffer.insert(name, Imf::Slice::Make(type, base, boxOf(pixels.part.data), step,
                                           step * static_cast<std::size_t>(image.width)));
    };
    for (int c = 0; c < 3; ++c) add(&"R\0G\0B"[2 * c], toSrgb ? own : pixels.color, c);
    if (pixels.alpha)
      add("A", *pixels.alpha, 0);
  });
}

namespace {

/// @param rounds  whether a channel is written as half floats
Status encodeChannels(const std::filesystem::path& path, int width, int height,
                      const std::vector<ImageChannel>& channels, const ImageNotes& notes,
                      bool (*rounds)(const std::string& name)) {
  std::vector<std::vector<half>> halves;
  return encode(
      path, Imf::Header(width, height), [&](Imf::Header& header, Imf::FrameBuffer& buffer) {
        header.compression() = Imf::ZIP_COMPRESSION;
        const bool colors = std::ranges::find(channels, "R", &ImageChannel::name) != channels.end();
        if (colors)
          Imf::addChromaticities(header, Imf::Chromaticities());  // Rec. 709's, D65
        for (const auto& [name, text] : notes) header.insert(name, Imf::StringAttribute(text));
        for (const ImageChannel& channel : channels) {
          const bool rounded = rounds(channel.name);
          const Imf::PixelType type = rounded ? Imf::HALF : Imf::FLOAT;
          const std::size_t step = rounded ? sizeof(half) : sizeof(float);
          const void* base = channel.values.data();
          if (rounded)
            base = halves.emplace_back(halvesOf(channel.values, 0, 1)).data();
          header.channels().insert(channel.name, Imf::Channel(type));
          buffer.insert(channel.name, Imf::Slice(type, static_cast<char*>(const_cast<void*>(base)),
                                                 step, step * static_cast<std::size_t>(width)));
        }
      });
}

}  // namespace

Status writeChannels(const std::filesystem::path& path, int width, int height,
                     const std::vector<ImageChannel>& channels, const ImageNotes& notes) {
  return encodeChannels(path, width, height, channels, notes,
                        [](const std::string&) { return false; });
}

Status writeHalfChannels(const std::filesystem::path& path, int width, int height,
                         const std::vector<ImageChannel>& channels, const ImageNotes& notes) {
  return encodeChannels(path, width, height, channels, notes, [](const std::string& name) {
    return name.size() == 1 && std::string_view("RGBAY").find(name[0]) != std::string_view::npos;
  });
}

std::vector<ImageChannel> channelsOf(const Image& image) {
  const char* const names[] = {"R", "G", "B"};
  std::vector<ImageChannel> channels;
  const auto count = static_cast<std::size_t>(image.channels);
  for (std::size_t c = 0; c < count; ++c) {
    ImageChannel& channel =
        channels.emplace_back(ImageChannel{image.channels == 1 ? "Y" : names[c], {}});
    for (std::size_t i = c; i < image.pixels.size(); i += count)
      channel.values.push_back(image.pixels[i]);
  }
  return channels;
}

Status writeExr(const std::filesystem::path& path, const Image& image, const ImageNotes& notes) {
  return writeChannels(path, image.width, image.height, channelsOf(image), notes);
}

}  // namespace volute
