// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/benchmarks/smoke_drawers.hpp"

#include <sys/resource.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>

#include "volute/base/parallel.hpp"
#include "volute/cli/benchmarks/smoke_peer.hpp"
#include "volute/io/plugin.hpp"
#include "volute/io/reader_process.hpp"
#include "volute/tetmesh/tet_marcher.hpp"
#include "volute/tetmesh/tet_splat.hpp"

namespace volute::cli {
namespace {

double processorSeconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

/// What stays the same between Volute's paths: new smoke, the sign, the clock.
template <class Path>
class OwnDrawer : public SmokeDrawer {
 public:
  OwnDrawer(const SmokeCase& smoke, const std::shared_ptr<const TetLocator>& locator,
            std::string_view name)
      : path_(locator), smoke_(smoke), name_(name) {}

  std::string_view name() const override { return name_; }

  Result<DrawTimes> draw(const SmokeView& view, std::span<float> opacity) override {
    const auto begin = std::chrono::steady_clock::now();
    const double processor = processorSeconds();
    if (view.field != field_)
      path_.setExtinction(smoke_.extinction[static_cast<std::size_t>(view.field)]);
    field_ = view.field;
    paint(view.camera(), opaqueDepth(view));
    DrawTimes times;
    times.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    times.processor = processorSeconds() - processor;
    fill(opacity);
    return times;
  }

 protected:
  virtual void paint(const Camera& camera, OpaqueDepth opaque) {
    depth_.resize(static_cast<std::size_t>(camera.width()) * camera.height());
    path_.opticalDepth(camera, opaque, depth_);
  }

  virtual void fill(std::span<float> opacity) const {
    for (std::size_t i = 0; i < opacity.size(); ++i)
      opacity[i] = static_cast<float>(-std::expm1(-double{depth_[i]}));
  }

  Path path_;

 private:
  const SmokeCase& smoke_;
  std::string_view name_;
  int field_ = -1;
  std::vector<float> depth_;
};

/// Smoke under a uniform white light: what is seen of it is its opacity.
template <class Path>
class LitDrawer final : public OwnDrawer<Path> {
 public:
  LitDrawer(const SmokeCase& smoke, const std::shared_ptr<const TetLocator>& locator,
            std::string_view name)
      : OwnDrawer<Path>(smoke, locator, name) {
    this->path_.setSource(std::vector<float>(3 * smoke.mesh->vertices().size(), 1));
  }

 private:
  void paint(const Camera& camera, OpaqueDepth opaque) override {
    color_.resize(4 * static_cast<std::size_t>(camera.width()) * camera.height());
    this->path_.litColor(camera, opaque, color_);
  }

  void fill(std::span<float> opacity) const override {
    for (std::size_t i = 0; i < opacity.size(); ++i) opacity[i] = color_[4 * i];
  }

