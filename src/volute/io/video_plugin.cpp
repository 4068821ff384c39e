// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "volute/base/file_name.hpp"
#include "volute/base/output_file.hpp"
#include "volute/base/parallel.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/film.hpp"
#include "volute/io/stored_color.hpp"

namespace volute {
namespace {

template <auto kFree>
struct Freed {
  template <class T>
  void operator()(T* object) const {
    kFree(&object);
  }
};

void freeScaler(SwsContext** scaler) {
  sws_freeContext(*scaler);
}

void closeOutput(AVFormatContext** context) {
  if ((*context)->pb)
    avio_closep(&(*context)->pb);
  avformat_free_context(*context);
}

using OutputPtr = std::unique_ptr<AVFormatContext, Freed<closeOutput>>;
using InputPtr = std::unique_ptr<AVFormatContext, Freed<avformat_close_input>>;
using CodecPtr = std::unique_ptr<AVCodecContext, Freed<avcodec_free_context>>;
using FramePtr = std::unique_ptr<AVFrame, Freed<av_frame_free>>;
using PacketPtr = std::unique_ptr<AVPacket, Freed<av_packet_free>>;
using ScalerPtr = std::unique_ptr<SwsContext, Freed<freeScaler>>;

std::string reason(int code) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(code, text, sizeof text);
  return text;
}

constexpr int kExact =
    SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP | SWS_BITEXACT;

/// A frame with the slack behind its rows that the scaler reads and writes; all zero. Null without
/// memory.
FramePtr makeFrame(AVPixelFormat format, int width, int height) {
  FramePtr frame(av_frame_alloc());
  if (!frame)
    return nullptr;
  frame->format = format;
  frame->width = width;
  frame->height = height;
  if (av_frame_get_buffer(frame.get(), 0) < 0)
    return nullptr;
  for (int plane = 0; plane < AV_NUM_DATA_POINTERS && frame->buf[plane]; ++plane) {
    std::memset(frame->buf[plane]->data, 0, frame->buf[plane]->size);
  }
  return frame;
}

struct Encoding {
  const char* extension;
  const char* encoder;
  std::vector<std::pair<const char*, const char*>> options;
};

const std::array<Encoding, 2>& encodings() {
  static const std::array<Encoding, 2> kEncodings{
      // Without cpu-independent x264 lets memory that it never wrote decide about some bits;
      // aq-mode 3 spends more of them on dark gradients, and of less strength it drops the grain of
      // pictures from which no others are predicted: of short films, cuts, fades.
      {{".mp4",
        "libx264",
        {{"crf", "16"},
         {"preset", "medium"},
         {"x264-params", "cpu-independent=1:aq-mode=3:aq-strength=1.5"}}},
       {".webm",
        "libvpx-vp9",
        {{"crf", "20"}, {"deadline", "good"}, {"cpu-used", "4"}, {"row-mt", "1"}}}}};
  return kEncodings;
}

/// sRGB's values, 0 to 1, from a table; within a hundredth of a step of 16 bits.
class StoredValue {
 public:
  StoredValue() : table_(kSteps + 2) {
    for (std::size_t i = 0; i < table_.size(); ++i)
      table_[i] = static_cast<float>(srgbEncode(static_cast<double>(i) / kSteps));
  }

  float operator()(float linear) const {
    if (!(linear > 0))
      return 0;
    const float place = std::min(linear, 1.0F) * kSteps;
    const auto first = static_cast<std::size_t>(place);
    const float share = place - static_cast<float>(first);
    return table_[first] + share * (table_[first + 1] - table_[first]);
  }

 private:
  static constexpr int kSteps = 1 << 16;

  std::vector<float> table_;
};

/// Turns linear pictures into what a codec stores: Y'CbCr of BT.709 in video range, chroma halved
/// both ways and sited left. Rounding adds grain by a fixed pattern (R2 of Martin Roberts), so that
/// gradients have no bands. One level of it would drown in a codec's quantisation; of 2.5 levels of
/// 8 bits (3 where 10 bits are stored) enough survives the usual rate factors. Black and white stay
/// what they are.
class StoredPicture {
 public:
  explicit StoredPicture(int bits)
      : unit_(static_cast<float>(1 << (bits - 8))), grain_((bits > 8 ? 3 : 2.5F) * unit_) {}

