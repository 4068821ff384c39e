// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "volute/base/input_file.hpp"
#include "volute/base/output_file.hpp"
#include "volute/io/image_formats.hpp"

namespace volute {
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

Result<Image> readChannels(const InputFile& file, Imf::InputFile& exr,
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

Result<Image> readPixels(const InputFile& file, Imf::InputFile& exr,
                         const ImageReadOptions& options) {
  VOLUTE_ASSIGN(const auto channels, chooseChannels(exr.header().channels(), file.path().string()));
  return readChannels(file, exr, channels, options);
}

Result<std::optional<Image>> readAlphaChannel(const InputFile& file, Imf::InputFile& exr,
                                              const ImageReadOptions& options) {
  const Imf::Channel* alpha = exr.header().channels().findChannel("A");
  if (!alpha || alpha->type == Imf::UINT || alpha->xSampling != 1 || alpha->ySampling != 1)
    return std::optional<Image>();
  VOLUTE_ASSIGN(auto image, readChannels(file, exr, {"A"}, options));
  return std::optional<Image>(std::move(image));
}

Result<ImageNotes> readNotes(const InputFile&, Imf::InputFile& exr, const ImageReadOptions&) {
  ImageNotes notes;
  for (auto it = exr.header().begin(); it != exr.header().end(); ++it) {
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute()))
      notes.emplace_back(it.name(), text->value());
  }
  return notes;
}

/// Opens a picture and lets `read` read of it; OpenEXR's exceptions become errors.
template <class Read>
auto readWith(const std::filesystem::path& path, const ImageReadOptions& options, Read&& read)
    -> decltype(read(std::declval<const InputFile&>(), std::declval<Imf::InputFile&>(), options)) {
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  constexpr int kLongestSide = 1 << 20;
  Imf::Header::setMaxImageSize(kLongestSide, kLongestSide);
  try {
    ExrInput stream(file);
    Imf::InputFile exr(stream);
    return read(file, exr, options);
  } catch (const std::exception& error) {
    return fail(ErrorCode::kInvalidData, "{}: not a whole OpenEXR picture: {}", path.string(),
                error.what());
  }
}

}  // namespace

Result<Image> readExr(const std::filesystem::path& path, const ImageReadOptions& options) {
  return readWith(path, options, readPixels);
}

Result<std::optional<Image>> readExrAlpha(const std::filesystem::path& path,
                                          const ImageReadOptions& options) {
  return readWith(path, options, readAlphaChannel);
}

Result<ImageNotes> readExrNotes(const std::filesystem::path& path) {
  return readWith(path, {}, readNotes);
}

Status writeChannels(const std::filesystem::path& path, int width, int height,
                     const std::vector<ImageChannel>& channels, const ImageNotes& notes) {
  ExrOutput stream;
  try {
    Imf::Header header(width, height);
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const auto& [name, text] : notes) header.insert(name, Imf::StringAttribute(text));
    Imf::FrameBuffer buffer;
    for (const ImageChannel& channel : channels) {
      header.channels().insert(channel.name, Imf::Channel(Imf::FLOAT));
      char* base = reinterpret_cast<char*>(const_cast<float*>(channel.values.data()));
      buffer.insert(channel.name, Imf::Slice(Imf::FLOAT, base, sizeof(float),
                                             sizeof(float) * static_cast<std::size_t>(width)));
    }
    Imf::OutputFile exr(stream, header);
    exr.setFrameBuffer(buffer);
    exr.writePixels(height);
  } catch (const std::exception& error) {
    return fail(ErrorCode::kIo, "{}: cannot encode the picture: {}", path.string(), error.what());
  }
  VOLUTE_ASSIGN(auto file, OutputFile::create(path));
  VOLUTE_TRY(file.write(stream.bytes));
  return file.commit();
}

Status writeExr(const std::filesystem::path& path, const Image& image, const ImageNotes& notes) {
  const char* const names[] = {"R", "G", "B"};
  std::vector<ImageChannel> channels;
  const auto count = static_cast<std::size_t>(image.channels);
  for (std::size_t c = 0; c < count; ++c) {
    ImageChannel& channel =
        channels.emplace_back(ImageChannel{image.channels == 1 ? "Y" : names[c], {}});
    for (std::size_t i = c; i < image.pixels.size(); i += count)
      channel.values.push_back(image.pixels[i]);
  }
  return writeChannels(path, image.width, image.height, channels, notes);
}

}  // namespace volute
