// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/plan_vti.hpp"

#include <cmath>
#include <cstdint>
#include <iterator>

#include "volute/base/assert.hpp"
#include "volute/base/output_file.hpp"
#include "volute/io/xml_text.hpp"

namespace volute {
namespace {

Status writeText(OutputFile& file, std::string_view text) {
  return file.write(std::as_bytes(std::span(text)));
}

}  // namespace

Status writePlanVti(const std::filesystem::path& path, const FloorPlan& plan,
                    const std::vector<PlanArray>& arrays) {
  VOLUTE_ASSIGN(auto file, OutputFile::create(path));
  const std::uint64_t bytes = plan.size() * sizeof(float);
  std::string head = fmt::format(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n"
      "<ImageData WholeExtent=\"0 {0} 0 {1} 0 0\" Origin=\"{2} {3} {4}\" Spacing=\"{5} {5} {5}\">\n"
      "<Piece Extent=\"0 {0} 0 {1} 0 0\">\n<CellData>\n",
      plan.nx, plan.ny, plan.origin[0] - 0.5 * plan.step, plan.origin[1] - 0.5 * plan.step,
      plan.origin[2], plan.step);
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    VOLUTE_ASSERT(arrays[i].values.size() == plan.size());
    head +=
        fmt::format("<DataArray type=\"Float32\" Name=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
                    escapedXml(arrays[i].name), i * (bytes + sizeof bytes));
  }
  VOLUTE_TRY(writeText(file, head + "</CellData>\n</Piece>\n</ImageData>\n"
                                    "<AppendedData encoding=\"raw\">\n_"));
  for (const PlanArray& array : arrays) {
    VOLUTE_TRY(file.write(std::as_bytes(std::span(&bytes, 1))));
    VOLUTE_TRY(file.write(std::as_bytes(std::span(array.values))));
  }
  VOLUTE_TRY(writeText(file, "\n</AppendedData>\n</VTKFile>\n"));
  return file.commit();
}

Status writePlanCsv(const std::filesystem::path& path, const FloorPlan& plan,
                    const std::vector<PlanArray>& arrays) {
  std::string text = "x,y,z";
  for (const PlanArray& array : arrays) {
    VOLUTE_ASSERT(array.values.size() == plan.size());
    text += "," + array.name;
  }
  text += "\n";
  for (std::size_t i = 0; i < plan.size(); ++i) {
    if (!plan.walkable(i))
      continue;
    const Vec3 at = plan.at(i);
    fmt::format_to(std::back_inserter(text), "{:.10g},{:.10g},{:.10g}", at.x(), at.y(), at.z());
    for (const PlanArray& array : arrays) {
      if (std::isnan(array.values[i]))
        text += ",";
      else
        fmt::format_to(std::back_inserter(text), ",{:.7g}", array.values[i]);
    }
    text += "\n";
  }
  VOLUTE_ASSIGN(auto file, OutputFile::create(path));
  VOLUTE_TRY(writeText(file, text));
  return file.commit();
}

Status writePvd(const std::filesystem::path& path,
                const std::vector<std::pair<double, std::string>>& files) {
  VOLUTE_ASSIGN(auto file, OutputFile::create(path));
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n";
  for (const auto& [time, name] : files)
    text +=
        fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", time, escapedXml(name));
  VOLUTE_TRY(writeText(file, text + "</Collection>\n</VTKFile>\n"));
  return file.commit();
}

}  // namespace volute
