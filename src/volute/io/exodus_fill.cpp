// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/exodus_fill.hpp"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkPointData.h>
#include <vtk_netcdf.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

namespace volute {
namespace {

/// Of the fields of nodes or of elements, in their order; empty where there are none.
std::vector<std::string> namesIn(int file, const char* variable) {
  constexpr std::size_t kMax = std::size_t{1} << 20;  // characters
  int id = 0, count = 0;
  std::array<int, 2> dimensions{};
  std::array<std::size_t, 2> sizes{};
  nc_type type = NC_NAT;
  if (nc_inq_varid(file, variable, &id) != NC_NOERR ||
      nc_inq_varndims(file, id, &count) != NC_NOERR || count != 2 ||
      nc_inq_vartype(file, id, &type) != NC_NOERR || type != NC_CHAR ||
      nc_inq_vardimid(file, id, dimensions.data()) != NC_NOERR ||
      nc_inq_dimlen(file, dimensions[0], &sizes[0]) != NC_NOERR ||
      nc_inq_dimlen(file, dimensions[1], &sizes[1]) != NC_NOERR || sizes[0] > kMax ||
      sizes[1] > kMax || sizes[0] * sizes[1] > kMax)
    return {};
  std::string text(sizes[0] * sizes[1], '\0');
  if (nc_get_var_text(file, id, text.data()) != NC_NOERR)
    return {};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < sizes[0]; ++i) {
    std::string name = text.substr(i * sizes[1], sizes[1]);
    name.resize(std::min(name.size(), name.find('\0')));
    name.resize(name.find_last_not_of(' ') + 1);
    names.push_back(std::move(name));
  }
  return names;
}

/// Of a variable, without 0: that is clear air, whatever else it stands for.
std::vector<double> fillsOf(int file, int variable) {
  std::vector<double> fills;
  for (const char* attribute : {"_FillValue", "missing_value"}) {
    std::size_t length = 0;
    double value = 0;
    if (nc_inq_attlen(file, variable, attribute, &length) == NC_NOERR && length == 1 &&
        nc_get_att_double(file, variable, attribute, &value) == NC_NOERR && value != 0)
      fills.push_back(value);
  }
  return fills;
}

bool areEqual(double a, double b) {
  return static_cast<float>(a) == static_cast<float>(b) || (std::isnan(a) && std::isnan(b));
}

}  // namespace

std::map<std::string, std::vector<double>> exodusFills(const std::filesystem::path& path) {
  std::map<std::string, std::vector<double>> fills;
  int file = 0, count = 0;
  if (nc_open(path.c_str(), NC_NOWRITE, &file) != NC_NOERR)
    return fills;
  const std::array<std::pair<std::string_view, std::vector<std::string>>, 2> kinds{
      {{"vals_nod_var", namesIn(file, "name_nod_var")},
       {"vals_elem_var", namesIn(file, "name_elem_var")}}};
  nc_inq_nvars(file, &count);
  for (int id = 0; id < count; ++id) {
    std::array<char, NC_MAX_NAME + 1> text{};
    nc_inq_varname(file, id, text.data());
    const std::string_view variable = text.data();
    for (const auto& [prefix, names] : kinds) {
      if (!variable.starts_with(prefix))
        continue;
      const std::vector<double> own = fillsOf(file, id);
      std::size_t number = 0;  // from 1; of element blocks a second one follows
      std::from_chars(variable.data() + prefix.size(), variable.data() + variable.size(), number);
      for (std::size_t i = 0; i < names.size(); ++i) {
        if (number == 0 || number == i + 1)  // old files have all fields of nodes in one variable
          std::ranges::copy(own, std::back_inserter(fills[names[i]]));
      }
    }
  }
  nc_close(file);
  return fills;
}

void settleFills(const std::map<std::string, std::vector<double>>& fills,
                 vtkUnstructuredGrid& grid) {
  for (vtkDataSetAttributes* data : {static_cast<vtkDataSetAttributes*>(grid.GetPointData()),
                                     static_cast<vtkDataSetAttributes*>(grid.GetCellData())}) {
    for (const auto& [name, own] : fills) {
      vtkDataArray* array = data->GetArray(name.c_str());
      if (!array || own.empty() || array->GetNumberOfComponents() != 1)
        continue;
      for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i) {
        const double value = array->GetComponent(i, 0);
        if (std::ranges::any_of(own, [&](double fill) { return areEqual(value, fill); }))
          array->SetComponent(i, 0, NC_FILL_DOUBLE);
      }
    }
  }
}

}  // namespace volute