  /// @param frame  of 8 bits, or 16-bit words; its size is the picture's or one larger: the last
  ///               column and row are repeated
  void fill(const Image& linear, AVFrame& frame) const {
    const auto pairs = static_cast<std::size_t>(frame.height / 2);
    parallelRanges(pairs, 8, [&](std::size_t begin, std::size_t end) {
      if (unit_ > 1)
        fillRows<std::uint16_t>(linear, frame, static_cast<int>(begin), static_cast<int>(end));
      else
        fillRows<std::uint8_t>(linear, frame, static_cast<int>(begin), static_cast<int>(end));
    });
  }

 private:
  static constexpr float kRed = 0.2126F, kBlue = 0.0722F;

  /// Of a place in a plane: 0 to 1.
  static float threshold(int x, int y, int plane) {
    constexpr std::uint32_t kRight = 3242174889, kDown = 2447445414, kPlane = 1431655765;
    const std::uint32_t turn = kRight * static_cast<std::uint32_t>(x) +
                               kDown * static_cast<std::uint32_t>(y) +
                               kPlane * static_cast<std::uint32_t>(plane);
    return static_cast<float>(turn >> 8) * 0x1p-24F;
  }

  /// @param value  >= 2
  /// @param grain  levels that a value is spread over; 1: those beside it, by its distance to both
  static int level(float value, float grain, int x, int y, int plane) {
    constexpr float kRounding = 1e-3F;  // must not push what is a level to its neighbour
    const float shift = (threshold(x, y, plane) - 0.5F) * (1 - 2 * kRounding);
    // NOLINTNEXTLINE(bugprone-incorrect-roundings): value >= 2
    return static_cast<int>(value + grain * shift + 0.5F);
  }

  template <class Word>
  void fillRows(const Image& linear, AVFrame& frame, int begin, int end) const {
    const int width = frame.width;
    std::vector<float> blue(static_cast<std::size_t>(width)), red(blue.size());
    for (int pair = begin; pair < end; ++pair) {
      std::ranges::fill(blue, 0.0F);
      std::ranges::fill(red, 0.0F);
      for (int y = 2 * pair; y < 2 * pair + 2; ++y)
        fillRow(linear, y, rowOf<Word>(frame, 0, y), blue, red);
      halve(blue, rowOf<Word>(frame, 1, pair), pair, 1);
      halve(red, rowOf<Word>(frame, 2, pair), pair, 2);
    }
  }

  template <class Word>
  static std::span<Word> rowOf(AVFrame& frame, int plane, int y) {
    const int count = plane == 0 ? frame.width : frame.width / 2;
    return {reinterpret_cast<Word*>(frame.data[plane] + std::ptrdiff_t{y} * frame.linesize[plane]),
            static_cast<std::size_t>(count)};
  }

  /// Adds half of the row's differences to `blue` and `red`.
  template <class Word>
  void fillRow(const Image& linear, int y, std::span<Word> to, std::span<float> blue,
               std::span<float> red) const {
    const auto channels = static_cast<std::size_t>(linear.channels);
    const std::size_t width = static_cast<std::size_t>(linear.width);
    const float* from =
        &linear.pixels[static_cast<std::size_t>(std::min(y, linear.height - 1)) * width * channels];
    const float black = 16 * unit_, range = 219 * unit_;
    for (std::size_t x = 0; x < to.size(); ++x) {
      const float* pixel = from + std::min(x, width - 1) * channels;
      const float r = stored_(pixel[0]);
      const float g = channels == 3 ? stored_(pixel[1]) : r;
      const float b = channels == 3 ? stored_(pixel[2]) : r;
      const float light = kRed * r + (1 - kRed - kBlue) * g + kBlue * b;
      blue[x] += (b - light) / (4 * (1 - kBlue));
      red[x] += (r - light) / (4 * (1 - kRed));
      const float room = range * std::min(light, 1 - light);  // to black or white
      const float grain = std::min(grain_, std::max(2 * room, 1.0F));
      const int value = level(black + range * light, grain, static_cast<int>(x), y, 0);
      to[x] = static_cast<Word>(
          std::clamp(value, static_cast<int>(black), static_cast<int>(black + range)));
    }
  }

