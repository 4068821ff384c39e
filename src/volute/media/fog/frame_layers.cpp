// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fog/frame_layers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <vector>

#include "volute/base/lower_case.hpp"

namespace volute {
namespace {

/// "ViewLayer.Depth" of "ViewLayer.Depth.Z".
std::string before(const std::string& name) {
  const auto dot = name.rfind('.');
  return dot == std::string::npos ? "" : name.substr(0, dot);
}

std::string after(const std::string& name) {
  const auto dot = name.rfind('.');
  return dot == std::string::npos ? name : name.substr(dot + 1);
}

const FrameChannel* find(std::span<const FrameChannel> channels, const std::string& name) {
  const auto found = std::ranges::find(channels, lowerCase(name), [](const FrameChannel& channel) {
    return lowerCase(channel.name);
  });
  return found == channels.end() ? nullptr : &*found;
}

const FrameChannel* in(std::span<const FrameChannel> channels, const std::string& layer,
                       const char* name) {
  return find(channels, layer.empty() ? name : layer + "." + name);
}

std::string namesOf(std::span<const FrameChannel> channels) {
  std::vector<std::string> names;
  for (const FrameChannel& channel : channels) names.push_back(channel.name);
  return names.empty() ? "none of half or float" : fmt::to_string(fmt::join(names, ", "));
}

/// Layers of the whole picture, the surest first. Blender's compositor gives "Composite.Combined".
constexpr std::string_view kWhole[] = {"combined", "rgba",       "beauty",    "rgb",
                                       "c",        "ci",         "color",     "colour",
                                       "main",     "finalimage", "composite", "rgba_main"};

std::size_t rankOf(const std::string& layer) {
  if (layer.empty())
    return 0;
  const std::string name = lowerCase(layer);
  if (name == "composite.combined")
    return 1;
  const auto known = std::ranges::find(kWhole, after(name));
  return 2 + static_cast<std::size_t>(known - std::begin(kWhole));
}

/// Three numbers of one thing: a normal, a position, a motion; their Z is no depth.
bool isVector(std::span<const FrameChannel> channels, const std::string& layer) {
  return in(channels, layer, "X") && in(channels, layer, "Y");
}

struct DepthName {
  std::string_view name;
  DepthKind kind = DepthKind::kUnknown;
};

/// What renderers call it, in small letters without `_`, `-` and spaces: a layer with one channel,
/// or a channel. Blender's mist and the depth for its denoiser are others.
constexpr DepthName kDepths[] = {{"depth"},
                                 {"z"},
                                 {"zdepth"},
                                 {"depthz"},
                                 {"vrayzdepth"},
                                 {"pz", DepthKind::kAlongAxis},
                                 {"hitpz", DepthKind::kAlongAxis},
                                 {"ray:hitpz", DepthKind::kAlongAxis},
                                 {"worlddepth", DepthKind::kAlongAxis},
                                 {"scenedepth", DepthKind::kAlongAxis},
                                 {"scenedepthworldunits", DepthKind::kAlongAxis},
                                 {"distance", DepthKind::kAlongRay},
                                 {"raylength", DepthKind::kAlongRay},
                                 {"ray:hitdist", DepthKind::kAlongRay},
                                 {"hitdist", DepthKind::kAlongRay}};

std::string withoutMarks(std::string name) {
  std::erase_if(name, [](char c) { return c == '_' || c == '-' || c == ' '; });
  return name;
}

/// "FinalImageMovieRenderQueue_WorldDepth" is one.
const DepthName* depthOf(const std::string& name) {
  const std::string whole = lowerCase(name), own = withoutMarks(whole);
  const auto known = std::ranges::find_if(kDepths, [&](const DepthName& depth) {
    return own == depth.name || (depth.name.ends_with("depth") && depth.name.size() > 6 &&
                                 whole.ends_with("_" + std::string(depth.name)));
  });
  return known == std::end(kDepths) ? nullptr : &*known;
}

/// "ViewLayer.Depth.Z" of "ViewLayer.Depth.left.Z", as Blender calls a depth of several views.
std::string withoutView(const std::string& name) {
  const std::string layer = before(name), pass = before(layer);
  return !pass.empty() && depthOf(after(pass)) ? pass + "." + after(name) : name;
}

/// The one channel of a layer of that name, or a channel of that name.
const DepthName* depthOf(std::span<const FrameChannel> channels, const FrameChannel& channel) {
  constexpr std::string_view kOnly[] = {"z", "v", "y", "r", "x", "depth"};
  const std::string layer = before(channel.name), own = lowerCase(after(channel.name));
  if (isVector(channels, layer))
    return nullptr;
  if (!layer.empty() && std::ranges::find(kOnly, own) != std::end(kOnly)) {
    for (const std::string& name : {layer, before(withoutView(channel.name))}) {
      if (const DepthName* depth = depthOf(after(name)))
        return depth;
    }
  }
  // "ViewLayer.Mist.Z" is none: a channel is one by its own name where no other name says more. In
  // a layer that is a whole picture, such as "left", it is.
  const bool picture =
      in(channels, layer, "R") && in(channels, layer, "G") && in(channels, layer, "B");
  return layer.empty() || own != "z" || picture ? depthOf(own) : nullptr;
}

/// "ViewLayer.Mist.Z".
bool isMist(const FrameChannel& channel) {
  return lowerCase(after(before(channel.name))) == "mist" || lowerCase(channel.name) == "mist";
}

DepthChannel makeDepth(const FrameInfo& info, const FrameChannel& channel, const DepthName* name) {
  DepthChannel depth{channel};
  if (name)
    depth.kind = name->kind;
  const std::string own = lowerCase(withoutView(channel.name));
  if (depth.kind == DepthKind::kUnknown &&
      (info.software.find("Blender") != std::string::npos || info.software.starts_with("Volute") ||
       own.ends_with(".depth.z") || own == "depth.v" || own.ends_with(".depth.v")))
    depth.kind = DepthKind::kAlongAxis;
  if (own.find("worlddepth") != std::string::npos || own.find("scenedepth") != std::string::npos)
    depth.unit = "Unreal writes centimetres, 0.01";
  const std::string layer = before(channel.name);
  const FrameChannel *green = in(info.channels, layer, "G"), *blue = in(info.channels, layer, "B");
  if (lowerCase(after(channel.name)) == "r" && green && blue)
    depth.same[0] = *green, depth.same[1] = *blue;
  return depth;
}

}  // namespace

Result<ColorChannels> colorChannels(std::span<const FrameChannel> channels,
                                    const std::string& layer) {
  std::vector<std::string> layers;
  for (const FrameChannel& channel : channels) {
    const std::string name = before(channel.name);
    if (lowerCase(after(channel.name)) == "r" && in(channels, name, "G") && in(channels, name, "B"))
      layers.push_back(name);
  }
  std::ranges::stable_sort(layers, {}, rankOf);
  const auto make = [&](const std::string& name) {
    ColorChannels color{
        name, {*in(channels, name, "R"), *in(channels, name, "G"), *in(channels, name, "B")}};
    if (const FrameChannel* alpha = in(channels, name, "A"))
      color.alpha = *alpha;
    return color;
  };
  if (!layer.empty()) {
    const auto named = std::ranges::find(layers, lowerCase(layer), lowerCase);
    if (named != layers.end())
      return make(*named);
    return fail(ErrorCode::kInvalidData, "has no layer '{}' with R, G and B; its channels are {}",
                layer, namesOf(channels));
  }
  if (!layers.empty()) {
    if (layers.size() == 1 || rankOf(layers[0]) < rankOf(layers[1]))
      return make(layers[0]);
    return fail(ErrorCode::kInvalidData,
                Hint::set("color_layer").so("says which layer is the picture"),
                "has the layers {}; expected one, or one called Combined, rgba or beauty",
                fmt::join(layers, ", "));
  }
  const FrameChannel* grey = find(channels, "Y");
  if (!grey && channels.size() == 1)
    grey = &channels.front();
  if (!grey) {
    return fail(ErrorCode::kInvalidData,
                "has the channels {}; expected R, G, B, or Y, as half or float", namesOf(channels));
  }
  ColorChannels color{"", {*grey, *grey, *grey}};
  if (const FrameChannel* alpha = find(channels, "A"))
    color.alpha = *alpha;
  return color;
}

Result<DepthChannel> depthChannel(const FrameInfo& info, const std::string& wanted,
                                  const std::string& layer) {
  if (info.channels.empty())
    return fail(ErrorCode::kInvalidData,
                "has no channel of half or float; expected the depth as one, not as integers");
  const std::span<const FrameChannel> channels = info.channels;
  if (!wanted.empty()) {
    const FrameChannel* channel = find(channels, wanted);
    if (!channel)
      return fail(ErrorCode::kInvalidData, "has no channel '{}'; its channels are {}", wanted,
                  namesOf(channels));
    DepthChannel depth = makeDepth(info, *channel, depthOf(channels, *channel));
    depth.same[0].reset(), depth.same[1].reset();
    return depth;
  }
  std::vector<DepthChannel> found;
  for (const FrameChannel& channel : channels) {
    if (const DepthName* name = depthOf(channels, channel))
      found.push_back(makeDepth(info, channel, name));
  }
  if (found.size() > 1) {  // that of the colour's view, or of the file itself
    const std::string view = lowerCase(layer.substr(0, layer.find('.')));
    const auto ofView = [&](const DepthChannel& depth) {
      return lowerCase(depth.channel.name).starts_with(view + ".");
    };
    const auto ofFile = [](const DepthChannel& depth) {
      return lowerCase(depth.channel.name) == "z";
    };
    // "ViewLayer.Depth.left.Z" of "ViewLayer.Combined.left".
    const auto ofEye = [&](const DepthChannel& depth) {
      return ofView(depth) && withoutView(depth.channel.name) != depth.channel.name &&
             lowerCase(after(before(depth.channel.name))) == lowerCase(after(layer));
    };
    if (std::ranges::count_if(found, ofView) == 1)
      std::erase_if(found, std::not_fn(ofView));
    else if (std::ranges::count_if(found, ofEye) == 1)
      std::erase_if(found, std::not_fn(ofEye));
    else if (layer.find('.') == std::string::npos && std::ranges::count_if(found, ofFile) == 1)
      std::erase_if(found, std::not_fn(ofFile));
  }
  if (found.size() == 1)
    return found.front();
  if (found.size() > 1) {
    std::vector<std::string> names;
    for (const DepthChannel& depth : found) names.push_back(depth.channel.name);
    return fail(ErrorCode::kInvalidData, Hint::choose("depth_channel"),
                "has the depths {}; expected one", fmt::join(names, ", "));
  }
  if (channels.size() == 1 && isMist(channels.front())) {
    return fail(ErrorCode::kInvalidData,
                "has the channel {}, which is 0 to 1 between two distances; expected a depth",
                channels.front().name);
  }
  if (channels.size() == 1)
    return makeDepth(info, channels.front(), nullptr);
  const FrameChannel* red = find(channels, "R");
  const bool grey = red && find(channels, "G") && find(channels, "B") &&
                    channels.size() == (find(channels, "A") ? 4U : 3U);
  if (grey)
    return makeDepth(info, *red, nullptr);
  const FrameChannel* only = find(channels, "Y");
  if (only && channels.size() == (find(channels, "A") ? 2U : 1U))
    return makeDepth(info, *only, nullptr);
  return fail(ErrorCode::kInvalidData, Hint::set("depth_channel").so("says which channel it is"),
              "has the channels {}; expected a depth as renderers call it (Z, Depth.V, "
              "ViewLayer.Depth.Z, depth.Z), or R = G = B",
              namesOf(channels));
}

}  // namespace volute