  std::vector<float> color_;
};

template <class T>
std::string bytesOf(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

/// Somebody else's, in a process with a limit on its time: some take minutes, some crash.
class PeerDrawer final : public SmokeDrawer {
 public:
  PeerDrawer(const SmokeCase& smoke, PeerMapper mapper, std::string_view name, double seconds)
      : name_(name), process_(serve({smoke.mesh, &smoke.extinction}, mapper)) {
    limits_.memory = std::uint64_t{32} << 30;
    limits_.seconds = seconds;
  }

  std::string_view name() const override { return name_; }

  Result<DrawTimes> draw(const SmokeView& view, std::span<float> opacity) override {
    PeerView peer;
    for (int k = 0; k < 3; ++k) {
      peer.eye[k] = view.eye[k], peer.target[k] = view.target[k];
      for (std::size_t c = 0; c < view.sign.size(); ++c) peer.sign[c][k] = view.sign[c][k];
    }
    peer.fov = view.fov;
    peer.width = view.width, peer.height = view.height;
    peer.field = view.field;
    peer.hasSign = !view.sign.empty();
    const std::string file(name_);
    auto reply = process_.call(file, bytesOf(peer), opacity.size(), limits_);
    if (!reply) {
      // Written for files.
      if (reply.error().message.find("too long") == std::string::npos)
        return tl::unexpected<Error>(reply.error());
      return fail(ErrorCode::kUnsupported, "one frame takes more than {:.0f} s of processor time",
                  limits_.seconds);
    }
    DrawTimes times;
    std::memcpy(&times, reply->data(), std::min(reply->size(), sizeof times));
    std::ranges::copy(process_.values(), opacity.begin());
    return times;
  }

 private:
  static ReaderProcess::Serve serve(const PeerScene& scene, PeerMapper mapper) {
    return [scene, mapper, peer = std::shared_ptr<SmokePeer>()](
               std::string_view request, std::span<float> values) mutable -> Result<std::string> {
      PeerView view;
      std::memcpy(&view, request.data(), sizeof view);
      if (!peer) {
        VOLUTE_ASSIGN(const void* plugin,
                      loadPlugin("volute_bench_vtk", "voluteSmokePeers", "VTK's rendering"));
        VOLUTE_ASSIGN(peer, static_cast<const SmokePeerPlugin*>(plugin)->make(mapper, scene));
      }
      VOLUTE_ASSIGN(const PeerTimes times, peer->draw(view, values));
      return bytesOf(times);
    };
  }

  std::string_view name_;
  ReaderProcess process_;
  ReaderProcess::Limits limits_;
};

}  // namespace

std::vector<float> opaqueDepth(const SmokeView& view) {
  if (view.sign.empty())
    return {};
  const Camera camera = view.camera();
  std::vector<float> depth(static_cast<std::size_t>(view.width) * view.height,
                           std::numeric_limits<float>::infinity());
  const Vec3 across = view.sign[1] - view.sign[0], down = view.sign[3] - view.sign[0];
  const Vec3 normal = across.cross(down);
  parallelRanges(
      static_cast<std::size_t>(view.height), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
          for (int x = 0; x < view.width; ++x) {
            const Segment ray = pixelRay(camera, x, static_cast<int>(y), {});
            const double distance =
                normal.dot(view.sign[0] - ray.origin) / normal.dot(ray.direction);
            const Vec3 at = ray.origin + distance * ray.direction - view.sign[0];
            const double u = at.dot(across) / across.squaredNorm(),
                         v = at.dot(down) / down.squaredNorm();
            if (distance > 0 && u >= 0 && u <= 1 && v >= 0 && v <= 1)
              depth[y * static_cast<std::size_t>(view.width) + static_cast<std::size_t>(x)] =
                  static_cast<float>(distance);
          }
        }
      });
  return depth;
}

std::vector<std::unique_ptr<SmokeDrawer>> smokeDrawers(
    const SmokeCase& smoke, const std::shared_ptr<const TetLocator>& locator, bool quick) {
  std::vector<std::unique_ptr<SmokeDrawer>> drawers;
  const double seconds = quick ? 30 : 60;
  drawers.push_back(std::make_unique<PeerDrawer>(smoke, PeerMapper::kProjectedTetrahedra,
                                                 "VTK projected tetrahedra", 90));
  drawers.push_back(
      std::make_unique<OwnDrawer<TetSplat>>(smoke, locator, "Volute, transmittance by splat"));
  drawers.push_back(
      std::make_unique<OwnDrawer<TetMarcher>>(smoke, locator, "Volute, transmittance by marching"));
  drawers.push_back(
      std::make_unique<LitDrawer<TetSplat>>(smoke, locator, "Volute, lit colour by splat"));
  drawers.push_back(
      std::make_unique<LitDrawer<TetMarcher>>(smoke, locator, "Volute, lit colour by marching"));
  drawers.push_back(
      std::make_unique<PeerDrawer>(smoke, PeerMapper::kRayCaster, "VTK Bunyk ray caster", seconds));
  if (!quick) {
    drawers.push_back(
        std::make_unique<PeerDrawer>(smoke, PeerMapper::kZSweep, "VTK Z sweep", seconds));
  }
  return drawers;
}

}  // namespace volute::cli