  template <class Word>
  void halve(std::span<const float> from, std::span<Word> to, int y, int plane) const {
    for (std::size_t x = 0; x < to.size(); ++x) {
      const std::size_t at = 2 * x, before = at > 0 ? at - 1 : 0;
      const float mean = (from[before] + 2 * from[at] + from[at + 1]) / 4;
      to[x] =
          static_cast<Word>(level(unit_ * (128 + 224 * mean), 1, static_cast<int>(x), y, plane));
    }
  }

  float unit_;   ///< levels of one of 8 bits
  float grain_;  ///< of brightness [levels]
  StoredValue stored_;
};

class AvFilmWriter final : public FilmWriter {
 public:
  AvFilmWriter(PendingFile file, int width, int height, const FilmStyle& style)
      : file_(std::move(file)),
        width_(width),
        height_(height),
        style_(style),
        stored_(style.bits > 8 ? 10 : 8) {}

  Status open(const Encoding& encoding, double framesPerSecond, const std::string& comment) {
    const AVCodec* codec = avcodec_find_encoder_by_name(encoding.encoder);
    if (!codec) {
      return fail(ErrorCode::kUnsupported,
                  "{}: libav has no encoder {} here; install one, or write {}", name(),
                  encoding.encoder,
                  encoding.extension == std::string_view(".mp4") ? ".webm" : ".mp4");
    }
    AVFormatContext* output = nullptr;
    const std::string url = "file:" + file_.path().string();
    VOLUTE_TRY(check(avformat_alloc_output_context2(&output, nullptr, nullptr, url.c_str())));
    output_.reset(output);
    output_->flags |= AVFMT_FLAG_BITEXACT;
    if (!comment.empty())
      VOLUTE_TRY(check(av_dict_set(&output->metadata, "comment", comment.c_str(), 0)));
    stream_ = avformat_new_stream(output, nullptr);
    codec_.reset(avcodec_alloc_context3(codec));
    packet_.reset(av_packet_alloc());
    if (!stream_ || !codec_ || !packet_)
      return check(AVERROR(ENOMEM));
    VOLUTE_TRY(openCodec(encoding, codec, framesPerSecond));
    VOLUTE_TRY(check(avio_open(&output_->pb, url.c_str(), AVIO_FLAG_WRITE)));
    AVDictionary* muxing = nullptr;
    av_dict_set(&muxing, "movflags", "+faststart", 0);
    const int written = avformat_write_header(output, &muxing);
    av_dict_free(&muxing);
    VOLUTE_TRY(check(written));
    frame_ = makeFrame(codec_->pix_fmt, codec_->width, codec_->height);
    return check(frame_ ? 0 : AVERROR(ENOMEM));
  }

  Status addFrame(const Image& linear) override {
    if (linear.width != width_ || linear.height != height_) {
      return fail(ErrorCode::kInvalidArgument,
                  "{}: a frame of {} x {} pixels; the film has {} x {}", name(), linear.width,
                  linear.height, width_, height_);
    }
    VOLUTE_TRY(check(av_frame_make_writable(frame_.get())));
    stored_.fill(linear, *frame_);
    frame_->pts = count_++;
    VOLUTE_TRY(check(avcodec_send_frame(codec_.get(), frame_.get())));
    return writePackets();
  }

