// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/mesh_sight.hpp"

#include <algorithm>

#include "volute/media/smoke/tet_sight.hpp"

namespace volute {

std::string MeshSight::description() const {
  const SmokeDescription& smoke = smoke_->description();
  return fmt::format("{}: field '{}' as {} on tetrahedra", smoke.file, smoke_->fieldName(),
                     nameOf(smoke.model.quantity));
}

Result<std::unique_ptr<PointField>> MeshSight::conditions(std::string_view quantity) {
  // A list of fields costs reading the mesh once more.
  const auto later = [&]() -> const MeshFieldNames& {
    if (!names_)
      names_ = smoke_->source().fieldNames();
    return *names_;
  };
  const auto isAlone = [](const std::vector<std::string>& names) { return names.size() < 2; };
  if (smoke_->otherFields().empty() && air_.empty() && std::ranges::all_of(later(), isAlone))
    return fail(ErrorCode::kNotFound, "the mesh has no field but '{}'", smoke_->fieldName());
  if (!fields_) {
    VOLUTE_ASSIGN(auto described, smoke_->source().describe(0));
    fields_ = std::move(described.fields);
  }
  return meshConditions(smoke_->source(), quantity, air_, *fields_, later, gases_);
}

std::vector<Remark> MeshSight::remarksOn(double largest) const {
  std::vector<Remark> remarks = smoke_->remarksOn(largest, "");
  for (const auto& gas : gases_) {
    if (auto doubt = gas->doubt())
      remarks.push_back(std::move(*doubt).in(smoke_->source().path().string()));
  }
  return remarks;
}

Result<std::shared_ptr<const SightSnapshot>> MeshSight::readOwn(std::size_t time) {
  Progress quiet;
  VOLUTE_ASSIGN(auto read, smoke_->extinctionAt(time, quiet));
  if (locator_ != read.locator)
    locator_ = read.locator, ++meshes_;
  largest_ = std::max<double>(largest_, *std::ranges::max_element(read.values));
  return std::make_shared<const TetSightSnapshot>(locator_, std::move(read.values), meshes_);
}

}  // namespace volute
