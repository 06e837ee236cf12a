#include <gtest/gtest.h>

#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <thread>

#include "base/error.h"
#include "base/rng.h"
#include "io/mesh.h"
#include "io_image/temporary_folder.h"

namespace vol::io {
namespace {

mesh::TriangleMesh random_mesh(bool normals) {
  Rng rng(21);
  mesh::TriangleMesh mesh;
  for (int n = 0; n < 50; ++n) {
    mesh.positions.push_back({rng.normal(), 1e6 * rng.normal(), 1e-6 * rng.normal()});
    if (!normals) continue;
    const double a = rng.uniform(-3, 3);
    const double z = rng.uniform(-1, 1);
    const double r = std::sqrt(1 - z * z);
    mesh.normals.push_back(
        {static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)), static_cast<float>(z)});
  }
  for (int n = 0; n < 70; ++n) {
    mesh.triangles.push_back({static_cast<std::uint32_t>(rng.below(50)),
                              static_cast<std::uint32_t>(rng.below(50)),
                              static_cast<std::uint32_t>(rng.below(50))});
  }
  return mesh;
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

std::string error_of(const std::filesystem::path& path) {
  try {
    (void)read_mesh(path);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

// What is written comes back: doubles as they were, floats as they round; STL as three vertices a triangle.
TEST(MeshFiles, ComeBackAsTheyWereWritten) {
  const TemporaryFolder folder;
  for (const bool normals : {false, true}) {
    const mesh::TriangleMesh mesh = random_mesh(normals);
    for (const char* name : {"a.ply", "a.obj"}) {
      for (const bool wide : {false, true}) {
        write_mesh(
            folder / name, mesh,
            {.double_precision = wide, .parts = {{0.5, 20, 30}, {0.7, 30, 40}}, .attributes = {{"k", "v"}}});
        const mesh::TriangleMesh back = read_mesh(folder / name);
        ASSERT_EQ(back.positions.size(), mesh.positions.size()) << name;
        for (std::size_t v = 0; v < back.positions.size(); ++v) {
          for (std::size_t a = 0; a < 3; ++a) {
            const double x = mesh.positions[v][a];
            if (wide) {
              EXPECT_EQ(back.positions[v][a], x);
            } else {  // OBJ has a float's shortest digits, which are another double
              EXPECT_EQ(static_cast<float>(back.positions[v][a]), static_cast<float>(x));
            }
          }
        }
        EXPECT_EQ(back.normals, mesh.normals) << name;
        EXPECT_EQ(back.triangles, mesh.triangles) << name;
      }
    }
    write_mesh(folder / "a.stl", mesh);
    const mesh::TriangleMesh soup = read_mesh(folder / "a.stl");
    ASSERT_EQ(soup.triangles.size(), mesh.triangles.size());
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t a = 0; a < 3; ++a) {
          EXPECT_EQ(soup.positions[soup.triangles[t][c]][a],
                    double{static_cast<float>(mesh.positions[mesh.triangles[t][c]][a])});
        }
      }
    }
  }
}

// The same square with a number more, as text and in either byte order, with lists and elements in between.
TEST(MeshFiles, PlyOfOtherProgramsIsRead) {
  const TemporaryFolder folder;
  const std::string elements =
      "comment made elsewhere\nelement thing 1\nproperty list uchar short numbers\nelement vertex 4\n"
      "property double z\nproperty uchar red\nproperty float x\nproperty short y\nelement face 1\n"
      "property uchar flag\nproperty list int uint vertex_index\nproperty float quality\nend_header\n";
  write_text(folder / "t.ply",
             "ply\r\nformat ascii 1.0\r\n" + elements +
                 "2 7 -8\n2.5 9 0 0\n2.5 9 1 0\n\n 2.5 9 1 -1 \r\n2.5 9 0 -1\n1 4 0 1 2 3 0.5");
  std::string data;
  const auto put = [&](auto value) {
    char bytes[sizeof(value)];
    std::memcpy(bytes, &value, sizeof(value));
    data.append(bytes, sizeof(value));
  };
  const auto put_swapped = [&](auto value) {
    put(value);
    std::reverse(data.end() - static_cast<std::ptrdiff_t>(sizeof(value)), data.end());
  };
  const auto write_all = [&](const auto& w) {
    data.clear();
    w(std::uint8_t{2}), w(std::int16_t{7}), w(std::int16_t{-8});
    for (int v = 0; v < 4; ++v) {
      w(2.5), w(std::uint8_t{9}), w(v == 1 || v == 2 ? 1.0F : 0.0F),
          w(static_cast<std::int16_t>(v < 2 ? 0 : -1));
    }
    w(std::uint8_t{1}), w(std::int32_t{4});
    for (std::uint32_t v = 0; v < 4; ++v) w(v);
    w(0.5F);
  };
  write_all(put);
  write_text(folder / "l.ply", "ply\nformat binary_little_endian 1.0\n" + elements + data);
  write_all(put_swapped);
  write_text(folder / "b.ply", "ply\nformat binary_big_endian 1.0\n" + elements + data);
  for (const char* name : {"t.ply", "l.ply", "b.ply"}) {
    const mesh::TriangleMesh mesh = read_mesh(folder / name);
    ASSERT_EQ(mesh.positions.size(), 4u) << name;
    EXPECT_EQ(mesh.positions[2], (std::array<double, 3>{1, -1, 2.5})) << name;
    EXPECT_TRUE(mesh.normals.empty());
    ASSERT_EQ(mesh.triangles.size(), 2u) << name;  // a fan
    EXPECT_EQ(mesh.triangles[1], (std::array<std::uint32_t, 3>{0, 2, 3})) << name;
  }
}