  Status finish() override {
    if (count_ == 0)
      return fail(ErrorCode::kInvalidArgument, "{}: a film without a frame", name());
    VOLUTE_TRY(check(avcodec_send_frame(codec_.get(), nullptr)));
    VOLUTE_TRY(writePackets());
    VOLUTE_TRY(check(av_write_trailer(output_.get())));
    VOLUTE_TRY(check(output_->pb->error));
    VOLUTE_TRY(check(avio_closep(&output_->pb)));
    return file_.commit();
  }

 private:
  std::string name() const { return file_.target().string(); }

  Status check(int code) const {
    if (code >= 0)
      return {};
    return fail(ErrorCode::kIo, "{}: cannot write the film: {}", name(), reason(code));
  }

  Status openCodec(const Encoding& encoding, const AVCodec* codec, double framesPerSecond) {
    constexpr int kThreads = 4;  // fixed: the bytes depend on it
    constexpr int kLargest = 1001000;
    codec_->width = (width_ + 1) / 2 * 2;
    codec_->height = (height_ + 1) / 2 * 2;
    codec_->framerate = av_d2q(framesPerSecond, kLargest);
    codec_->time_base = av_inv_q(codec_->framerate);
    codec_->pix_fmt = deep() ? AV_PIX_FMT_YUV420P10LE : AV_PIX_FMT_YUV420P;
    if (deep() && encoding.extension == std::string_view(".webm"))
      codec_->profile = FF_PROFILE_VP9_2;
    codec_->bit_rate = 0;
    codec_->thread_count = kThreads;
    codec_->color_range = AVCOL_RANGE_MPEG;
    codec_->colorspace = AVCOL_SPC_BT709;
    codec_->color_primaries = AVCOL_PRI_BT709;
    codec_->color_trc = AVCOL_TRC_IEC61966_2_1;  // sRGB
    codec_->chroma_sample_location = AVCHROMA_LOC_LEFT;
    codec_->flags |= AV_CODEC_FLAG_BITEXACT;
    if (output_->oformat->flags & AVFMT_GLOBALHEADER)
      codec_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    AVDictionary* options = nullptr;
    for (const auto& [key, value] : encoding.options) av_dict_set(&options, key, value, 0);
    if (style_.rateFactor)
      av_dict_set(&options, "crf", fmt::format("{:g}", *style_.rateFactor).c_str(), 0);
    const int opened = avcodec_open2(codec_.get(), codec, &options);
    av_dict_free(&options);
    VOLUTE_TRY(check(opened));
    stream_->time_base = codec_->time_base;
    stream_->avg_frame_rate = codec_->framerate;
    return check(avcodec_parameters_from_context(stream_->codecpar, codec_.get()));
  }

  bool deep() const { return style_.bits > 8; }

  Status writePackets() {
    for (;;) {
      const int received = avcodec_receive_packet(codec_.get(), packet_.get());
      if (received == AVERROR(EAGAIN) || received == AVERROR_EOF)
        return {};
      VOLUTE_TRY(check(received));
      packet_->duration = 1;  // without it the last frame of an MP4 is shown for no time
      av_packet_rescale_ts(packet_.get(), codec_->time_base, stream_->time_base);
      packet_->stream_index = stream_->index;
      VOLUTE_TRY(check(av_interleaved_write_frame(output_.get(), packet_.get())));
    }
  }

