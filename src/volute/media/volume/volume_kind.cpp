// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// How volumes and billboards are written down, opened and changed by a person.
#include "volute/base/remark_log.hpp"
#include "volute/fds/smv_index.hpp"
#include "volute/media/placement_parameters.hpp"
#include "volute/media/volume/volume_medium.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

/// Of this file, whatever its appearance; read again where nobody has it.
Result<std::shared_ptr<VolumeMedium>> volumeOf(const std::string& file, InputOptions input,
                                               const Appearance& appearance,
                                               MediumContext& context) {
  input.partial = context.options.partial, input.verify = context.options.verify;
  const auto before = context.take<VolumeMedium>([&](const VolumeMedium& volume) {
    const InputOptions& options = volume.layer().options();
    const bool sameBounds = options.bounds.has_value() == input.bounds.has_value() &&
                            (!input.bounds || (options.bounds->min == input.bounds->min &&
                                               options.bounds->max == input.bounds->max));
    return volume.layer().path() == file && options.grid == input.grid && sameBounds;
  });
  if (before)
    return before->with(appearance);
  RemarkLog heard(context.reading.progress);
  Reading reading{heard, context.reading.maxMemory};
  VOLUTE_ASSIGN(auto layer, VolumeLayer::open(file, input, appearance, reading));
  auto medium = std::make_shared<VolumeMedium>(std::move(layer));
  medium->remarks = heard.remarks();
  return medium;
}

const VolumeLayer& layerOf(const SceneMedium& medium) {
  return dynamic_cast<const VolumeMedium&>(medium).layer();
}

class VolumeKind final : public MediumKind {
 public:
  const FieldTable& fields() const override { return volumeFields(); }

  Result<std::shared_ptr<SceneMedium>> open(const Json& entry,
                                            MediumContext& context) const override {
    VOLUTE_ASSIGN(const auto volume,
                  readAs<SceneVolume>(volumeFields(), entry, {context.file, context.path}));
    VOLUTE_ASSIGN(auto medium, volumeOf(volume.file, volume.input, volume.appearance, context));
    return std::shared_ptr<SceneMedium>(std::move(medium));
  }

  /// What no other kind takes: reading it says what is wrong with it.
  bool opens(const std::string&) const override { return true; }

  bool setParameter(OrderedJson& entry, const SceneMedium& medium, const std::string& key,
                    const OrderedJson&, const std::vector<double>& numbers) const override {
    if (!key.starts_with("transform/"))
      return false;
    setPlacement(entry, layerOf(medium).appearance().placement, medium.info().fileBounds,
                 key.substr(key.find('/') + 1), numbers);
    return true;
  }
};

class BillboardKind final : public MediumKind {
 public:
  const FieldTable& fields() const override { return billboardFields(); }

  std::string_view list() const override { return "billboards"; }

  Result<std::shared_ptr<SceneMedium>> open(const Json& entry,
                                            MediumContext& context) const override {
    VOLUTE_ASSIGN(const auto board,
                  readAs<SceneBillboard>(billboardFields(), entry, {context.file, context.path}));
    VOLUTE_ASSIGN(const auto volume, volumeOf(board.file, {}, board.appearance, context));
    return std::make_shared<BillboardMedium>(*volume, board);
  }
};

}  // namespace

const MediumKind& volumeKind() {
  static const VolumeKind kind;
  return kind;
}

const MediumKind& billboardKind() {
  static const BillboardKind kind;
  return kind;
}

}  // namespace volute