TEST(MeshFiles, ObjAndStlOfOtherProgramsAreRead) {
  const TemporaryFolder folder;
  write_text(folder / "a.obj",
             "# x\nmtllib a.mtl\nv 0 0 0 1\nv 1 0 0\nv 0 1 0\nvt 0 0\ng a\nf -3/1 -2/1 -1/1\n"
             "v 0 0 +1e0\nf 1 2 3 4\n");
  const mesh::TriangleMesh mesh = read_mesh(folder / "a.obj");
  EXPECT_EQ(mesh.positions.size(), 4u);
  ASSERT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(mesh.triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
  EXPECT_EQ(mesh.triangles[2], (std::array<std::uint32_t, 3>{0, 2, 3}));
  write_text(folder / "a.stl",
             "solid x\n facet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1 0 0\n"
             "  vertex 0 1e-1 0\n endloop\n endfacet\nendsolid x\n");
  EXPECT_EQ(read_mesh(folder / "a.stl").positions[2], (std::array<double, 3>{0, 0.1, 0}));
}

// Comments behind a line and lines that go on; capitals in STL.
TEST(MeshFiles, EveryWayToWriteALineIsRead) {
  const TemporaryFolder folder;
  write_text(folder / "a.obj",
             "# C:\\\nv 0 0 0 # the first\nv 1 0 \\\r\n 0\r\nv 0 1 0#\nf 1 2 \\\n  3 # \\\nf 3 2 1\\");
  const mesh::TriangleMesh mesh = read_mesh(folder / "a.obj");
  ASSERT_EQ(mesh.positions.size(), 3u);
  EXPECT_EQ(mesh.positions[1], (std::array<double, 3>{1, 0, 0}));
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
  write_text(folder / "a.stl",
             "SOLID X\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVertex 1 0 0\nVERTEX 0 1 0\n"
             "ENDLOOP\nENDFACET\nENDSOLID X\n");
  EXPECT_EQ(read_mesh(folder / "a.stl").positions[2], (std::array<double, 3>{0, 1, 0}));
}

// By a pipe the size is not known before: text and binary STL are read, and what is too short or too long is
// told.
TEST(MeshFiles, StlComesByAPipe) {
  const TemporaryFolder folder;
  write_mesh(folder / "b.stl", random_mesh(false));
  const auto bytes = bytes_of(folder / "b.stl");
  const std::string binary(bytes.begin(), bytes.end());
  std::string solid = binary;  // a binary file may begin as text does
  solid.replace(0, 5, "solid");
  const std::string text = "solid\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendsolid" + std::string(80, ' ');
  const auto pipe = folder / "p.stl";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto triangles_of = [&](const std::string& data) {
    std::thread writer([&] { write_text(pipe, data); });
    std::size_t count = 0;
    try {
      count = read_mesh(pipe).triangles.size();
    } catch (const Error&) {
    }
    writer.join();
    return count;
  };
  EXPECT_EQ(triangles_of(binary), 70u);
  EXPECT_EQ(triangles_of(solid), 70u);
  EXPECT_EQ(triangles_of(text), 1u);
  EXPECT_EQ(triangles_of(binary.substr(0, 3000)), 0u);
  EXPECT_EQ(triangles_of(binary + "x"), 0u);
}

TEST(MeshFiles, StlOfAnotherSizeIsToldBoth) {
  const TemporaryFolder folder;
  write_mesh(folder / "a.stl", random_mesh(false));
  std::ofstream(folder / "a.stl", std::ios::app) << "more";
  EXPECT_NE(error_of(folder / "a.stl").find("3588 bytes, where a binary STL of 70 triangles has 3584"),
            std::string::npos)
      << error_of(folder / "a.stl");
}

// Whatever their length, directions stay; what has none is 0. PLY and OBJ say the same.
TEST(MeshFiles, NormalsAreUnitOrNone) {
  const TemporaryFolder folder;
  const std::pair<const char*, std::array<float, 3>> kCases[] = {{"1e300 0 0", {1, 0, 0}},
                                                                 {"-3e300 0 4e300", {-0.6F, 0, 0.8F}},
                                                                 {"0 3e-300 4e-300", {0, 0.6F, 0.8F}},
                                                                 {"0 0 2e6", {0, 0, 1}},
                                                                 {"1 nan 0", {0, 0, 0}},
                                                                 {"inf 0 0", {0, 0, 0}},
                                                                 {"0 -inf nan", {0, 0, 0}},
                                                                 {"0 0 0", {0, 0, 0}}};
  for (const auto& [words, expected] : kCases) {
    std::string obj, ply = "ply\nformat ascii 1.0\nelement vertex 3\n";
    for (const char* axis : {"x", "y", "z", "nx", "ny", "nz"}) {
      ply += std::string("property double ") + axis + "\n";
    }
    ply += "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    for (const char* p : {"0 0 0", "1 0 0", "0 1 0"}) {
      obj += std::string("v ") + p + "\nvn " + words + "\n";
      ply += std::string(p) + " " + words + "\n";
    }
    write_text(folder / "a.obj", obj + "f 1//1 2//2 3//3\n");
    write_text(folder / "a.ply", ply + "3 0 1 2\n");
    for (const char* name : {"a.obj", "a.ply"}) {
      const mesh::TriangleMesh mesh = read_mesh(folder / name);
      ASSERT_EQ(mesh.normals.size(), 3u) << name << ' ' << words;
      for (std::size_t a = 0; a < 3; ++a)
        EXPECT_FLOAT_EQ(mesh.normals[1][a], expected[a]) << name << ' ' << words;
    }
  }
}

