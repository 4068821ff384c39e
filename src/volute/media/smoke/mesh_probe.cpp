// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/mesh_probe.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "volute/media/smoke/mesh_air.hpp"

namespace volute {
namespace {

class MeshProbe final : public FieldProbe {
 public:
  MeshProbe(MeshSource source, std::string shown, std::string unit,
            std::function<double(double)> caseTime)
      : source_(std::move(source)),
        shown_(std::move(shown)),
        unit_(std::move(unit)),
        caseTime_(std::move(caseTime)) {}

  Result<std::vector<ProbedField>> at(double time, const Vec3& place) override {
    VOLUTE_TRY(open());
    std::vector<ProbedField> found;
    for (const auto& [name, field] : fields_) {
      const auto times = field->times();
      const double stored = std::clamp(caseTime_(time), times.front(), times.back());
      double value = 0;
      VOLUTE_TRY(field->at(stored, {&place, 1}, {&value, 1}));
      if (std::isfinite(value))
        found.push_back({name, {value}, name == shown_ ? unit_ : ""});
    }
    return found;
  }

 private:
  Status open() {
    if (!fields_.empty())
      return {};
    VOLUTE_ASSIGN(const auto described, source_.describe(0));
    for (const MeshFieldSummary& field : described.fields) {
      if (field.components != 1)
        continue;
      if (auto opened = meshField(source_, field.name))
        fields_.emplace_back(field.name, std::move(*opened));
    }
    return {};
  }

  MeshSource source_;
  std::string shown_, unit_;
  std::function<double(double)> caseTime_;
  std::vector<std::pair<std::string, std::unique_ptr<PointField>>> fields_;
};

}  // namespace

std::unique_ptr<FieldProbe> meshProbe(MeshSource source, std::string shown, std::string unit,
                                      std::function<double(double)> caseTime) {
  return std::make_unique<MeshProbe>(std::move(source), std::move(shown), std::move(unit),
                                     std::move(caseTime));
}

}  // namespace volute