  PendingFile file_;
  int width_, height_;
  FilmStyle style_;
  std::int64_t count_ = 0;
  OutputPtr output_;
  AVStream* stream_ = nullptr;
  CodecPtr codec_;
  StoredPicture stored_;
  FramePtr frame_;  // what the caller gave, for the encoder
  PacketPtr packet_;
};

Result<std::unique_ptr<FilmWriter>> makeWriter(const std::filesystem::path& path, int width,
                                               int height, double framesPerSecond,
                                               const std::string& comment, const FilmStyle& style) {
  av_log_set_level(AV_LOG_QUIET);
  for (const auto& encoding : encodings()) {
    if (extensionOf(path) != encoding.extension)
      continue;
    VOLUTE_ASSIGN(auto file, PendingFile::create(path));
    auto writer = std::make_unique<AvFilmWriter>(std::move(file), width, height, style);
    VOLUTE_TRY(writer->open(encoding, framesPerSecond, comment));
    return writer;
  }
  return fail(ErrorCode::kUnsupported, "{}: not a known kind of film; expected .mp4 or .webm",
              path.string());
}

class AvFilmDecoder final : public FilmDecoder {
 public:
  Result<FilmInfo> open(const std::filesystem::path& path) override {
    av_log_set_level(AV_LOG_QUIET);
    name_ = path.string();
    AVFormatContext* input = nullptr;
    VOLUTE_TRY(check(avformat_open_input(&input, ("file:" + name_).c_str(), nullptr, nullptr)));
    input_.reset(input);
    VOLUTE_TRY(check(avformat_find_stream_info(input, nullptr)));
    const AVCodec* codec = nullptr;
    stream_ = av_find_best_stream(input, AVMEDIA_TYPE_VIDEO, -1, -1, &codec, 0);
    VOLUTE_TRY(check(stream_));
    const AVStream* stream = input->streams[stream_];
    codec_.reset(avcodec_alloc_context3(codec));
    frame_.reset(av_frame_alloc());
    packet_.reset(av_packet_alloc());
    if (!codec_ || !frame_ || !packet_)
      return fail(ErrorCode::kTooLarge, "{}: no memory to decode it", name_);
    VOLUTE_TRY(check(avcodec_parameters_to_context(codec_.get(), stream->codecpar)));
    VOLUTE_TRY(check(avcodec_open2(codec_.get(), codec, nullptr)));
    const AVRational rate = av_guess_frame_rate(input, input->streams[stream_], nullptr);
    const auto order = stream->codecpar->field_order;
    stored_ = {codec_->width, codec_->height};
    VOLUTE_ASSIGN(const int turned, turnOf(*stream));
    const bool onItsSide = turned % 180 != 0;
    const AVRational pixel = av_guess_sample_aspect_ratio(input, input->streams[stream_], nullptr);
    const double aspect = pixel.num > 0 && pixel.den > 0 ? av_q2d(pixel) : 1;
    info_ = {.width = stored_[onItsSide ? 1 : 0],
             .height = stored_[onItsSide ? 0 : 1],
             .framesPerSecond = rate.den > 0 ? av_q2d(rate) : 0,
             .interlaced = order != AV_FIELD_UNKNOWN && order != AV_FIELD_PROGRESSIVE,
             .turned = turned,
             .pixelAspect = onItsSide ? 1 / aspect : aspect};
    for (unsigned i = 0; i < input->nb_streams; ++i) {
      const AVStream& other = *input->streams[i];
      info_.otherStreams += static_cast<int>(i) != stream_ &&
                            other.codecpar->codec_type == AVMEDIA_TYPE_VIDEO &&
                            (other.disposition & AV_DISPOSITION_ATTACHED_PIC) == 0;
    }
    return info_;
  }

  Result<bool> next(std::span<float> pixels) override {
    for (;;) {
      const int received = avcodec_receive_frame(codec_.get(), frame_.get());
      if (received == AVERROR_EOF)
        return false;
      if (received != AVERROR(EAGAIN)) {
        VOLUTE_TRY(check(received));
        VOLUTE_TRY(convert(pixels));
        return true;
      }
      VOLUTE_TRY(feed());
    }
  }

  Result<std::vector<double>> skip(int count) override {
    std::vector<double> times;
    while (times.size() < static_cast<std::size_t>(count)) {
      VOLUTE_ASSIGN(const bool more, nextPacket());
      if (!more)
        break;
      const bool shown = (packet_->flags & AV_PKT_FLAG_DISCARD) == 0;
      const std::int64_t time = packet_->pts;
      av_packet_unref(packet_.get());
      if (shown)
        times.push_back(time == AV_NOPTS_VALUE ? std::numeric_limits<double>::quiet_NaN()
                                               : static_cast<double>(time) *
                                                     av_q2d(input_->streams[stream_]->time_base));
    }
    return times;
  }

