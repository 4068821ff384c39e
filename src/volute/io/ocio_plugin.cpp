// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <OpenColorIO/OpenColorIO.h>
#include <fmt/format.h>

#include <cstdlib>
#include <string>
#include <utility>

#include "volute/image/view_transform.hpp"

namespace volute {
namespace {

namespace ocio = OCIO_NAMESPACE;

/// From sRGB's primaries to those of ACES2065-1, white D65 to D60 by Bradford.
constexpr double kToAces[16] = {0.439632981919491,
                                0.382988698151554,
                                0.177378319928955,
                                0,
                                0.0897764429588424,
                                0.813439428748981,
                                0.0967841282921771,
                                0,
                                0.0175411703831727,
                                0.111546553302387,
                                0.870912276314442,
                                0,
                                0,
                                0,
                                0,
                                1};

class OcioView final : public ViewTransform {
 public:
  OcioView(std::string name, ocio::ConstCPUProcessorRcPtr processor)
      : name_(std::move(name)), processor_(std::move(processor)) {}

  std::string name() const override { return name_; }

  void apply(std::span<float> pixels) const override {
    if (pixels.empty())
      return;
    ocio::PackedImageDesc image(pixels.data(), static_cast<long>(pixels.size() / 3), 1, 3);
    processor_->apply(image);
  }

 private:
  std::string name_;
  ocio::ConstCPUProcessorRcPtr processor_;
};

ocio::TransformRcPtr toAces() {
  const auto matrix = ocio::MatrixTransform::Create();
  matrix->setMatrix(kToAces);
  return matrix;
}

ocio::TransformRcPtr builtIn(const char* style) {
  const auto transform = ocio::BuiltinTransform::Create();
  transform->setStyle(style);
  return transform;
}

std::unique_ptr<const ViewTransform> made(std::string name, const ocio::ConstConfigRcPtr& config,
                                          const ocio::ConstTransformRcPtr& transform) {
  return std::make_unique<OcioView>(std::move(name),
                                    config->getProcessor(transform)->getDefaultCPUProcessor());
}

/// The library's exceptions become errors.
template <class Make>
Result<std::unique_ptr<const ViewTransform>> guarded(Make&& make) {
  try {
    return make();
  } catch (const ocio::Exception& error) {
    return fail(ErrorCode::kInvalidData, "OpenColorIO: {}", error.what());
  }
}

Result<std::unique_ptr<const ViewTransform>> acesView() {
  return guarded([]() -> Result<std::unique_ptr<const ViewTransform>> {
    const auto group = ocio::GroupTransform::Create();
    group->appendTransform(toAces());
    group->appendTransform(builtIn("ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0"));
    group->appendTransform(builtIn("DISPLAY - CIE-XYZ-D65_to_sRGB"));
    return made("sRGB/ACES 1.0", ocio::Config::CreateRaw(), group);
  });
}

/// All of them, for an error.
std::string viewsOf(const ocio::ConstConfigRcPtr& config) {
  std::string text;
  for (int d = 0; d < config->getNumDisplays(); ++d) {
    const char* display = config->getDisplay(d);
    for (int v = 0; v < config->getNumViews(display); ++v)
      text +=
          fmt::format("{}{}/{}", text.empty() ? "" : ", ", display, config->getView(display, v));
  }
  return text;
}

/// The colour space that has linear light of sRGB's primaries; empty: none has a known name.
std::string linearSpace(const ocio::ConstConfigRcPtr& config) {
  for (const char* name : {"lin_rec709_srgb", "lin_rec709", "Linear Rec.709 (sRGB)",
                           "Linear Rec.709", "Utility - Linear - sRGB",
                           "Utility - Linear - Rec.709", "lin_srgb", "Linear sRGB", "Linear"}) {
    if (config->getColorSpace(name))
      return name;
  }
  return "";
}

Result<std::unique_ptr<const ViewTransform>> configuredView(const std::string& wanted) {
  const char* file = std::getenv("OCIO");
  if (!file || !*file) {
    return fail(ErrorCode::kInvalidArgument,
                "the environment's OCIO names no configuration of OpenColorIO (config.ocio)");
  }
  return guarded([&]() -> Result<std::unique_ptr<const ViewTransform>> {
    const auto config = ocio::Config::CreateFromFile(file);
    std::string display = config->getDefaultDisplay(), view = wanted;
    for (int d = 0; d < config->getNumDisplays(); ++d) {
      const std::string name = config->getDisplay(d);
      if (wanted.starts_with(name + "/"))
        display = name, view = wanted.substr(name.size() + 1);
    }
    if (view.empty())
      view = config->getDefaultView(display.c_str());
    bool known = false;
    for (int v = 0; v < config->getNumViews(display.c_str()); ++v)
      known = known || view == config->getView(display.c_str(), v);
    if (!known) {
      return fail(ErrorCode::kInvalidArgument, "{}: has no view '{}' of '{}'; it has {}", file,
                  view, display, viewsOf(config));
    }
    const auto group = ocio::GroupTransform::Create();
    const auto shown = ocio::DisplayViewTransform::Create();
    if (const std::string linear = linearSpace(config); !linear.empty()) {
      shown->setSrc(linear.c_str());
    } else if (config->hasRole("aces_interchange")) {
      group->appendTransform(toAces());
      shown->setSrc("aces_interchange");
    } else {
      return fail(ErrorCode::kUnsupported,
                  "{}: has neither the role aces_interchange nor a colour space lin_rec709, which "
                  "would say what linear light is",
                  file);
    }
    shown->setDisplay(display.c_str());
    shown->setView(view.c_str());
    group->appendTransform(shown);
    return made(display + "/" + view, config, group);
  });
}

}  // namespace
}  // namespace volute

extern "C" const volute::ViewPlugin* voluteViewPlugin() {
  static constexpr volute::ViewPlugin kPlugin{volute::acesView, volute::configuredView};
  return &kPlugin;
}
