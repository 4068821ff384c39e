// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_probe.hpp"

#include <cmath>
#include <map>
#include <utility>

#include "volute/media/fds/fds_conditions.hpp"

namespace volute {
namespace {

class FdsProbe final : public FieldProbe {
 public:
  FdsProbe(SmvIndex index, std::function<double(double)> caseTime, std::uint64_t maxMemory)
      : index_(std::move(index)), caseTime_(std::move(caseTime)), maxMemory_(maxMemory) {}

  /// A quantity that is not stored at that time is left out.
  Result<std::vector<ProbedField>> at(double time, const Vec3& place) override {
    std::vector<ProbedField> found;
    for (const std::string& quantity : fdsQuantities(index_)) {
      const Field& field = fieldOf(quantity);
      if (!field.values)
        continue;
      double value = 0;
      VOLUTE_TRY(field.values->at(caseTime_(time), {&place, 1}, {&value, 1}));
      if (std::isfinite(value))
        found.push_back({quantity, {value}, field.unit});
    }
    return found;
  }

 private:
  struct Field {
    std::unique_ptr<PointField> values;  ///< null: it cannot be read
    std::string unit;
  };

  const Field& fieldOf(const std::string& quantity) {
    const auto [at, fresh] = fields_.try_emplace(quantity);
    if (!fresh)
      return at->second;
    if (auto stored = fdsStored(index_, quantity, maxMemory_))
      at->second = {std::move(stored->first), std::move(stored->second)};
    return at->second;
  }

  SmvIndex index_;
  std::function<double(double)> caseTime_;
  std::uint64_t maxMemory_;
  std::map<std::string, Field> fields_;
};

}  // namespace

std::unique_ptr<FieldProbe> fdsProbe(SmvIndex index, std::function<double(double)> caseTime,
                                     std::uint64_t maxMemory) {
  return std::make_unique<FdsProbe>(std::move(index), std::move(caseTime), maxMemory);
}

}  // namespace volute