 private:
  Status check(int code) const {
    if (code >= 0)
      return {};
    return fail(ErrorCode::kInvalidData, "{}: cannot decode the film: {}", name_, reason(code));
  }

  /// By how many degrees, clockwise, pictures are to be turned that are shown as the film says.
  Result<int> turnOf(const AVStream& stream) const {
#if LIBAVFORMAT_VERSION_MAJOR >= 61
    const AVPacketSideData* data =
        av_packet_side_data_get(stream.codecpar->coded_side_data,
                                stream.codecpar->nb_coded_side_data, AV_PKT_DATA_DISPLAYMATRIX);
    const std::uint8_t* bytes = data ? data->data : nullptr;
    const std::size_t size = data ? data->size : 0;
#else
    std::size_t size = 0;
    const std::uint8_t* bytes = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, &size);
#endif
    std::array<std::int32_t, 9> matrix{};
    if (!bytes || size < sizeof matrix)
      return 0;
    std::memcpy(matrix.data(), bytes, sizeof matrix);
    const double angle = av_display_rotation_get(matrix.data());
    const double turns = std::round(-angle / 90);
    const bool mirrored =
        static_cast<double>(matrix[0]) * matrix[4] < static_cast<double>(matrix[1]) * matrix[3];
    if (mirrored || !(std::abs(-angle - 90 * turns) < 1)) {
      return fail(
          ErrorCode::kUnsupported,
          "{}: its pictures are to be shown mirrored, or turned by other than right angles; "
          "expected upright pictures: write it again as it is shown",
          name_);
    }
    return (static_cast<int>(turns) + 4) % 4 * 90;
  }

  /// packet_ becomes the next one of the film's stream; false after the last.
  Result<bool> nextPacket() {
    for (;;) {
      const int read = av_read_frame(input_.get(), packet_.get());
      if (read == AVERROR_EOF)
        return false;
      VOLUTE_TRY(check(read));
      if (packet_->stream_index == stream_)
        return true;
      av_packet_unref(packet_.get());
    }
  }

  /// The next packet goes to the decoder; after the last one it is told to flush.
  Status feed() {
    VOLUTE_ASSIGN(const bool more, nextPacket());
    const int sent = avcodec_send_packet(codec_.get(), more ? packet_.get() : nullptr);
    av_packet_unref(packet_.get());
    return check(sent);
  }

  Status convert(std::span<float> pixels) {
    if (frame_->width != stored_[0] || frame_->height != stored_[1]) {
      return fail(ErrorCode::kUnsupported, "{}: the size of the frames changes within the film",
                  name_);
    }
    const auto format = static_cast<AVPixelFormat>(frame_->format);
    const AVPixFmtDescriptor* described = av_pix_fmt_desc_get(format);
    const int depth = described ? described->comp[0].depth : 8;
    const bool deep = depth > 8;
    const AVPixelFormat rgb = deep ? AV_PIX_FMT_RGB48 : AV_PIX_FMT_RGB24;
    scaler_.reset(sws_getCachedContext(scaler_.release(), frame_->width, frame_->height, format,
                                       frame_->width, frame_->height, rgb, kExact, nullptr, nullptr,
                                       nullptr));
    if (!scaler_)
      return fail(ErrorCode::kUnsupported, "{}: an unknown pixel format", name_);
    VOLUTE_ASSIGN(const int* matrix, matrixOf(*frame_));
    // Grey is full unless it says otherwise. The scaler takes 8 bits of it as full even then, and
    // fills up those of more bits with zeros, as it does brightness and colour differences of the
    // full range: their range is taken after it.
    const bool grey = described && isGrey(*described);
    const bool full = frame_->color_range == AVCOL_RANGE_JPEG;
    LevelRange range;
    if (grey)
      range = rangeOf(depth, frame_->color_range == AVCOL_RANGE_MPEG);
    else if (full && deep && (described->flags & AV_PIX_FMT_FLAG_RGB) == 0)
      range = rangeOf(depth, false);
    else if (deep && (described->flags & AV_PIX_FMT_FLAG_RGB) == 0)
      range = {0, 255 * 256 / 65535.0};  // what it widens the limited range to
    VOLUTE_TRY(settleColor(*frame_, deep ? 65536 : 256, range));
    sws_setColorspaceDetails(scaler_.get(), matrix, grey || full, matrix, 1, 0, 1 << 16, 1 << 16);
    if (!rgb_ || rgb_->format != rgb)
      rgb_ = makeFrame(rgb, stored_[0], stored_[1]);
    if (!rgb_)
      return fail(ErrorCode::kTooLarge, "{}: no memory to decode it", name_);
    VOLUTE_TRY(check(sws_scale(scaler_.get(), frame_->data, frame_->linesize, 0, stored_[1],
                               rgb_->data, rgb_->linesize)));
    deep ? lightOf<std::uint16_t>(pixels) : lightOf<std::uint8_t>(pixels);
    if (info_.turned != 0)
      turn(pixels);
    return {};
  }

