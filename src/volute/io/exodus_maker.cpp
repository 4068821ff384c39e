// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Writes the Exodus file that mesh_cases_test.cpp reads: two hexahedra, two instants. With a value
// after its name, that is the smoke's _FillValue, and all that stands at the second instant; with
// another word, a vector has that name, 10 along x.
#include <vtkDoubleArray.h>
#include <vtkExodusIIWriter.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridAlgorithm.h>
#include <vtk_netcdf.h>

#include <cstdlib>
#include <vector>

namespace {

/// Smoke is 1 + x at 10 s, 3 + x at 20 s.
class Box final : public vtkUnstructuredGridAlgorithm {
 public:
  static Box* New();

  const char* vector = nullptr;  ///< the name of one

  vtkTypeMacro(Box, vtkUnstructuredGridAlgorithm)

      Box() {
    SetNumberOfInputPorts(0);
  }

  int RequestInformation(vtkInformation*, vtkInformationVector**,
                         vtkInformationVector* out) override {
    const double times[] = {10, 20};
    vtkInformation* info = out->GetInformationObject(0);
    info->Set(vtkStreamingDemandDrivenPipeline::TIME_STEPS(), times, 2);
    info->Set(vtkStreamingDemandDrivenPipeline::TIME_RANGE(), times, 2);
    return 1;
  }

  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* out) override {
    vtkInformation* info = out->GetInformationObject(0);
    auto* grid = vtkUnstructuredGrid::GetData(info);
    double time = 10;
    if (info->Has(vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP()))
      time = info->Get(vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP());
    vtkNew<vtkPoints> points;
    vtkNew<vtkDoubleArray> smoke;
    smoke->SetName("smoke");
    for (int i = 0; i < 12; ++i) {
      const double x = i % 3;
      points->InsertNextPoint(x, i / 3 % 2, i / 6);
      smoke->InsertNextValue((time < 15 ? 1 : 3) + x);
    }
    grid->SetPoints(points);
    grid->Allocate(2);
    for (vtkIdType first : {0, 1}) {
      const vtkIdType ids[8] = {first,     first + 1, first + 4,  first + 3,
                                first + 6, first + 7, first + 10, first + 9};
      grid->InsertNextCell(VTK_HEXAHEDRON, 8, ids);
    }
    grid->GetPointData()->AddArray(smoke);
    if (vector) {
      vtkNew<vtkDoubleArray> along;
      along->SetName(vector);
      along->SetNumberOfComponents(3);
      for (int i = 0; i < 12; ++i) along->InsertNextTuple3(10, 0, 0);
      grid->GetPointData()->AddArray(along);
    }
    grid->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), time);
    return 1;
  }
};

vtkStandardNewMacro(Box)

    bool fillSecond(const char* path, double fill) {
  constexpr std::size_t kPoints = 12;
  const std::size_t begin[] = {1, 0}, size[] = {1, kPoints};
  const std::vector<double> values(kPoints, fill);
  int file = 0, variable = 0;
  return nc_open(path, NC_WRITE, &file) == NC_NOERR && nc_redef(file) == NC_NOERR &&
         nc_inq_varid(file, "vals_nod_var1", &variable) == NC_NOERR &&
         nc_put_att_double(file, variable, "_FillValue", NC_DOUBLE, 1, &fill) == NC_NOERR &&
         nc_enddef(file) == NC_NOERR &&
         nc_put_vara_double(file, variable, begin, size, values.data()) == NC_NOERR &&
         nc_close(file) == NC_NOERR;
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 2)
    return 2;
  vtkNew<Box> box;
  char* end = nullptr;
  const double fill = count > 2 ? std::strtod(arguments[2], &end) : 0;
  const bool fills = count > 2 && *end == '\0';
  if (count > 2 && !fills)
    box->vector = arguments[2];
  vtkNew<vtkExodusIIWriter> writer;
  writer->SetFileName(arguments[1]);
  writer->SetInputConnection(box->GetOutputPort());
  writer->WriteAllTimeStepsOn();
  const bool written = writer->Write() != 0;
  return written && (!fills || fillSecond(arguments[1], fill)) ? 0 : 1;
}
