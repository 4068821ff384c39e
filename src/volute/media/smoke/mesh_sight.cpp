// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/mesh_sight.hpp"

#include <cmath>
#include <utility>

#include "volute/media/smoke/smoke_words.hpp"
#include "volute/media/smoke/tet_sight.hpp"

namespace volute {

Result<std::unique_ptr<MeshSight>> MeshSight::open(MeshSource source,
                                                   std::optional<MeshSource> density,
                                                   const SmokeModel& model,
                                                   const std::string& name) {
  std::unique_ptr<MeshSight> sight(
      new MeshSight(std::move(source), std::move(density), model, name));
  if (const std::string absent = sight->source_.absentText(); !absent.empty())
    sight->remarks_.push_back(
        Remark(RemarkCode::kLeftOut, fmt::format("{}: {}", name, absent)).in(name));
  VOLUTE_ASSIGN(sight->first_, sight->read(0));
  sight->bounds_ = sight->locator_->mesh().bounds();
  return sight;
}

void MeshSight::remarkOnOthers() {
  if (!otherFields_.empty()) {
    remarks_.push_back(Remark(RemarkCode::kAssumed,
                              fmt::format("{}: the field '{}' is read; it also has {}", name_,
                                          fieldName_, otherFields_),
                              {Hint::choose("field")})
                           .in(name_));
  }
}

Result<std::unique_ptr<PointField>> MeshSight::conditions(std::string_view quantity) {
  // A list of fields costs reading the mesh once more.
  if (otherFields_.empty() && air_.empty())
    return fail(ErrorCode::kNotFound, "the mesh has no field but '{}'", fieldName_);
  if (!fields_) {
    VOLUTE_ASSIGN(auto described, source_.describe(0));
    fields_ = std::move(described.fields);
  }
  return meshConditions(name_, maxMemory_, quantity, air_, *fields_);
}

Result<std::shared_ptr<const SightInstant>> MeshSight::readOwn(std::size_t time) {
  if (time == 0 && first_)
    return std::exchange(first_, nullptr);
  VOLUTE_ASSIGN(const auto frame, source_.read(time));
  if (fieldName_.empty() && frame.dimensions) {
    VOLUTE_ASSIGN(const std::string unit,
                  compareDimensions(*frame.dimensions, model_,
                                    fmt::format("{}: field '{}'", name_, frame.field)));
    if (!unit.empty())
      remarks_.push_back({RemarkCode::kDoubtful, unit});
  }
  fieldName_ = frame.field;
  otherFields_ = frame.others;
  std::vector<float> density;
  if (density_) {
    VOLUTE_ASSIGN(auto gas, density_->read(time));
    density = std::move(gas.values);
  }
  std::vector<float> extinction(frame.values.size());
  model_.extinction(frame.values, density, extinction);
  for (const float value : extinction) {
    if (!std::isfinite(value)) {
      return fail(ErrorCode::kInvalidData, {Hint::choose("field"), Hint::set("quantity")},
                  "{}: field '{}' at {} s gives an extinction of {} 1/m; a visibility of 0 m has "
                  "none",
                  name_, frame.field, times()[time], value);
    }
  }
  if (!locator_ || &locator_->mesh() != frame.mesh.get()) {
    locator_ = std::make_shared<const TetLocator>(frame.mesh);
    ++meshes_;
  }
  return std::make_shared<const TetInstant>(locator_, std::move(extinction), meshes_);
}

}  // namespace volute
