#!/usr/bin/python3
"""VTK on curvilinear grids.

    vtk_grid.py make XYZ Q FACTOR COARSE.vts REFINED.vts     a PLOT3D grid carrying the field below, and the same refined;
                                                          prints the centre and longest edge of its box

Refined grids have their points on the tricubic solids of the coarse one (Catmull-Rom, one-sided at the borders) and the
field's own values there.

    vtk_grid.py draw GRID.vts SCENE_AS_JSON THREADS MAPPER   (under xvfb-run: Debian's VTK draws only to an X display)

Standard input: {"azimuth", "save"}; standard output: {"seconds", "cells"}. The mapper is that of the name, `raycast` or
`projected`, on tetrahedra; timed is the window's whole frame, and `save` gets its 8 bits, as float TIFF. VTK takes the opacity
function for extinction per unit distance. Its ray caster's rays pass the lower left corners of pixels; so its camera is moved
by half a pixel, and its picture lies on the others'."""

import json
import math
import sys
import time

import numpy
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

import pictures


def field(points):
    """0 to 1, smooth, of wavelengths of some cells where cells are large."""
    x, y, z = (points[..., a] for a in range(3))
    tau = 2 * math.pi
    return 0.5 + 0.5 * numpy.sin(tau * x / 8 + 0.3) * numpy.cos(tau * y / 7) * numpy.cos(tau * z / 6 + 0.5)


def refine(points, axis, factor):
    """Catmull-Rom along one axis through every point, `factor` pieces a cell."""
    p = numpy.moveaxis(points, axis, 0)
    slope = numpy.empty_like(p)
    slope[1:-1] = 0.5 * (p[2:] - p[:-2])
    slope[0] = 0.5 * (-3 * p[0] + 4 * p[1] - p[2])
    slope[-1] = 0.5 * (3 * p[-1] - 4 * p[-2] + p[-3])
    fine = numpy.empty(((len(p) - 1) * factor + 1, *p.shape[1:]))
    fine[-1] = p[-1]
    for n in range(factor):
        u = n / factor
        fine[n:-1:factor] = ((1 + 2 * u) * (1 - u) ** 2 * p[:-1] + u * (1 - u) ** 2 * slope[:-1] + u * u * (3 - 2 * u) * p[1:]
                             - u * u * (1 - u) * slope[1:])
    return numpy.moveaxis(fine, 0, axis)


def write(path, points):
    """points: [k, j, i, xyz]."""
    grid = vtk.vtkStructuredGrid()
    grid.SetDimensions(*reversed(points.shape[:3]))
    positions = vtk.vtkPoints()
    positions.SetDataTypeToDouble()
    positions.SetData(numpy_to_vtk(numpy.ascontiguousarray(points.reshape(-1, 3)), deep=1))
    grid.SetPoints(positions)
    values = numpy_to_vtk(field(points).ravel(), deep=1)
    values.SetName("field")
    grid.GetPointData().SetScalars(values)
    writer = vtk.vtkXMLStructuredGridWriter()
    writer.SetFileName(path)
    writer.SetInputData(grid)
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetCompressorTypeToNone()
    if not writer.Write():
        sys.exit(f"vtk_grid: {path} could not be written")


def make(xyz, q, factor, coarse, refined):
    reader = vtk.vtkMultiBlockPLOT3DReader()
    reader.SetXYZFileName(xyz)
    reader.SetQFileName(q)
    reader.AutoDetectFormatOn()
    reader.Update()
    block = reader.GetOutput().GetBlock(0)
    points = vtk_to_numpy(block.GetPoints().GetData()).astype(float).reshape(*reversed(block.GetDimensions()), 3)
    write(coarse, points)
    low, high = points.min((0, 1, 2)), points.max((0, 1, 2))
    print(json.dumps({"centre": list((low + high) / 2), "longest": (high - low).max()}))
    for axis in range(3):
        points = refine(points, axis, int(factor))
    write(refined, points)


def draw(path, scene, threads, name):
    for limit in (vtk.vtkMultiThreader.SetGlobalMaximumNumberOfThreads,
                  vtk.vtkMultiThreader.SetGlobalDefaultNumberOfThreads, vtk.vtkSMPTools.Initialize):
        limit(threads)
    reader = vtk.vtkXMLStructuredGridReader()
    reader.SetFileName(path)
    tetrahedra = vtk.vtkDataSetTriangleFilter()
    tetrahedra.SetInputConnection(reader.GetOutputPort())
    tetrahedra.Update()
    data = tetrahedra.GetOutput()
    data.GetPointData().SetActiveScalars("field")
    extinction, colour, look = vtk.vtkPiecewiseFunction(), vtk.vtkColorTransferFunction(), vtk.vtkVolumeProperty()
    for value, tau in scene["extinction"]:
        extinction.AddPoint(value, tau)
    for value, *rgb in scene["colours"]:
        colour.AddRGBPoint(value, *rgb)
    look.SetColor(colour)
    look.SetScalarOpacity(extinction)
    look.SetScalarOpacityUnitDistance(scene["unit"])
    look.SetInterpolationTypeToLinear()
    look.ShadeOff()
    mapper = {"raycast": vtk.vtkUnstructuredGridVolumeRayCastMapper, "projected": vtk.vtkProjectedTetrahedraMapper}[name]()
    if name == "raycast":
        mapper.SetAutoAdjustSampleDistances(0)
        mapper.SetImageSampleDistance(1)
        mapper.SetNumberOfThreads(threads)
    mapper.SetInputData(data)
    volume, renderer, window = vtk.vtkVolume(), vtk.vtkRenderer(), vtk.vtkRenderWindow()
    volume.SetMapper(mapper)
    volume.SetProperty(look)
    renderer.AddVolume(volume)
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(scene["size"], scene["size"])
    window.AddRenderer(renderer)
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetParallelScale(0.5 * scene["width"])
    pixel = scene["width"] / scene["size"]
    half = 0.5 * pixel if name == "raycast" else 0
    for line in sys.stdin:
        asked = json.loads(line)
        a, e = math.radians(asked["azimuth"]), math.radians(scene["elevation"])
        toward_eye = (math.cos(e) * math.sin(a), math.sin(e), math.cos(e) * math.cos(a))
        right, up = (math.cos(a), 0, -math.sin(a)), (-math.sin(e) * math.sin(a), math.cos(e), -math.sin(e) * math.cos(a))
        centre = [c + half * (r + u) for c, r, u in zip(scene["centre"], right, up)]
        camera.SetFocalPoint(*centre)
        camera.SetPosition(*(c + 3 * scene["width"] * d for c, d in zip(centre, toward_eye)))
        camera.SetViewUp(0, 1, 0)
        renderer.ResetCameraClippingRange()
        start = time.perf_counter()
        window.Render()
        window.WaitForCompletion()
        seconds = time.perf_counter() - start
        if asked.get("save"):
            shot = vtk.vtkWindowToImageFilter()
            shot.SetInput(window)
            shot.ReadFrontBufferOff()
            shot.Update()
            pixels = vtk_to_numpy(shot.GetOutput().GetPointData().GetScalars()).reshape(scene["size"], scene["size"], -1)
            pictures.write_tiff(asked["save"], pixels[::-1, :, :3] / 255.0)
        print(json.dumps({"seconds": seconds, "cells": data.GetNumberOfCells()}), flush=True)


if __name__ == "__main__":
    if sys.argv[1] == "make":
        make(*sys.argv[2:])
    else:
        draw(sys.argv[2], json.loads(sys.argv[3]), int(sys.argv[4]), sys.argv[5])
