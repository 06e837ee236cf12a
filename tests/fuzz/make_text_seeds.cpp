// make_text_seeds FOLDER: small good meshes, transfer functions, labels' looks, scenes and codebooks for the
// fuzzers to start from.
#include <filesystem>
#include <fstream>

#include "io/codebook.h"
#include "io/mesh.h"

namespace {

using namespace vol;
namespace fs = std::filesystem;

void put(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

void meshes(const fs::path& folder) {
  mesh::TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  io::write_mesh(folder / "bare.ply", mesh);
  io::write_mesh(folder / "bare.stl", mesh);
  mesh.normals.assign(4, {0, 0, 1});
  io::write_mesh(folder / "normals.ply", mesh, {.double_precision = true});
  io::write_mesh(folder / "normals.obj", mesh);
  put(folder / "text.ply",
      "ply\nformat ascii 1.0\ncomment c\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
      "float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  put(folder / "text.stl",
      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e-3 "
      "0\nendloop\nendfacet\n"
      "endsolid\n");
}

void curves(const fs::path& folder) {
  put(folder / "points.yaml",
      "space: srgb\nrange: [0, 255]\ncolours: [[0, 0, 0, 0], [1, 1, 0.5, 1]]\nopacity: [[0, 0], [1, 0.3]]\n");
  put(folder / "bezier.yaml", "range: [0, 4095]\nbezier: [0, 0, 1.5, 0.2]\n");
  put(folder / "bands.yaml",
      "bezier:\n  - {name: bone, colour: [1, 0.9, 0.8], points: [0, 0, 1, 1]}\n"
      "  - {points: [[0, 0], [0.2, 1], [1, 0]]}\n");
  put(folder / "labels.yaml", "space: srgb\nlabels: [[0, 0.5, 0.5, 0.5, 0.01], [7, 1, 0, 0, 1]]\n");
  put(folder / "preset.json",
      "[{\"RGBPoints\": [0, 0, 0, 0, 255, 1, 1, 1], \"Points\": [0, 0, 0.5, 0, 100, 1, 0.3, 0.5, 255, 1, "
      "0.5, "
      "0]}]\n");
  put(folder / "profile.csv", "value,weight\n# c\n0,0\n50,0.5\n\n100,1e0\n");
}

void scenes(const fs::path& folder) {
  put(folder / "near.yaml",
      "camera: {azimuth: 30, elevation: 20, width: 100, up: [0, 0, 1]}\nreference_length: 1\nshading: true\n"
      "transfer: {range: [0, 1], colours: [[0, 1, 1, 1]], opacity: [[0, 0], [1, 0.5]]}\nmodel: composite\n");
  put(folder / "far.yaml",
      "camera: {fov: 30, distance: 2, target: [1, 2, 3]}\nshading: {ambient: 0.1, light: [0, 1, 0]}\n"
      "background: [0, 0.5, 1]\nquadrature: trapezoid\nstep: 0.5v\nreconstruction: trilinear\n"
      "transfer: {bezier: [0, 1]}\n");
}

void codebooks(const fs::path& folder) {
  features::Codebook book;
  book.wavelet = "haar";
  book.levels = 1;
  book.names = {"level1.LLL", "level1.HHH"};
  book.mean = Eigen::Vector2d(0.5, 0.125);
  book.projection = Eigen::MatrixXd::Identity(2, 2);
  book.units = features::Samples::Identity(2, 2);
  book.labels = {1, 0};
  io::write_codebook(folder / "two.yaml", book, {{"precis.version", "1"}});
  book.projection.resize(0, 2);
  book.units.resize(1, 0);
  book.labels = {0};
  io::write_codebook(folder / "constant.yaml", book, {});
}

}  // namespace

int main(int, char** argv) {
  const fs::path folder = argv[1];
  for (const char* kind : {"mesh", "curves", "scene", "codebook"}) fs::create_directories(folder / kind);
  meshes(folder / "mesh");
  curves(folder / "curves");
  scenes(folder / "scene");
  codebooks(folder / "codebook");
}
