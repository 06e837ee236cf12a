#!/usr/bin/python3
"""VTK's ray casters, asked for one frame a line:

    vtk_worker.py VOLUME.nrrd SCENE_AS_JSON THREADS [gpu]      (under xvfb-run: Debian's VTK draws only to an X display)

Standard input: {"azimuth", "step", "save"}; standard output: {"seconds"}. The CPU mapper
(vtkFixedPointVolumeRayCastMapper) is timed alone, without drawing its image, and `save` gets its own 16-bit image (15 bits
after the point, premultiplied), as float TIFF. With `gpu` vtkGPUVolumeRayCastMapper draws, on Mesa's software renderer where
there is no other: timed is the window's whole frame, and `save` gets its 8 bits."""

import ctypes
import json
import math
import sys
import time

import numpy
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

import pictures


def fixed_point_image(mapper, size):
    """The mapper's RGBA image over the whole picture, rows from the top. The mapper casts only the volume's rectangle."""
    image = mapper.GetRayCastImage()
    address = int(image.GetImage().split("_")[1], 16)  # Python is handed a pointer as text
    (x0, y0), (width, height), (stride, rows) = image.GetImageOrigin(), image.GetImageInUseSize(), image.GetImageMemorySize()
    memory = (ctypes.c_ushort * (4 * stride * rows)).from_address(address)
    used = numpy.frombuffer(memory, numpy.uint16).reshape(rows, stride, 4)[:height, :width]
    whole = numpy.zeros((size, size, 4))
    whole[y0:y0 + height, x0:x0 + width] = used / 32767.0
    return whole[::-1]


def window_image(window, size):
    """The 8-bit picture of the window, rows from the top."""
    window_filter = vtk.vtkWindowToImageFilter()
    window_filter.SetInput(window)
    window_filter.ReadFrontBufferOff()
    window_filter.Update()
    pixels = vtk_to_numpy(window_filter.GetOutput().GetPointData().GetScalars())
    return pixels.reshape(size, size, -1)[::-1, :, :3] / 255.0


def cpu_mapper(threads):
    mapper = vtk.vtkFixedPointVolumeRayCastMapper()
    mapper.SetNumberOfThreads(threads)
    mapper.LockSampleDistanceToInputSpacingOff()
    mapper.IntermixIntersectingGeometryOff()
    return mapper


def gpu_mapper():
    mapper = vtk.vtkGPUVolumeRayCastMapper()
    mapper.UseJitteringOff()
    mapper.LockSampleDistanceToInputSpacingOff()
    return mapper


def main():
    path, scene, threads = sys.argv[1], json.loads(sys.argv[2]), int(sys.argv[3])
    for limit in (vtk.vtkMultiThreader.SetGlobalMaximumNumberOfThreads,
                  vtk.vtkMultiThreader.SetGlobalDefaultNumberOfThreads, vtk.vtkSMPTools.Initialize):
        limit(threads)
    voxels = pictures.read_nrrd(path)
    data = vtk.vtkImageData()
    data.SetDimensions(*reversed(voxels.shape))
    data.GetPointData().SetScalars(numpy_to_vtk(voxels.ravel(), deep=1))
    edge = max(voxels.shape) - 1
    opacity, colour, look = vtk.vtkPiecewiseFunction(), vtk.vtkColorTransferFunction(), vtk.vtkVolumeProperty()
    for value, alpha in scene["opacity"]:
        opacity.AddPoint(value, alpha)
    for value, *rgb in scene["colours"]:
        colour.AddRGBPoint(value, *rgb)
    look.SetColor(colour)
    look.SetScalarOpacity(opacity)
    look.SetScalarOpacityUnitDistance(1)
    look.SetInterpolationTypeToLinear()
    if scene.get("shading"):
        look.ShadeOn()
        look.SetAmbient(scene["shading"]["ambient"])
        look.SetDiffuse(scene["shading"]["diffuse"])
        look.SetSpecular(scene["shading"]["specular"])
        look.SetSpecularPower(scene["shading"]["exponent"])
    on_gpu = sys.argv[4:] == ["gpu"]
    mapper = gpu_mapper() if on_gpu else cpu_mapper(threads)
    mapper.SetInputData(data)
    mapper.AutoAdjustSampleDistancesOff()
    for fixed in (mapper.SetImageSampleDistance, mapper.SetMinimumImageSampleDistance, mapper.SetMaximumImageSampleDistance):
        fixed(1)
    volume, renderer, window = vtk.vtkVolume(), vtk.vtkRenderer(), vtk.vtkRenderWindow()
    volume.SetMapper(mapper)
    volume.SetProperty(look)
    renderer.AddVolume(volume)
    light = vtk.vtkLight()
    light.SetLightTypeToHeadlight()
    light.SetAmbientColor(1, 1, 1)  # black by default, and then a volume's ambient coefficient lights nothing
    renderer.AddLight(light)
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(scene["size"], scene["size"])
    window.AddRenderer(renderer)
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetParallelScale(0.5 * scene["width"] * edge)
    centre = [(n - 1) / 2 for n in reversed(voxels.shape)]
    for line in sys.stdin:
        asked = json.loads(line)
        mapper.SetSampleDistance(asked["step"])
        if not on_gpu:
            mapper.SetInteractiveSampleDistance(asked["step"])
        a, e = math.radians(asked["azimuth"]), math.radians(scene["elevation"])
        toward_eye = (math.cos(e) * math.sin(a), math.sin(e), math.cos(e) * math.cos(a))
        camera.SetFocalPoint(*centre)
        camera.SetPosition(*(c + 3 * edge * d for c, d in zip(centre, toward_eye)))
        camera.SetViewUp(0, 1, 0)
        renderer.ResetCameraClippingRange()
        start = time.perf_counter()
        window.Render()
        window.WaitForCompletion()
        seconds = time.perf_counter() - start if on_gpu else mapper.GetTimeToDraw()
        if asked.get("save"):
            image = window_image(window, scene["size"]) if on_gpu else fixed_point_image(mapper, scene["size"])[..., :3]
            pictures.write_tiff(asked["save"], image)
        print(json.dumps({"seconds": seconds}), flush=True)


if __name__ == "__main__":
    main()
