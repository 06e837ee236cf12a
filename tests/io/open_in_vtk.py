"""open_in_vtk.py WRITE_SAMPLES: VTK must find in our files what was put into them, and we in its files.

NRRD is left out: VTK 9.1 takes the first axis of every NRRD volume for vector components.
"""
import glob
import os
import subprocess
import sys
import tempfile

try:
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError:
    sys.exit(77)

failures = 0


def check(path, what, found, expected):
    global failures
    if found != expected:
        failures += 1
        print(f"{os.path.basename(path)}: {what} is {found}, expected {expected}")


def read(path):
    if path.endswith(".vti"):
        reader = vtk.vtkXMLImageDataReader()
    else:
        reader = vtk.vtkMetaImageReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


with tempfile.TemporaryDirectory() as folder:
    subprocess.run([sys.argv[1], folder], check=True)
    files = sorted(glob.glob(folder + "/*.vti") + glob.glob(folder + "/*.mh[ad]"))
    check(folder, "number of files", len(files), 24)
    kinds = {"u8": "unsigned char", "i16": "short", "f32": "float", "f64": "double"}
    for path in files:
        image = read(path)
        scalars = image.GetPointData().GetScalars()
        if scalars is None:
            check(path, "scalars", None, "an array")
            continue
        check(path, "dims", image.GetDimensions(), (5, 4, 3))
        kind = os.path.basename(path).split(".")[0].rstrip("z")
        check(path, "type", scalars.GetDataTypeAsString(), kinds[kind])
        numbers = [float(x) for x in vtk_to_numpy(scalars)]
        check(path, "voxels", numbers, [3.0 * n + 1 for n in range(60)])
        check(path, "spacing", tuple(round(s, 12) for s in image.GetSpacing()), (0.5, 2.0, 1.25))
        if path.endswith(".vti"):
            matrix = image.GetDirectionMatrix()
            check(path, "origin", image.GetOrigin(), (-7.0, 3.5, 11.0))
            check(path, "direction", [matrix.GetElement(r, c) for r in range(3) for c in range(3)],
                  [0, -1, 0, 1, 0, 0, 0, 0, 1])
            tool = image.GetFieldData().GetAbstractArray("precis.tool")
            check(path, "attribute", tool.GetValue(0) if tool else None, "write_samples <&>")

    # The way back: what VTK writes of f32.vti, in each of its encodings, must be the same volume to us.
    image = read(folder + "/f32.vti")
    written = []

    def write(writer, name):
        writer.SetInputData(image)
        writer.SetFileName(folder + "/" + name)
        writer.Write()
        written.append(folder + "/" + name)

    for mode in ("Ascii", "Binary", "Appended"):
        for compressor in (None, vtk.vtkZLibDataCompressor()):
            for order in ("LittleEndian", "BigEndian"):
                for header in ("UInt32", "UInt64"):
                    for encode in (False, True):
                        writer = vtk.vtkXMLImageDataWriter()
                        getattr(writer, "SetDataModeTo" + mode)()
                        writer.SetCompressor(compressor)
                        getattr(writer, "SetByteOrderTo" + order)()
                        getattr(writer, "SetHeaderTypeTo" + header)()
                        writer.SetEncodeAppendedData(encode)
                        write(writer, f"vtk_{mode}{compressor is not None:d}{order}{header}{encode:d}.vti")
    for binary in (True, False):
        writer = vtk.vtkStructuredPointsWriter()
        (writer.SetFileTypeToBinary if binary else writer.SetFileTypeToASCII)()
        write(writer, f"vtk_{binary:d}.vtk")
    for compress in (True, False):
        writer = vtk.vtkMetaImageWriter()
        writer.SetCompression(compress)
        write(writer, f"vtk_{compress:d}.mha")
    for path in written:
        result = subprocess.run([sys.argv[1], "--check", path], capture_output=True, text=True)
        check(path, "what we read", result.stdout.strip(), "as written")
    print(f"{len(files) + len(written)} files, {failures} failures")
sys.exit(1 if failures else 0)
