// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/base/frame_name.hpp"
#include "volute/base/progress.hpp"
#include "volute/image/color_scale.hpp"
#include "volute/media/camera_file.hpp"
#include "volute/media/clock.hpp"
#include "volute/media/medium_snapshot.hpp"
#include "volute/optics/visibility.hpp"

namespace volute {

/// Properties of a medium over all times.
struct MediumInfo {
  std::string file;  ///< that it is in, as it was opened
  std::string what;  ///< "a map of fog"; a title says it of a file that holds nothing else
  std::string kind;  ///< "volume": titles count media by kind
  std::string size;  ///< "64 x 64 x 64 voxels, 48 frames"; empty: nothing to be said

  Box3 bounds;                   ///< in the scene, over all times; may be infinite [m]
  std::optional<Box3> framed{};  ///< what a camera is to frame of it; nothing: its bounds [m]
  Box3 fileBounds;               ///< before what the scene does with it [m]

  /// Times of the stored frames, in the scene's time, ascending; at least one [s].
  std::vector<double> times{0.0};
  std::vector<int> numbers{0};  ///< what a person calls them
  FrameScale frameScale{};      ///< what the numbers mean
  bool interpolates = false;    ///< between stored frames; else each holds until the next
  bool loops = false;           ///< begins again after its last frame
  bool endless = false;         ///< has no end in time, whatever is stored
  bool moves = false;           ///< is never at rest, however little is stored: wind

  /// Sets `times` and `numbers` from those of a layer's frames, and `loops` from its clock.
  template <class Layer>
  void takeFrames(const Layer& layer, int count, const Clock& clock) {
    times.clear(), numbers.clear();
    for (int i = 0; i < count; ++i) {
      times.push_back(layer.timeOf(i));
      numbers.push_back(layer.numberOf(i));
    }
    if constexpr (requires { layer.frameScale(); })
      frameScale = layer.frameScale();
    loops = clock.loop;
  }

  int channels = 3;                 ///< 1: its light is grey, and colour maps apply
  bool measured = false;            ///< shown without automatic exposure
  bool burns = false;               ///< somewhere it may be brighter than white
  bool absorbs = true;              ///< takes light away
  std::optional<PictureLaw> law{};  ///< the law of pictures that it requests
  bool lawByC = false;  ///< C was said, not assumed, and nothing but the law depends on it
  bool shared = false;  ///< this process holds a share of it, see OpenOptions::team
  /// With `shared`: the first time and the transmittance from lamps to surfaces are collective.
  bool sharesAll = false;
  bool captioned = false;  ///< pictures of it alone have a legend by default

  /// The mass that its values measure: "of soot", "g/m3". Nothing: none, for the reason `noMass`.
  struct Mass {
    std::string of, unit;
    std::string field;  ///< "soot-density [g/m3]": two media with the same have one scale
  };

  std::optional<Mass> mass{};
  std::string noMass{};
};

/// A few letters that stand at a place of a scene: what a ruler's division is.
struct PlaceMark {
  Vec3 at = Vec3::Zero();  ///< [m]
  std::string text;
};

/// Text about a medium in a picture.
struct MediumText {
  std::vector<std::string> notes{};   ///< in the file of the picture
  std::vector<std::string> legend{};  ///< short lines
  std::optional<ColorScale> scale{};  ///< of a part of it that is in its colours
  std::vector<PlaceMark> marks{};     ///< with the legend, where they are
};

/// A snapshot of a medium, and how good it has to be.
struct SnapshotRequest {
  double time = 0;      ///< [s], of the scene
  double factor = 1;    ///< of all extinctions: PictureLaw::factor()
  bool coarse = false;  ///< soon is better than fine
  bool moving = false;  ///< it is shown for one picture of a film or a playback: light and splines
                        ///< may have less detail
  bool lit = true;      ///< false: extinction alone is asked for, so no light need be worked out
  bool tree = false;    ///< of a .volute: the hexadeca-tree in memory, not the frame's bricks
  /// The eye [m]: parts that block its view may be left out. Nothing: no part is left out.
  std::optional<Vec3> eye{};
};

/// A time that shows something, and why.
struct FirstTime {
  double time = 0;  ///< [s], of the scene
  std::string reason;
};

class SightField;
struct Reading;

/// A medium in time, for pictures and sight lines. Not thread-safe, unlike the snapshots that at()
/// returns.
class SceneMedium : public std::enable_shared_from_this<SceneMedium> {
 public:
  virtual ~SceneMedium() = default;

  const MediumInfo& info() const { return info_; }

  /// The medium at a time of the scene, clamped to its first and last frame.
  [[nodiscard]] virtual Result<std::shared_ptr<const MediumSnapshot>> at(
      const SnapshotRequest& request, Progress& progress) = 0;

  /// The same for sight lines, by default along rays. It and the medium share the files that were
  /// opened, so one thread at a time calls both.
  [[nodiscard]] virtual Result<std::unique_ptr<SightField>> sight(Reading& reading);

  /// Whether at() is there at once; else a coarse one is there much sooner.
  virtual bool inMemory(double time) const {
    (void)time;
    return true;
  }

  /// A key of the surfaces that addSurfaces() adds at a time: equal keys mean equal surfaces. 0:
  /// none.
  virtual std::uint64_t surfacesKey(const SnapshotRequest& request) const {
    (void)request;
    return 0;
  }

  /// Appends all of it that is opaque at a time, as it is seen from the request's eye.
  [[nodiscard]] virtual Status addSurfaces(const SnapshotRequest& request, TriangleMesh& to) const {
    (void)request, (void)to;
    return {};
  }

  /// @param eye  from where it is seen [m]; nothing: not known
  virtual MediumText text(const std::optional<Vec3>& eye) const {
    (void)eye;
    return {};
  }

  /// The default camera; nothing: one that frames its bounds.
  virtual std::optional<CameraDescription> firstCamera() const { return std::nullopt; }

  /// The default time of a single picture; nothing: its first frame.
  [[nodiscard]] virtual Result<std::optional<FirstTime>> firstTime(Progress& progress) {
    (void)progress;
    return std::nullopt;
  }

  /// The views of all pictures to come that measure nothing: options of appearance that were not
  /// given are chosen for the closest view.
  virtual void chooseLook(std::span<const Camera> views) { (void)views; }

  /// All files that it is read from.
  virtual std::vector<std::string> files() const { return {info_.file}; }

  /// What was done since it was opened, by names of `render --stats`.
  virtual nlohmann::ordered_json counts() const;

  /// Whether check() has nothing to look for.
  virtual bool checked() const { return true; }

  /// Looks for damage that only reading whole files finds; nothing: there is none.
  [[nodiscard]] virtual Result<std::optional<std::string>> check(Progress& progress) {
    (void)progress;
    return std::nullopt;
  }

  virtual bool damaged() const { return false; }

  /// Remarks made while its files were opened.
  std::vector<Remark> remarks{};

 protected:
  MediumInfo info_;
};

}  // namespace volute
