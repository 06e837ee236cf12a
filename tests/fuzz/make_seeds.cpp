// make_seeds FOLDER: small good files of every format, one folder a reader, for the fuzzers to start from.
#include <cstring>
#include <filesystem>
#include <fstream>

#include "io/volume.h"

namespace {

using namespace vol;
namespace fs = std::filesystem;

volume::Volume small(volume::VoxelType type) {
  volume::GridGeometry g;
  g.dims = {3, 2, 2};
  g.spacing = {0.5, 2, 1.25};
  g.origin = {-7, 3.5, 11};
  g.direction << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  g.space = volume::Space::lps;
  volume::Volume v = volume::allocate(type, g);
  volume::visit(v, [](auto& grid) {
    using T = typename std::decay_t<decltype(grid)>::value_type;
    for (std::size_t n = 0; n < grid.voxels.size(); ++n)
      grid.voxels[n] = static_cast<T>(static_cast<float>(n));
  });
  v.attributes["key"] = "value";
  return v;
}

void put(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string nifti() {
  std::string bytes(352 + 12, '\0');
  const auto set = [&](std::size_t at, auto value) { std::memcpy(bytes.data() + at, &value, sizeof value); };
  set(0, std::int32_t{348});
  const std::int16_t dim[] = {3, 3, 2, 2, 1, 1, 1, 1};
  for (std::size_t i = 0; i < 8; ++i) set(40 + 2 * i, dim[i]);
  set(70, std::int16_t{2});
  set(72, std::int16_t{8});
  for (std::size_t i = 0; i < 4; ++i) set(76 + 4 * i, 1.0f);
  set(108, 352.0f);
  set(112, 2.0f);
  set(252, std::int16_t{1});
  set(256, 0.5f);
  std::memcpy(bytes.data() + 344, "n+1", 4);
  return bytes;
}

}  // namespace

int main(int argc, char** argv) {
  const fs::path folder = argc > 1 ? argv[1] : "seeds";
  for (const char* reader : {"nrrd", "meta_image", "vti", "vtk_legacy", "nifti"})
    fs::create_directories(folder / reader);
  for (const auto type : {volume::VoxelType::u8, volume::VoxelType::i16, volume::VoxelType::f32}) {
    const auto v = small(type);
    const std::string name(volume::name(type));
    for (const bool compress : {false, true}) {
      const std::string stem = name + (compress ? "z" : "");
      io::write_volume(folder / "nrrd" / (stem + ".nrrd"), v, {.format = {}, .compress = compress});
      io::write_volume(folder / "meta_image" / (stem + ".mha"), v, {.format = {}, .compress = compress});
      io::write_volume(folder / "vti" / (stem + ".vti"), v, {.format = {}, .compress = compress});
    }
  }
  put(folder / "nrrd/ascii",
      "NRRD0004\ntype: float\ndimension: 3\nsizes: 3 2 1\nspacings: 1 2 nan\naxis mins: 0 1 2\n"
      "centerings: cell node cell\nencoding: ascii\nline skip: 1\n\nskipped\n1 2.5 3e4 -5 0.1 6\n");
  put(folder / "nrrd/slices",
      "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 2 4\nencoding: raw\ndata file: s%03d 1 4 1 2\n");
  put(folder / "nrrd/list",
      "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 2 2\nencoding: gzip\nbyte skip: 1\ndata file: "
      "LIST\na\nb\n");
  put(folder / "meta_image/ascii",
      "ObjectType = Image\nNDims = 3\nBinaryData = False\nDimSize = 3 2 1\nElementSize = 1 2 3\n"
      "ElementType = MET_SHORT\nElementDataFile = LOCAL\n1 2 3 4 5 6\n");
  put(folder / "meta_image/slices",
      "NDims = 3\nDimSize = 3 2 2\nHeaderSize = -1\nElementType = MET_UCHAR\nElementDataFile = s%02d 1 2 "
      "1\n");
  const std::string open = "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" byte_order=\"BigEndian\"";
  const std::string grid =
      "><ImageData WholeExtent=\"0 2 0 1 0 0\" Origin=\"0 0 0\" Spacing=\"1 1 1\"><Piece Extent=\"0 2 0 1 0 "
      "0\"><PointData Scalars=\"a\">";
  const std::string close = "</DataArray></PointData></Piece></ImageData></VTKFile>";
  put(folder / "vti/ascii",
      open + grid + "<DataArray type=\"Float32\" Name=\"a\" format=\"ascii\">1 2 3 4 5 6" + close);
  put(folder / "vti/base64",
      open + grid + "<DataArray type=\"UInt8\" Name=\"a\" format=\"binary\">AAAABgECAwQFBg==" + close);
  const std::string vtk = "# vtk DataFile Version 3.0\ntitle\n";
  const std::string points = "DATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 1\nSPACING 1 2 3\nORIGIN 0 0 0\n";
  put(folder / "vtk_legacy/ascii",
      vtk + "ASCII\n" + points + "POINT_DATA 6\nSCALARS s short 1\nLOOKUP_TABLE default\n1 2 3 4 5 6\n");
  put(folder / "vtk_legacy/binary", vtk + "BINARY\n" + points +
                                        "POINT_DATA 6\nVECTORS v unsigned_char\n123456789012345678\n" +
                                        "FIELD f 2\na 2 1 short\n1234\nb 1 6 unsigned_char\n123456\n");
  put(folder / "vtk_legacy/cells", vtk + "ASCII\n" + points +
                                       "CELL_DATA 2\nMETADATA\nINFORMATION 0\n\nLOOKUP_TABLE t 1\n1 1 1 1\n"
                                       "SCALARS s float\nLOOKUP_TABLE t\n0.5 2\n");
  put(folder / "nifti/plain.nii", nifti());
}
