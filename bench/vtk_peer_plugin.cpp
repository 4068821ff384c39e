// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// VTK's mappers for volumes of tetrahedra, drawn by OpenGL without a display.
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <vtkActor.h>
#include <vtkAutoInit.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkColorTransferFunction.h>
#include <vtkFloatArray.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLProjectedTetrahedraMapper.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridBunykRayCastFunction.h>
#include <vtkUnstructuredGridVolumeRayCastMapper.h>
#include <vtkUnstructuredGridVolumeZSweepMapper.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "bench/smoke_peer.hpp"
#include "volute/base/process_usage.hpp"

VTK_MODULE_INIT(vtkRenderingOpenGL2);
VTK_MODULE_INIT(vtkRenderingVolumeOpenGL2);

namespace volute::bench {
namespace {

/// Draws in the context that is current. GLEW, which VTK asks for OpenGL's functions, finds them
/// and then complains that there is no X server: that alone makes VTK's own window give up.
class Window final : public vtkGenericOpenGLRenderWindow {
 public:
  static Window* New();

  vtkTypeMacro(Window, vtkGenericOpenGLRenderWindow)

      void OpenGLInitContext() override {
    vtkObject::GlobalWarningDisplayOff();
    Superclass::OpenGLInitContext();
    GlewInitValid = true;
    vtkObject::GlobalWarningDisplayOn();
  }
};

vtkStandardNewMacro(Window)

    Status makeContextCurrent() {
  const auto failed = [] {
    return fail(ErrorCode::kUnsupported, "OpenGL cannot draw without a display here");
  };
  EGLDisplay display =
      eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr))
    return failed();
  eglBindAPI(EGL_OPENGL_API);
  const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                           EGL_NONE};
  EGLConfig config{};
  EGLint count = 0;
  eglChooseConfig(display, wanted, &config, 1, &count);
  const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION,
                            4,
                            EGL_CONTEXT_MINOR_VERSION,
                            5,
                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                            EGL_CONTEXT_OPENGL_COMPATIBILITY_PROFILE_BIT,
                            EGL_NONE};
  EGLContext context =
      count > 0 ? eglCreateContext(display, config, EGL_NO_CONTEXT, version) : EGL_NO_CONTEXT;
  const EGLint size[] = {EGL_WIDTH, 16, EGL_HEIGHT, 16, EGL_NONE};
  EGLSurface surface = count > 0 ? eglCreatePbufferSurface(display, config, size) : EGL_NO_SURFACE;
  if (context == EGL_NO_CONTEXT || !eglMakeCurrent(display, surface, surface, context))
    return failed();
  return {};
}

vtkSmartPointer<vtkUnstructuredGrid> gridOf(const TetMesh& mesh) {
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  vtkNew<vtkPoints> points;
  points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.vertices().size()));
  for (std::size_t i = 0; i < mesh.vertices().size(); ++i)
    points->SetPoint(static_cast<vtkIdType>(i), mesh.vertices()[i].data());
  grid->SetPoints(points);
  vtkNew<vtkCellArray> cells;
  for (const Tet& tet : mesh.tets()) {
    const vtkIdType ids[4] = {tet[0], tet[1], tet[2], tet[3]};
    cells->InsertNextCell(4, ids);
  }
  grid->SetCells(VTK_TETRA, cells);
  return grid;
}

vtkSmartPointer<vtkUnstructuredGridVolumeMapper> mapperOf(PeerMapper kind) {
  switch (kind) {
    case PeerMapper::kRayCaster: {
      auto mapper = vtkSmartPointer<vtkUnstructuredGridVolumeRayCastMapper>::New();
      mapper->SetRayCastFunction(vtkNew<vtkUnstructuredGridBunykRayCastFunction>());
      mapper->SetAutoAdjustSampleDistances(0);
      mapper->SetImageSampleDistance(1);
      mapper->SetNumberOfThreads(static_cast<int>(std::thread::hardware_concurrency()));
      mapper->IntermixIntersectingGeometryOn();
      return mapper;
    }
    case PeerMapper::kZSweep: {
      auto mapper = vtkSmartPointer<vtkUnstructuredGridVolumeZSweepMapper>::New();
      mapper->SetAutoAdjustSampleDistances(0);
      mapper->SetImageSampleDistance(1);
      mapper->IntermixIntersectingGeometryOn();
      return mapper;
    }
    case PeerMapper::kProjectedTetrahedra:
      break;
  }
  auto mapper = vtkSmartPointer<vtkOpenGLProjectedTetrahedraMapper>::New();
  mapper->UseFloatingPointFrameBufferOff();  // with it VTK 9.1 draws nothing into this window
  return mapper;
}

