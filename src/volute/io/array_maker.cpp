// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// volute_array_maker DRIVER FILE UNIT: a netCDF (with HDF5 inside) or Zarr file for tests, with the
// array `soot` of 3 x 4 x 5 x 6 numbers along time, z, y and x, 1000 t + 100 z + 10 y + x tenths,
// as 16-bit integers with a scale, z from above; and `flat` with axes of no names. Coordinates are
// in UNIT, time in minutes. A fourth argument leaves out a number.
#include <gdal_priv.h>

#include <cstdio>
#include <numeric>
#include <string_view>

namespace {

using Dimensions = std::vector<std::shared_ptr<GDALDimension>>;

template <class T>
bool put(GDALMDArray& array, const std::vector<T>& values, GDALDataType type) {
  std::vector<GUInt64> start;
  std::vector<size_t> count;
  for (const auto& dimension : array.GetDimensions()) {
    start.push_back(0);
    count.push_back(static_cast<size_t>(dimension->GetSize()));
  }
  return array.Write(start.data(), count.data(), nullptr, nullptr,
                     GDALExtendedDataType::Create(type), values.data());
}

bool make(const char* driver, const char* file, const char* unit, bool hole) {
  GDALAllRegister();
  auto* maker = GetGDALDriverManager()->GetDriverByName(driver);
  const std::unique_ptr<GDALDataset> data(
      maker ? maker->CreateMultiDimensional(file, nullptr, nullptr) : nullptr);
  if (!data)
    return false;
  const auto root = data->GetRootGroup();
  constexpr GUInt64 kSize[] = {3, 4, 5, 6};
  constexpr const char* kNames[] = {"time", "z", "y", "x", nullptr};
  const auto doubles = GDALExtendedDataType::Create(GDT_Float64);
  Dimensions axes, nameless;
  for (int i = 0; i < 4; ++i) {
    const auto axis = root->CreateDimension(kNames[i], "", "", kSize[i], nullptr);
    axes.push_back(axis);
    nameless.push_back(root->CreateDimension("d" + std::to_string(i), "", "", kSize[i], nullptr));
    const auto coordinate = root->CreateMDArray(kNames[i], {axis}, doubles, nullptr);
    std::vector<double> places(kSize[i]);
    for (GUInt64 k = 0; k < kSize[i]; ++k)
      places[k] = i == 0 ? 5.0 + static_cast<double>(k)
                         : 0.5 * static_cast<double>(i == 1 ? kSize[i] - 1 - k : k);
    if (!coordinate->SetUnit(i == 0 ? "minutes since 2020-01-01" : unit) ||
        !put(*coordinate, places, GDT_Float64))
      return false;
  }
  std::vector<std::int16_t> numbers(3 * 4 * 5 * 6);
  std::iota(numbers.begin(), numbers.end(), std::int16_t{0});
  for (std::int16_t& n : numbers)
    n = static_cast<std::int16_t>(1000 * (n / 120) + 100 * (3 - n / 30 % 4) + 10 * (n / 6 % 5) +
                                  n % 6);
  if (hole)
    numbers[7] = -1;
  for (const bool named : {true, false}) {
    const auto array = root->CreateMDArray(named ? "soot" : "flat", named ? axes : nameless,
                                           GDALExtendedDataType::Create(GDT_Int16), nullptr);
    const std::int16_t none = -1;
    if (std::string_view(driver) == "Zarr" && named) {  // as xarray names them there
      const auto names = array->CreateAttribute("_ARRAY_DIMENSIONS", {4},
                                                GDALExtendedDataType::CreateString(), nullptr);
      if (!names || !names->Write(CSLConstList(kNames)))
        return false;
    }
    if (!array->SetRawNoDataValue(&none) || !array->SetScale(0.1) || !array->SetUnit("kg/m3") ||
        !put(*array, numbers, GDT_Int16))
      return false;
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc >= 4 && make(argv[1], argv[2], argv[3], argc > 4))
    return 0;
  std::fprintf(stderr, "%s: %s\n", argc > 2 ? argv[2] : "", CPLGetLastErrorMsg());
  return 1;
}
