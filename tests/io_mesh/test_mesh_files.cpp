#include <gtest/gtest.h>

#include <cstring>
#include <sstream>

#include "base/error.h"
#include "io/mesh.h"
#include "io_image/temporary_folder.h"

namespace vol::io {
namespace {

mesh::TriangleMesh tetrahedron() {
  mesh::TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.3, 0}, {0, 0, 1e10}};
  mesh.normals = {{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return mesh;
}

template <class T>
T get(const std::vector<char>& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

TEST(MeshFiles, PlyHoldsHeaderAndRecords) {
  const TemporaryFolder folder;
  for (const bool wide : {false, true}) {
    write_mesh(folder / "t.ply", tetrahedron(),
               {.double_precision = wide, .parts = {}, .attributes = {{"precis.tool", "a\nb"}}});
    const auto bytes = bytes_of(folder / "t.ply");
    const std::string text(bytes.begin(), bytes.end());
    const std::size_t data = text.find("end_header\n") + 11;
    EXPECT_EQ(text.substr(0, 3), "ply");
    EXPECT_NE(text.find("comment precis.tool a b\n"), std::string::npos);
    EXPECT_NE(text.find("element vertex 4\n"), std::string::npos);
    EXPECT_NE(text.find("element face 4\n"), std::string::npos);
    const std::size_t record = wide ? 36 : 24;
    ASSERT_EQ(bytes.size(), data + 4 * record + 4 * 13);
    if (wide) {
      EXPECT_EQ(get<double>(bytes, data + record), 0.1);
    } else {
      EXPECT_EQ(get<float>(bytes, data + record), 0.1F);
    }
    EXPECT_EQ(get<float>(bytes, data + 2 * record + record - 8), 1.0F);
    EXPECT_EQ(bytes[data + 4 * record], 3);
    EXPECT_EQ(get<std::int32_t>(bytes, data + 4 * record + 5), 2);
  }
}

TEST(MeshFiles, PartsCarryTheirIsovalue) {
  const TemporaryFolder folder;
  write_mesh(folder / "t.ply", tetrahedron(), {.parts = {{0.25, 3, 3}, {0.5, 1, 1}}, .attributes = {}});
  const auto bytes = bytes_of(folder / "t.ply");
  const std::string text(bytes.begin(), bytes.end());
  const std::size_t data = text.find("end_header\n") + 11;
  EXPECT_EQ(get<double>(bytes, data + 2 * 32 + 24), 0.25);
  EXPECT_EQ(get<double>(bytes, data + 3 * 32 + 24), 0.5);
  write_mesh(folder / "t.obj", tetrahedron(), {.parts = {{0.25, 3, 3}, {0.5, 1, 1}}, .attributes = {}});
  const auto obj = bytes_of(folder / "t.obj");
  const std::string lines(obj.begin(), obj.end());
  EXPECT_LT(lines.find("g isovalue_0.25\nf 1//1 3//3 2//2\n"),
            lines.find("g isovalue_0.5\nf 3//3 1//1 4//4\n"));
}

// The shortest digits that read back as the same number.
TEST(MeshFiles, ObjReadsBackExactly) {
  const TemporaryFolder folder;
  for (const bool wide : {false, true}) {
    write_mesh(folder / "t.obj", tetrahedron(), {.double_precision = wide, .parts = {}, .attributes = {}});
    const auto bytes = bytes_of(folder / "t.obj");
    std::istringstream lines(std::string(bytes.begin(), bytes.end()));
    std::string word;
    double x = 0;
    lines >> word >> x >> x >> x >> word >> x;
    EXPECT_EQ(wide ? x : double(float(x)), wide ? 0.1 : double(0.1F));
  }
}

TEST(MeshFiles, StlHoldsTrianglesWithTheirNormals) {
  const TemporaryFolder folder;
  const auto lost = write_mesh(folder / "t.stl", tetrahedron());
  EXPECT_EQ(lost.size(), 1u);
  const auto bytes = bytes_of(folder / "t.stl");
  ASSERT_EQ(bytes.size(), 84 + 4 * 50u);
  EXPECT_EQ(get<std::uint32_t>(bytes, 80), 4u);
  EXPECT_EQ(get<float>(bytes, 84 + 8), -1.0F);  // triangle 0, 2, 1 looks down
  EXPECT_EQ(get<float>(bytes, 84 + 12 + 12 + 4), 0.3F);
}

TEST(MeshFiles, NamesAreCheckedFirst) {
  const TemporaryFolder folder;
  EXPECT_THROW(require_mesh_format(folder / "t.vtk", {}), Error);
  EXPECT_THROW(require_mesh_format(folder / "t", {}), Error);
  EXPECT_THROW(
      require_mesh_format(folder / "t.stl", {.double_precision = true, .parts = {}, .attributes = {}}),
      Error);
  EXPECT_THROW(require_mesh_format(folder / "none/t.ply", {}), Error);
  EXPECT_NO_THROW(require_mesh_format(folder / "t.PLY", {}));
}

TEST(MeshFiles, AnEmptyMeshIsAFile) {
  const TemporaryFolder folder;
  for (const char* name : {"t.ply", "t.obj", "t.stl"}) {
    write_mesh(folder / name, {});
    EXPECT_TRUE(std::filesystem::exists(folder / name));
  }
}

}  // namespace
}  // namespace vol::io