class VtkPeer final : public SmokePeer {
 public:
  VtkPeer(PeerMapper kind, const PeerScene& scene) {
    grid_ = gridOf(*scene.mesh);
    float most = 1e-6F;
    for (const auto& field : *scene.extinction) {
      fields_.push_back(vtkSmartPointer<vtkFloatArray>::New());
      fields_.back()->SetName("extinction");
      fields_.back()->SetNumberOfValues(static_cast<vtkIdType>(field.size()));
      std::ranges::copy(field, fields_.back()->GetPointer(0));
      most = std::max(most, *std::ranges::max_element(field));
    }
    grid_->GetPointData()->SetScalars(fields_[0]);
    vtkNew<vtkPiecewiseFunction> opacity;
    opacity->AddPoint(0, 0);
    opacity->AddPoint(most, 1);
    vtkNew<vtkColorTransferFunction> white;
    white->AddRGBPoint(0, 1, 1, 1);
    white->AddRGBPoint(most, 1, 1, 1);
    vtkNew<vtkVolumeProperty> property;
    property->SetScalarOpacity(opacity);
    property->SetColor(white);
    property->ShadeOff();
    property->SetInterpolationTypeToLinear();
    property->SetScalarOpacityUnitDistance(1 / most);  // extinction = scalar
    auto mapper = mapperOf(kind);
    mapper->SetInputData(grid_);
    vtkNew<vtkVolume> volume;
    volume->SetProperty(property);
    volume->SetMapper(mapper);
    renderer_->AddVolume(volume);
    renderer_->SetBackground(0, 0, 0);
    vtkNew<vtkPolyDataMapper> signMapper;
    signMapper->SetInputData(sign_);
    signActor_->SetMapper(signMapper);
    signActor_->GetProperty()->SetColor(0, 0, 0);
    signActor_->GetProperty()->LightingOff();
    renderer_->AddActor(signActor_);
    window_->SetIsCurrent(true);
    window_->SetReadyForRendering(true);
    window_->SetSupportsOpenGL(true);
    window_->SetIsDirect(1);
    window_->SetOwnContext(0);
    window_->SetMultiSamples(0);
    window_->AddRenderer(renderer_);
  }

  Result<PeerTimes> draw(const PeerView& view, std::span<float> opacity) override {
    if (field_ != view.field) {
      grid_->GetPointData()->SetScalars(fields_[static_cast<std::size_t>(view.field)]);
      grid_->Modified();
      field_ = view.field;
    }
    window_->SetSize(view.width, view.height);
    setCamera(view);
    setSign(view);
    vtkNew<vtkUnsignedCharArray> pixels;
    const auto begin = std::chrono::steady_clock::now();
    const double cpu = cpuSeconds();
    window_->Render();
    window_->GetPixelData(0, 0, view.width - 1, view.height - 1, 0, pixels, 0);
    PeerTimes times;
    times.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    times.cpu = cpuSeconds() - cpu;
    if (pixels->GetNumberOfValues() != vtkIdType{3} * view.width * view.height)
      return fail(ErrorCode::kUnsupported, "VTK drew no picture");
    for (int y = 0; y < view.height; ++y) {
      for (int x = 0; x < view.width; ++x) {
        opacity[static_cast<std::size_t>(y) * view.width + x] =
            pixels->GetValue(3 * (vtkIdType{view.height - 1 - y} * view.width + x)) / 255.0F;
      }
    }
    return times;
  }

 private:
  void setCamera(const PeerView& view) {
    vtkCamera* camera = renderer_->GetActiveCamera();
    camera->SetPosition(view.eye);
    camera->SetFocalPoint(view.target);
    camera->SetViewUp(0, 0, 1);
    camera->SetViewAngle(view.fov);
    const double* box = grid_->GetBounds();
    double far = 0;
    for (int k = 0; k < 3; ++k)
      far += std::max(std::abs(box[2 * k] - view.eye[k]), std::abs(box[2 * k + 1] - view.eye[k]));
    camera->SetClippingRange(0.02, far);
  }

  void setSign(const PeerView& view) {
    signActor_->SetVisibility(view.hasSign);
    if (!view.hasSign)
      return;
    vtkNew<vtkPoints> points;
    for (const auto& corner : view.sign) points->InsertNextPoint(corner);
    vtkNew<vtkCellArray> cells;
    const vtkIdType ids[4] = {0, 1, 2, 3};
    cells->InsertNextCell(4, ids);
    sign_->SetPoints(points);
    sign_->SetPolys(cells);
  }

  vtkSmartPointer<vtkUnstructuredGrid> grid_;
  std::vector<vtkSmartPointer<vtkFloatArray>> fields_;
  int field_ = 0;
  vtkNew<vtkPolyData> sign_;
  vtkNew<vtkActor> signActor_;
  vtkNew<vtkRenderer> renderer_;
  vtkNew<Window> window_;
};

Result<std::unique_ptr<SmokePeer>> makePeer(PeerMapper mapper, const PeerScene& scene) {
  VOLUTE_TRY(makeContextCurrent());
  return std::make_unique<VtkPeer>(mapper, scene);
}

}  // namespace
}  // namespace volute::bench

extern "C" const volute::bench::SmokePeerPlugin* voluteSmokePeers() {
  static constexpr volute::bench::SmokePeerPlugin kPlugin{volute::bench::makePeer};
  return &kPlugin;
}