// An isosurface that is nowhere is a file, and comes back as one; vertices alone and other texts are no mesh.
TEST(MeshFiles, EmptyMeshesComeBackAndCloudsAreRefused) {
  const TemporaryFolder folder;
  for (const char* name : {"a.ply", "a.obj", "a.stl"}) {
    write_mesh(folder / name, {}, {.attributes = {{"k", "v"}}});
    EXPECT_TRUE(read_mesh(folder / name).triangles.empty()) << name;
  }
  const std::string points =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
  for (const std::string& faces :
       {std::string(), std::string("element face 0\nproperty list uchar int vertex_indices\n"),
        std::string("element tristrips 1\nproperty list uchar int vertex_indices\n")}) {
    write_text(folder / "a.ply", points + faces + "end_header\n0 0 0\n3 0 0 0\n");
    EXPECT_NE(error_of(folder / "a.ply").find("a.ply: has no faces"), std::string::npos) << faces;
  }
  write_text(folder / "a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n");
  EXPECT_NE(error_of(folder / "a.obj").find("a.obj: has no faces"), std::string::npos);
  for (const char* text : {"", "a letter\n\no my\n", "g a\n"}) {
    write_text(folder / "a.obj", text);
    EXPECT_NE(error_of(folder / "a.obj").find("a.obj: has no vertices"), std::string::npos) << text;
  }
}

