// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <utility>

#include "volute/medium/integrate.hpp"
#include "volute/medium/medium.hpp"

namespace volute {

/// Holds any Medium by value; one virtual call for each batch. Cheap to copy: the medium is shared
/// and const.
class AnyMedium {
 public:
  template <Medium M>
    requires(!std::same_as<M, AnyMedium>)
  explicit AnyMedium(M medium) : model_(std::make_shared<const Model<M>>(std::move(medium))) {}

  Box3 bounds() const { return model_->bounds(); }

  double extinction(const Vec3& point) const { return model_->extinction(point); }

  Rgb emission(const Vec3& point) const { return model_->emission(point); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    model_->opticalDepth(segments, depths);
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    model_->pieces(segments, pieces);
  }

  /// True where a part of a segment has other values than the same part of the whole segment.
  bool dependsOnEnd() const { return model_->dependsOnEnd(); }

  /// By the medium's own fast path where it has one, else by compositing its pieces.
  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
    model_->radiance(segments, out);
  }

 private:
  struct Concept {
    virtual ~Concept() = default;
    virtual Box3 bounds() const = 0;
    virtual double extinction(const Vec3& point) const = 0;
    virtual Rgb emission(const Vec3& point) const = 0;
    virtual void opticalDepth(std::span<const Segment>, std::span<double>) const = 0;
    virtual void pieces(std::span<const Segment>, std::span<std::vector<Piece>>) const = 0;
    virtual void radiance(std::span<const Segment>, std::span<Radiance>) const = 0;
    virtual bool dependsOnEnd() const = 0;
  };

  template <Medium M>
  struct Model final : Concept {
    explicit Model(M held) : medium(std::move(held)) {}

    Box3 bounds() const override { return medium.bounds(); }

    double extinction(const Vec3& point) const override { return medium.extinction(point); }

    Rgb emission(const Vec3& point) const override { return medium.emission(point); }

    void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const override {
      medium.opticalDepth(segments, depths);
    }

    void pieces(std::span<const Segment> segments,
                std::span<std::vector<Piece>> pieces) const override {
      medium.pieces(segments, pieces);
    }

    void radiance(std::span<const Segment> segments, std::span<Radiance> out) const override {
      if constexpr (FastMedium<M>) {
        medium.radiance(segments, out);
      } else {
        radianceByPieces(medium, segments, out);
      }
    }

    bool dependsOnEnd() const override {
      if constexpr (MindsTheEnd<M>)
        return medium.dependsOnEnd();
      else
        return false;
    }

    M medium;
  };

  std::shared_ptr<const Concept> model_;
};

}  // namespace volute
