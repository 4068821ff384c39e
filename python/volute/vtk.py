# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
""".volute files in VTK and ParaView.

    import volute.vtk
    reader = volute.vtk.Reader()
    reader.SetFileName("fire.volute")
    reader.Update()                          # vtkImageData: cell values, sizes and bounds in metres, times in seconds

In ParaView: Tools, Manage Plugins, Load New: this file; then File, Open reads .volute files. ParaView's Python must find the package
(PYTHONPATH). A time step decodes its frame; SetRegion() limits decoding to a region. ParaView 5.11 with Python 3.11, as in Debian 12,
cannot load Python plug-ins; type "import volute.vtk" in its Python shell instead."""
import inspect

import numpy as np
from vtkmodules.numpy_interface import dataset_adapter
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline

import volute

if not hasattr(inspect, "getargspec"):  # ParaView 5.11 asks for it, Python 3.11 has it no more
    inspect.getargspec = inspect.getfullargspec
try:
    from paraview.util.vtkAlgorithm import smdomain, smhint, smproperty, smproxy
except ImportError:  # VTK alone
    smproxy = None


class Reader(VTKPythonAlgorithmBase):
    """A .volute file as vtkImageData: a cell array named like the file's values, with 1 or 3 components (float32)."""

    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkImageData")
        self._name = None
        self._volume = None
        self._region = None

    def SetFileName(self, name):
        if name != self._name:
            self._name, self._volume = name, None
            self.Modified()

    def GetFileName(self):
        return self._name

    def SetRegion(self, *bounds):
        """x0, x1, y0, y1, z0, z1 in voxels, half-open: only this region is decoded. None: everything."""
        self._region = tuple(int(v) for v in bounds) or None
        self.Modified()

    def GetTimestepValues(self):
        """Times of the frames [s]."""
        return None if self._name in (None, "None") else self._open().times.tolist()

    def _open(self):
        if self._volume is None:
            opened = volute.open(self._name)
            if opened.matrices is not None:
                raise ValueError(f"{self._name}: '{opened.name}' is turned, sheared or mirrored, or moves by parts of a voxel; lay it along the axes "
                                 "by volute.resample()")
            self._volume = opened
        return self._volume

    def _box(self):
        z, y, x = self._open().shape[1:4]
        box = self._region or (0, x, 0, y, 0, z)
        if len(box) != 6 or not (0 <= box[0] < box[1] <= x and 0 <= box[2] < box[3] <= y and 0 <= box[4] < box[5] <= z):
            raise ValueError(f"region {box}: expected parts of 0, {x}, 0, {y}, 0, {z}")
        return box

    def RequestInformation(self, request, inputs, outputs):
        v = self._open()
        x0, x1, y0, y1, z0, z1 = self._box()
        info = outputs.GetInformationObject(0)
        pipeline = vtkStreamingDemandDrivenPipeline
        times = v.times.tolist()
        info.Remove(pipeline.TIME_STEPS())
        for time in times:
            info.Append(pipeline.TIME_STEPS(), time)
        info.Set(pipeline.TIME_RANGE(), (times[0], times[-1]), 2)
        info.Set(pipeline.WHOLE_EXTENT(), (x0, x1, y0, y1, z0, z1), 6)
        return 1

    def RequestData(self, request, inputs, outputs):
        v = self._open()
        x0, x1, y0, y1, z0, z1 = self._box()
        info = outputs.GetInformationObject(0)
        pipeline = vtkStreamingDemandDrivenPipeline
        time = info.Get(pipeline.UPDATE_TIME_STEP()) if info.Has(pipeline.UPDATE_TIME_STEP()) else v.times[0]
        values = v[v.frame_at(time), z0:z1, y0:y1, x0:x1]
        output = dataset_adapter.WrapDataObject(self.GetOutputData(outputs, 0))
        image = output.VTKObject
        image.SetExtent(x0, x1, y0, y1, z0, z1)
        image.SetOrigin(v.bounds[0])
        image.SetSpacing(v.voxel_size)
        output.CellData.append(np.ascontiguousarray(values).reshape(-1, 3) if v.channels == 3 else values.ravel(), v.name)
        output.CellData.SetActiveScalars(v.name)
        image.GetInformation().Set(image.DATA_TIME_STEP(), float(v.times[v.frame_at(time)]))
        return 1


if smproxy:
    @smproxy.reader(name="VoluteReader", label="Volute", extensions="volute", file_description="Volute volumes")
    class VoluteReader(Reader):
        @smproperty.stringvector(name="FileName")
        @smdomain.filelist()
        @smhint.filechooser(extensions="volute", file_description="Volute volumes")
        def SetFileName(self, name):
            super().SetFileName(name)

        @smproperty.doublevector(name="TimestepValues", information_only="1", si_class="vtkSITimeStepsProperty")
        def GetTimestepValues(self):
            return super().GetTimestepValues()
