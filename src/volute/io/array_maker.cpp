// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// volute_array_maker DRIVER FILE UNIT: a netCDF (with HDF5 inside) or Zarr file for tests, with the
// array `soot` of 3 x 4 x 5 x 6 numbers along time, z, y and x, 1000 t + 100 z + 10 y + x tenths,
// as 16-bit integers with a scale, z from above; and `flat` with axes of no names. Coordinates are
// in UNIT, time in minutes. A fourth argument leaves out a number; but "apart" gives soot the
// dimensions t_soot, z_soot, y_soot, x_soot of 3, 4, 5, 2 and c of 3, and "axis" others than these
// that CF's attribute names.
// volute_array_maker HDF5 FILE KIND: files of HDF5 that GDAL does not write, with `soot` of 3 x 2 x
// 2 x 2 ones: KIND is virtual, external, link (all over other.h5), self (virtual over `source` in
// itself), hole (frame 1 is not written), never (nothing is), open (as hole, without a fill value)
// or filter (packed by one that nobody has).
#include <gdal_priv.h>
#if VOLUTE_HAS_HDF5
#include <hdf5.h>
#endif

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

bool make(const char* driver, const char* file, const char* unit, std::string_view how) {
  const bool apart = how == "apart", stated = how == "axis";
  const bool coloured = apart || stated, hole = !how.empty() && !coloured;
  GDALAllRegister();
  auto* maker = GetGDALDriverManager()->GetDriverByName(driver);
  const std::unique_ptr<GDALDataset> data(
      maker ? maker->CreateMultiDimensional(file, nullptr, nullptr) : nullptr);
  if (!data)
    return false;
  const auto root = data->GetRootGroup();
  const std::vector<GUInt64> size =
      coloured ? std::vector<GUInt64>{3, 4, 5, 2, 3} : std::vector<GUInt64>{3, 4, 5, 6};
  const char* const kNames[] = {apart    ? "t_soot"
                                : stated ? "when"
                                         : "time",
                                apart    ? "z_soot"
                                : stated ? "up"
                                         : "z",
                                apart    ? "y_soot"
                                : stated ? "north"
                                         : "y",
                                apart    ? "x_soot"
                                : stated ? "east"
                                         : "x",
                                coloured ? "c" : nullptr,
                                nullptr};
  constexpr const char* kAxes[] = {"T", "Z", "Y", "X"};
  const auto doubles = GDALExtendedDataType::Create(GDT_Float64);
  Dimensions axes, nameless;
  for (std::size_t i = 0; i < size.size(); ++i) {
    const auto axis = root->CreateDimension(kNames[i], "", "", size[i], nullptr);
    axes.push_back(axis);
    nameless.push_back(root->CreateDimension("d" + std::to_string(i), "", "", size[i], nullptr));
    if (i == 4)
      continue;
    const auto coordinate = root->CreateMDArray(kNames[i], {axis}, doubles, nullptr);
    std::vector<double> places(size[i]);
    for (GUInt64 k = 0; k < size[i]; ++k)
      places[k] = i == 0 ? 5.0 + static_cast<double>(k)
                         : 0.5 * static_cast<double>(i == 1 ? size[i] - 1 - k : k);
    if (stated) {
      const auto said =
          coordinate->CreateAttribute("axis", {}, GDALExtendedDataType::CreateString(), nullptr);
      if (!said || !said->Write(kAxes[i]))
        return false;
    }
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
      const auto names = array->CreateAttribute("_ARRAY_DIMENSIONS", {size.size()},
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

#if VOLUTE_HAS_HDF5
bool makeHdf5(const char* name, std::string_view kind) {
  constexpr hsize_t kSize[] = {3, 2, 2, 2}, kFrame[] = {1, 2, 2, 2};
  const std::vector<float> ones(24, 1.0F);
  const hid_t file = H5Fcreate(name, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  if (kind == "link")
    return H5Lcreate_external("other.h5", "/soot", file, "soot", H5P_DEFAULT, H5P_DEFAULT) >= 0 &&
           H5Fclose(file) >= 0;
  const hid_t space = H5Screate_simple(4, kSize, nullptr), how = H5Pcreate(H5P_DATASET_CREATE);
  constexpr float kSeven = 7;
  bool good = true;
  if (kind == "virtual") {
    good = H5Pset_virtual(how, space, "other.h5", "/soot", space) >= 0;
  } else if (kind == "self") {
    good = H5Pset_virtual(how, space, ".", "/source", space) >= 0;
    const hid_t source =
        H5Dcreate2(file, "source", H5T_NATIVE_FLOAT, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    good =
        good && H5Dwrite(source, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, ones.data()) >= 0;
    H5Dclose(source);
  } else if (kind == "external") {
    good = H5Pset_external(how, "other.bin", 0, 96) >= 0;
  } else if (kind == "hole" || kind == "open" || kind == "filter") {
    good = H5Pset_chunk(how, 4, kFrame) >= 0;
  }
  if (kind == "open")
    good = good && H5Pset_fill_time(how, H5D_FILL_TIME_NEVER) >= 0;
  else
    good = good && H5Pset_fill_value(how, H5T_NATIVE_FLOAT, &kSeven) >= 0;
  if (kind == "filter")
    good = good && H5Pset_filter(how, 511, H5Z_FLAG_OPTIONAL, 0, nullptr) >= 0;
  const hid_t set =
      H5Dcreate2(file, "soot", H5T_NATIVE_FLOAT, space, H5P_DEFAULT, how, H5P_DEFAULT);
  const bool written = kind == "hole" || kind == "open" || kind == "filter";
  for (hsize_t frame = 0; good && written && frame < 3; ++frame) {
    const hsize_t start[] = {frame, 0, 0, 0};
    if (frame != 1 || kind == "filter")
      good = H5Dwrite_chunk(set, H5P_DEFAULT, 0, start, 32, ones.data()) >= 0;
  }
  return good && H5Dclose(set) >= 0 && H5Pclose(how) >= 0 && H5Sclose(space) >= 0 &&
         H5Fclose(file) >= 0;
}
#endif

}  // namespace

int main(int argc, char** argv) {
#if VOLUTE_HAS_HDF5
  if (argc == 4 && std::string_view(argv[1]) == "HDF5")
    return makeHdf5(argv[2], argv[3]) ? 0 : 1;
#endif
  if (argc >= 4 && make(argv[1], argv[2], argv[3], argc > 4 ? argv[4] : ""))
    return 0;
  std::fprintf(stderr, "%s: %s\n", argc > 2 ? argv[2] : "", CPLGetLastErrorMsg());
  return 1;
}