  /// Where black and white lie among the levels.
  struct LevelRange {
    double black = 0, white = 1;

    bool operator==(const LevelRange&) const = default;
  };

  static LevelRange rangeOf(int depth, bool limited) {
    const double bits = std::max(depth, 8), last = depth > 8 ? 65535 : 255;
    const double unit = depth > 8 ? 256 : 1;  // of 8 bits
    if (limited)
      return {16 * unit / last, 235 * unit / last};
    return {0, (std::exp2(bits) - 1) * unit / std::exp2(bits - 8) / last};
  }

  /// One component of brightness, with transparency or without.
  static bool isGrey(const AVPixFmtDescriptor& format) {
    constexpr std::uint64_t kOther = AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_RGB |
                                     AV_PIX_FMT_FLAG_BITSTREAM | AV_PIX_FMT_FLAG_BAYER |
                                     AV_PIX_FMT_FLAG_FLOAT;
    return format.nb_components <= 2 && (format.flags & kOther) == 0;
  }

  void turn(std::span<float> pixels) const {
    const std::vector<float> from(pixels.begin(), pixels.end());
    const int width = stored_[0], height = stored_[1];
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const int toX = info_.turned == 90    ? height - 1 - y
                        : info_.turned == 180 ? width - 1 - x
                                              : y;
        const int toY = info_.turned == 90    ? x
                        : info_.turned == 180 ? height - 1 - y
                                              : width - 1 - x;
        std::copy_n(&from[3 * (std::size_t(y) * width + x)], 3,
                    &pixels[3 * (std::size_t(toY) * info_.width + toX)]);
      }
    }
  }

  template <class Value>
  void lightOf(std::span<float> pixels) const {
    const int width = stored_[0];
    for (int y = 0; y < stored_[1]; ++y) {
      const auto* from =
          reinterpret_cast<const Value*>(rgb_->data[0] + std::ptrdiff_t{y} * rgb_->linesize[0]);
      float* to = &pixels[std::size_t{3} * width * y];
      for (int i = 0; i < 3 * width; ++i) to[i] = linear_[from[i]];
      if (!toSrgb_)
        continue;
      for (int x = 0; x < width; ++x, to += 3) {
        const Vec3 light = *toSrgb_ * Vec3(to[0], to[1], to[2]);
        for (int c = 0; c < 3; ++c) to[c] = static_cast<float>(std::max(light[c], 0.0));
      }
    }
  }

  /// How a frame's brightness and colour differences become red, green and blue: as it says, else
  /// as is usual for its size.
  Result<const int*> matrixOf(const AVFrame& frame) const {
    switch (frame.colorspace) {
      case AVCOL_SPC_UNSPECIFIED:
        return sws_getCoefficients(frame.height >= 720 ? SWS_CS_ITU709 : SWS_CS_ITU601);
      case AVCOL_SPC_RGB:  // is not converted
      case AVCOL_SPC_BT709:
        return sws_getCoefficients(SWS_CS_ITU709);
      case AVCOL_SPC_FCC:
        return sws_getCoefficients(SWS_CS_FCC);
      case AVCOL_SPC_BT470BG:
      case AVCOL_SPC_SMPTE170M:
        return sws_getCoefficients(SWS_CS_ITU601);
      case AVCOL_SPC_SMPTE240M:
        return sws_getCoefficients(SWS_CS_SMPTE240M);
      case AVCOL_SPC_BT2020_NCL:
        return sws_getCoefficients(SWS_CS_BT2020);
      default: {
        const char* name = av_color_space_name(frame.colorspace);
        return fail(ErrorCode::kUnsupported,
                    "{}: its colours are coded by the matrix {}; expected bt709, bt601 or bt2020nc",
                    name_, name ? name : "of an unknown number");
      }
    }
  }

  /// What the levels are as light, and in which primaries. The curves of video are read as sRGB's,
  /// which nearly all players do; those of high dynamic range have another white.
  Status settleColor(const AVFrame& frame, std::size_t levels, const LevelRange& range) {
    const auto curve = frame.color_trc;
    if (linear_.size() == levels && curve == curve_ && frame.color_primaries == primaries_ &&
        range == range_)
      return {};
    constexpr int kGamma22 = 4, kGamma28 = 5, kLinear = 8, kSrgb = 13, kPq = 16, kHlg = 18;
    constexpr int kRec709 = 1, kRec2020 = 9, kDisplayP3 = 12;
    if (curve == kPq || curve == kHlg || curve == AVCOL_TRC_LOG || curve == AVCOL_TRC_LOG_SQRT) {
      return fail(ErrorCode::kUnsupported,
                  "{}: its values follow the curve {}; expected a film of standard dynamic range",
                  name_, av_color_transfer_name(curve));
    }
    const bool power = curve == kGamma22 || curve == kGamma28 || curve == kLinear;
    const bool wide = frame.color_primaries == kRec2020 || frame.color_primaries == kDisplayP3;
    const auto color = colorOfCodePoints(wide ? frame.color_primaries : kRec709,
                                         power ? static_cast<int>(curve) : kSrgb);
    if (!color)
      return fail(color.error().code, color.error().hints, "{}: {}", name_, color.error().message);
    linear_.resize(levels);
    for (std::size_t i = 0; i < levels; ++i) {
      const double level = static_cast<double>(i) / static_cast<double>(levels - 1);
      const double value =
          std::clamp((level - range.black) / (range.white - range.black), 0.0, 1.0);
      linear_[i] =
          static_cast<float>(color->curves[0] ? color->curves[0](value) : srgbDecode(value));
    }
    toSrgb_ = color->toSrgb;
    curve_ = curve, primaries_ = frame.color_primaries, range_ = range;
    return {};
  }

  std::string name_;
  FilmInfo info_;
  std::array<int, 2> stored_{};  ///< width and height before turning [pixels]
  InputPtr input_;
  int stream_ = -1;
  CodecPtr codec_;
  FramePtr frame_;  // as it was decoded
  FramePtr rgb_;
  PacketPtr packet_;
  ScalerPtr scaler_;
  std::vector<float> linear_;   ///< of each level
  std::optional<Mat3> toSrgb_;  ///< from the film's primaries; none: they are sRGB's
  AVColorTransferCharacteristic curve_ = AVCOL_TRC_UNSPECIFIED;  ///< that linear_ is of
  AVColorPrimaries primaries_ = AVCOL_PRI_UNSPECIFIED;
  LevelRange range_;
};

}  // namespace
}  // namespace volute

extern "C" const volute::FilmPlugin* voluteFilmPlugin() {
  using namespace volute;
  static constexpr FilmPlugin kPlugin{makeWriter, []() -> std::unique_ptr<FilmDecoder> {
                                        return std::make_unique<AvFilmDecoder>();
                                      }};
  return &kPlugin;
}