// A list's number of entries is one that its type holds; more than one element by a name would leave vertices
// without normals.
TEST(MeshFiles, ListsAndElementsOfPlyAreWhatTheyMayBe) {
  const TemporaryFolder folder;
  const auto head = [](const std::string& count) {
    return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 1\nproperty list uchar int vertex_indices\nproperty list " +
           count + " int other\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 ";
  };
  write_text(folder / "a.ply", head("uchar") + "2 7 7\n");
  EXPECT_EQ(read_mesh(folder / "a.ply").triangles.size(), 1u);
  std::string many = "256";
  for (int n = 0; n < 256; ++n) many += " 1";
  write_text(folder / "a.ply", head("short") + many + "\n");
  EXPECT_EQ(read_mesh(folder / "a.ply").triangles.size(), 1u);
  for (const char* type : {"uchar", "char", "int", "uint"}) {
    for (const std::string& count : {std::string("inf"), std::string("-inf"), std::string("1e300"),
                                     std::string("-1"), std::string("4294967296"), many}) {
      if (count == many && std::string(type).find("int") != std::string::npos) continue;
      write_text(folder / "a.ply", head(type) + count + "\n");
      EXPECT_NE(error_of(folder / "a.ply").find("list"), std::string::npos) << type << ' ' << count;
    }
  }
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  write_text(folder / "a.ply",
             "ply\nformat ascii 1.0\nelement vertex 1\n" + xyz +
                 "property float nx\nproperty float ny\nproperty float nz\nelement vertex 2\n" + xyz +
                 "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                 "0 0 0 0 0 1\n1 0 0\n0 1 0\n3 0 1 2\n");
  EXPECT_NE(error_of(folder / "a.ply").find("twice"), std::string::npos) << error_of(folder / "a.ply");
}

TEST(MeshFiles, HostileOnesAreRefusedInOneLine) {
  const TemporaryFolder folder;
  const std::string head = "ply\nformat binary_little_endian 1.0\n";
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\n";
  const std::string zero(12, '\0');
  const std::string bad[] = {
      "ply\n",
      "ply\nend_header\n",
      head + "element vertex 9000000000000000000\n" + xyz + "end_header\n",
      head + "element vertex 4000000000\n" + xyz + "end_header\n" + zero,  // no memory on its word
      head + "element vertex -1\n" + xyz + "end_header\n",
      head + "element vertex 2\n" + xyz + "end_header\n" + zero,
      head + "element vertex 1\nproperty float x\nend_header\n" + zero,
      head + "element vertex 1\nend_header\n",
      head + "element vertex 5000000000000000\nend_header\n",  // without properties: no byte a record
      head + "property float x\nend_header\n",
      head + "element vertex 1\nproperty list float int x\nend_header\n",
      head + "element vertex 1\n" + xyz + faces + "end_header\n" + zero + '\2' + std::string(8, '\0'),
      head + "element vertex 1\n" + xyz + faces + "end_header\n" + zero + '\3' + std::string(8, '\0') + '\1' +
          std::string(3, '\0'),  // vertex 1 of 1
      head + "element vertex 1\n" + xyz + faces + "end_header\n" + zero + '\3' + std::string(12, '\xff'),
      head + "element vertex 1\n" + xyz + faces + "end_header\n" + zero + '\xff' + std::string(12, '\0'),
      head + "element vertex 1\n" + xyz + "end_header\n" + std::string(12, '\xff'),  // NaN
      "ply\nformat ascii 1.0\nelement vertex 1\n" + xyz + "end_header\n0 1 x\n",
      "ply\nformat ascii 1.0\nelement vertex 1\n" + xyz + "end_header\n0 1\n",
      "ply\nformat ascii 1.0\nelement vertex 1\n" + xyz + "end_header\n0 1 1e999\n",
      head + "element vertex 1\n" + xyz + "property float nx\nproperty float ny\nproperty float nz\n" +
          "element vertex 1\n" + xyz + faces + "end_header\n" + zero + zero + zero + '\3' +
          std::string(4, '\0') + '\1' + std::string(3, '\0') + '\1' + std::string(3, '\0'),
      "solid",
      "",
      "ball"};
  int n = 0;
  for (const std::string& text : bad) {
    for (const char* name : {"a.ply", "a.stl"}) {
      write_text(folder / name, text);
      const std::string message = error_of(folder / name);
      EXPECT_NE(message.find(name), std::string::npos) << n << ": " << message;
      EXPECT_EQ(message.find('\n'), std::string::npos);
    }
    ++n;
  }
  for (const char* text :
       {"f 1 2 3\n", "v 0 0\n", "v 0 0 nan\n", "v 0 0 0\nf 1 1\n", "v 0 0 0\nf 1 1 0\n",
        "v 0 0 0\nf 1 1 -2\n", "v 0 0 0\nf 1//1 1//1 1//1\n", "v 0 0 0\nf 1 1 99999999999999999999\n"}) {
    write_text(folder / "a.obj", text);
    EXPECT_NE(error_of(folder / "a.obj"), "") << text;
  }
}

// Every prefix, and bytes changed at random: an error or a mesh whose triangles have their vertices.
TEST(MeshFiles, DamagedOnesAreRefusedOrWhole) {
  const TemporaryFolder folder;
  Rng rng(22);
  for (const char* name : {"a.ply", "a.obj", "a.stl"}) {
    write_mesh(folder / name, random_mesh(true));
    const auto bytes = bytes_of(folder / name);
    const std::string whole(bytes.begin(), bytes.end());
    for (int n = 0; n < 300; ++n) {
      std::string text = whole;
      if (n % 3 == 0) text.resize(rng.below(text.size()));
      for (std::uint64_t k = rng.below(6); k > 0 && !text.empty(); --k) {
        text[rng.below(rng.below(2) == 0 ? std::min<std::size_t>(text.size(), 300) : text.size())] =
            static_cast<char>(rng.below(256));
      }
      write_text(folder / name, text);
      try {
        const mesh::TriangleMesh mesh = read_mesh(folder / name);
        for (const auto& t : mesh.triangles) {
          for (const std::uint32_t v : t) ASSERT_LT(v, mesh.positions.size());
        }
        ASSERT_TRUE(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size());
      } catch (const Error& e) {
        EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
      }
    }
  }
}

}  // namespace
}  // namespace vol::io
