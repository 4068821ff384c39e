// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/vtu_writer.hpp"

#include <bit>
#include <cstdint>
#include <vector>

#include "volute/base/assert.hpp"
#include "volute/base/output_file.hpp"
#include "volute/io/xml_text.hpp"

namespace volute {
namespace {

constexpr const char* kOrder =
    std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";

/// Arrays behind the XML, each after its size in bytes.
class Appended {
 public:
  /// The element that says where the array is.
  template <class T>
  std::string add(std::span<const T> values, const char* type, std::string_view name,
                  int components = 1) {
    const std::string element = fmt::format(
        R"(<DataArray type="{}" Name="{}" NumberOfComponents="{}" format="appended" offset="{}"/>)",
        type, name, components, bytes_.size());
    const std::uint64_t size = values.size_bytes();
    append(std::as_bytes(std::span(&size, 1)));
    append(std::as_bytes(values));
    return element;
  }

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  void append(std::span<const std::byte> more) {
    bytes_.insert(bytes_.end(), more.begin(), more.end());
  }

  std::vector<std::byte> bytes_;
};

Status writeText(OutputFile& file, const std::string& text) {
  return file.write(std::as_bytes(std::span(text)));
}

}  // namespace

Status writeVtu(const std::filesystem::path& path, const TetMesh& mesh, const std::string& field,
                std::span<const float> values) {
  VOLUTE_ASSERT(values.size() == mesh.vertices().size());
  constexpr std::uint8_t kTetra = 10;
  const std::size_t count = mesh.tets().size();
  std::vector<std::int64_t> offsets(count);
  for (std::size_t i = 0; i < count; ++i) offsets[i] = static_cast<std::int64_t>(4 * (i + 1));
  const std::vector<std::uint8_t> types(count, kTetra);
  const std::span<const double> points(mesh.vertices().data()->data(), 3 * mesh.vertices().size());
  const std::span<const std::int32_t> connectivity(mesh.tets().data()->data(), 4 * count);
  Appended data;
  std::string xml = fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
      "byte_order=\"{}\" header_type=\"UInt64\">\n<UnstructuredGrid><Piece NumberOfPoints=\"{}\" "
      "NumberOfCells=\"{}\">\n",
      kOrder, values.size(), count);
  xml += "<PointData>" + data.add(values, "Float32", escapedXml(field)) + "</PointData>\n";
  xml += "<Points>" + data.add(points, "Float64", "points", 3) + "</Points>\n";
  xml += "<Cells>" + data.add(connectivity, "Int32", "connectivity") +
         data.add(std::span<const std::int64_t>(offsets), "Int64", "offsets") +
         data.add(std::span<const std::uint8_t>(types), "UInt8", "types") + "</Cells>\n";
  xml += "</Piece></UnstructuredGrid>\n<AppendedData encoding=\"raw\">_";
  VOLUTE_ASSIGN(auto file, OutputFile::create(path));
  VOLUTE_TRY(writeText(file, xml));
  VOLUTE_TRY(file.write(data.bytes()));
  VOLUTE_TRY(writeText(file, "</AppendedData></VTKFile>\n"));
  return file.commit();
}

Status writePvd(const std::filesystem::path& path, std::span<const SeriesFile> files) {
  std::string xml =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
  for (const SeriesFile& one : files)
    xml += fmt::format("<DataSet timestep=\"{}\" file=\"{}\"/>\n", one.time, escapedXml(one.name));
  xml += "</Collection>\n</VTKFile>\n";
  VOLUTE_ASSIGN(auto file, OutputFile::create(path));
  VOLUTE_TRY(writeText(file, xml));
  return file.commit();
}

}  // namespace volute
