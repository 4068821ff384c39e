// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/smoke_drawers.hpp"

#include <cmath>
#include <cstring>

#include "bench/smoke_peer.hpp"
#include "bench/timing.hpp"
#include "volute/io/plugin.hpp"
#include "volute/io/reader_process.hpp"
#include "volute/tetmesh/tet_splat.hpp"

namespace volute::bench {
namespace {

/// Transmittances.
class OwnDrawer : public SmokeDrawer {
 public:
  OwnDrawer(const SmokeCase& smoke, const std::shared_ptr<const TetLocator>& locator,
            std::string_view name, SmokeRole role)
      : splat_(locator), smoke_(smoke), name_(name), role_(role) {}

  std::string_view name() const override { return name_; }

  SmokeRole role() const override { return role_; }

  Result<DrawTimes> draw(const SmokeView& view, std::span<float> opacity) override {
    const auto begin = Clock::now();
    const double cpu = cpuSeconds();
    if (view.field != field_)
      splat_.setExtinction(smoke_.extinction[static_cast<std::size_t>(view.field)]);
    field_ = view.field;
    paint(view.camera(), opaqueDepth(view));
    DrawTimes times;
    times.wall = secondsSince(begin);
    times.cpu = cpuSeconds() - cpu;
    fill(opacity);
    return times;
  }

 protected:
  virtual void paint(const Camera& camera, OpaqueDepth opaque) {
    depth_.resize(static_cast<std::size_t>(camera.width()) * camera.height());
    splat_.opticalDepth(camera, opaque, depth_);
  }

  virtual void fill(std::span<float> opacity) const {
    for (std::size_t i = 0; i < opacity.size(); ++i)
      opacity[i] = static_cast<float>(-std::expm1(-double{depth_[i]}));
  }

  TetSplat splat_;

 private:
  const SmokeCase& smoke_;
  std::string_view name_;
  SmokeRole role_;
  int field_ = -1;
  std::vector<float> depth_;
};

/// Smoke under a uniform white light: what is seen of it is its opacity.
class LitDrawer final : public OwnDrawer {
 public:
  LitDrawer(const SmokeCase& smoke, const std::shared_ptr<const TetLocator>& locator,
            std::string_view name, SmokeRole role)
      : OwnDrawer(smoke, locator, name, role) {
    splat_.setSource(std::vector<float>(3 * smoke.mesh->vertices().size(), 1));
  }

 private:
  void paint(const Camera& camera, OpaqueDepth opaque) override {
    color_.resize(4 * static_cast<std::size_t>(camera.width()) * camera.height());
    splat_.litColor(camera, opaque, color_);
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
      : name_(name), mapper_(mapper), process_(serve({smoke.mesh, &smoke.extinction}, mapper)) {
    limits_.memory = std::uint64_t{32} << 30;
    limits_.seconds = seconds;
  }

  std::string_view name() const override { return name_; }

  SmokeRole role() const override {
    return mapper_ == PeerMapper::kProjectedTetrahedra ? SmokeRole::kBaseline : SmokeRole::kOther;
  }

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
      return fail(ErrorCode::kUnsupported, "one frame takes more than {:.0f} s of CPU time",
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
  PeerMapper mapper_;
  ReaderProcess process_;
  ReaderProcess::Limits limits_;
};

}  // namespace

std::vector<std::unique_ptr<SmokeDrawer>> smokeDrawers(
    const SmokeCase& smoke, const std::shared_ptr<const TetLocator>& locator, bool quick) {
  std::vector<std::unique_ptr<SmokeDrawer>> drawers;
  // Of CPU time for one frame. The baseline's frames are what all is measured by: they may
  // take as long as they take.
  constexpr double kBaseline = 600, kOthers = 60, kQuick = 30, kSweep = 30;
  drawers.push_back(std::make_unique<PeerDrawer>(smoke, PeerMapper::kProjectedTetrahedra,
                                                 "VTK projected tetrahedra", kBaseline));
  drawers.push_back(std::make_unique<OwnDrawer>(smoke, locator, "Volute, transmittance by splat",
                                                SmokeRole::kDepth));
  drawers.push_back(
      std::make_unique<LitDrawer>(smoke, locator, "Volute, lit colour by splat", SmokeRole::kLit));
  drawers.push_back(std::make_unique<PeerDrawer>(smoke, PeerMapper::kRayCaster,
                                                 "VTK Bunyk ray caster", quick ? kQuick : kOthers));
  if (!quick)
    drawers.push_back(
        std::make_unique<PeerDrawer>(smoke, PeerMapper::kZSweep, "VTK Z sweep", kSweep));
  return drawers;
}

}  // namespace volute::bench
