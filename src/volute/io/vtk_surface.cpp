// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <vtkCellArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolygon.h>
#include <vtkXMLPolyDataReader.h>

#include "volute/io/surface.hpp"
#include "volute/io/vtk_errors.hpp"
#include "volute/io/vtk_xml.hpp"

namespace volute {
namespace {

/// Cells whose corners are all there.
Status checkCell(vtkIdType size, const vtkIdType* ids, vtkIdType points, const std::string& file) {
  for (vtkIdType i = 0; i < size; ++i) {
    if (ids[i] < 0 || ids[i] >= points)
      return fail(ErrorCode::kInvalidData, "{}: a polygon names point {} of {}", file, ids[i],
                  points);
  }
  return {};
}

class SurfaceCopy {
 public:
  SurfaceCopy(vtkPolyData* data, std::string file) : data_(data), file_(std::move(file)) {}

  Result<TriangleMesh> copy() {
    mesh_.materials.emplace_back();
    for (vtkIdType i = 0; i < data_->GetNumberOfPoints(); ++i) {
      if (!pointAt(i).allFinite())
        return fail(ErrorCode::kInvalidData, "{}: point {} is not finite", file_, i);
    }
    VOLUTE_TRY(addPolygons(data_->GetPolys()));
    VOLUTE_TRY(addStrips(data_->GetStrips()));
    if (mesh_.triangles.empty())
      return fail(ErrorCode::kInvalidData, "{}: has no polygons or strips", file_);
    return std::move(mesh_);
  }

 private:
  Vec3 pointAt(vtkIdType id) const {
    Vec3 point;
    data_->GetPoint(id, point.data());
    return point;
  }

  void add(vtkIdType a, vtkIdType b, vtkIdType c) {
    mesh_.triangles.push_back({{pointAt(a), pointAt(b), pointAt(c)}, 0});
  }

  Status addPolygons(vtkCellArray* cells) {
    vtkIdType size = 0;
    const vtkIdType* ids = nullptr;
    for (cells->InitTraversal(); cells->GetNextCell(size, ids);) {
      VOLUTE_TRY(checkCell(size, ids, data_->GetNumberOfPoints(), file_));
      if (size < 5) {
        for (vtkIdType i = 1; i + 1 < size; ++i) add(ids[0], ids[i], ids[i + 1]);
        continue;
      }
      vtkNew<vtkPolygon> polygon;  // may be hollow: its ears are cut
      polygon->Initialize(static_cast<int>(size), ids, data_->GetPoints());
      vtkNew<vtkIdList> triangles;
      if (polygon->Triangulate(triangles) == 0)
        return fail(ErrorCode::kInvalidData, "{}: a polygon of {} corners crosses itself", file_,
                    size);
      for (vtkIdType i = 0; i + 2 < triangles->GetNumberOfIds(); i += 3)
        add(ids[triangles->GetId(i)], ids[triangles->GetId(i + 1)], ids[triangles->GetId(i + 2)]);
    }
    return {};
  }

  Status addStrips(vtkCellArray* cells) {
    vtkIdType size = 0;
    const vtkIdType* ids = nullptr;
    for (cells->InitTraversal(); cells->GetNextCell(size, ids);) {
      VOLUTE_TRY(checkCell(size, ids, data_->GetNumberOfPoints(), file_));
      for (vtkIdType i = 0; i + 2 < size; ++i)
        i % 2 == 0 ? add(ids[i], ids[i + 1], ids[i + 2]) : add(ids[i], ids[i + 2], ids[i + 1]);
    }
    return {};
  }

  vtkPolyData* data_;
  std::string file_;
  TriangleMesh mesh_;
};

Result<TriangleMesh> readVtp(const std::filesystem::path& path) {
  VOLUTE_TRY(readVtkXml(path));
  const ErrorWatch watch;
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  VOLUTE_TRY(watch.status(path.string()));
  return SurfaceCopy(reader->GetOutput(), path.string()).copy();
}

}  // namespace
}  // namespace volute

extern "C" const volute::SurfacePlugin* voluteVtkSurfacePlugin() {
  static constexpr volute::SurfacePlugin kPlugin{volute::readVtp};
  return &kPlugin;
}
