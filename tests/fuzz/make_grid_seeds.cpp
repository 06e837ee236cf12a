// make_grid_seeds FOLDER: small grids for the fuzzers to start from, in FOLDER/vts and FOLDER/plot3d.
#include <filesystem>
#include <fstream>

#include "io/grid.h"

namespace {

vol::curvilinear::Grid cube() {
  vol::curvilinear::Grid grid;
  auto& block = grid.blocks.emplace_back();
  block.dims = {2, 2, 2};
  for (int n = 0; n < 8; ++n) block.points.emplace_back(n & 1, n >> 1 & 1, n >> 2);
  block.arrays.push_back({"f", std::vector<double>(8, 0.5)});
  block.hidden = {0, 0, 0, 1, 0, 0, 0, 0};
  return grid;
}

/// One block of 2 x 2 x 2 points: integers and then reals, as text or of type Real.
template <class Real>
std::string numbers(bool text, bool records, const std::vector<std::int32_t>& integers,
                    const std::vector<std::vector<double>>& chunks) {
  std::string all;
  const auto record = [&](const std::string& bytes) {
    const auto length = static_cast<std::int32_t>(bytes.size());
    const std::string mark(reinterpret_cast<const char*>(&length), records ? sizeof length : 0);
    all += mark + bytes + mark;
  };
  std::string head;
  for (const std::int32_t n : integers) {
    head += text ? std::to_string(n) + " " : std::string(reinterpret_cast<const char*>(&n), sizeof n);
  }
  record(head);
  for (const auto& chunk : chunks) {
    std::string body;
    for (const double x : chunk) {
      const Real real = static_cast<Real>(x);
      body += text ? std::to_string(x) + " " : std::string(reinterpret_cast<const char*>(&real), sizeof real);
    }
    record(body);
  }
  return all;
}

template <class Real>
void write(const std::filesystem::path& path, bool text, bool records) {
  std::vector<double> positions, solution(40, 1.5);
  for (int a = 0; a < 3; ++a) {
    for (int n = 0; n < 8; ++n) positions.push_back(n >> a & 1);
  }
  const std::string xyz = numbers<Real>(text, records, {2, 2, 2}, {positions});
  const std::string q = numbers<Real>(text, records, {2, 2, 2}, {{0.5, 0, 1, 0}, solution});
  std::ofstream(path, std::ios::binary)
      << static_cast<char>(xyz.size() % 256) << static_cast<char>(xyz.size() / 256) << xyz << q;
}

}  // namespace

int main(int, char** argv) {
  const std::filesystem::path folder(argv[1]);
  std::filesystem::create_directories(folder / "vts");
  std::filesystem::create_directories(folder / "plot3d");
  (void)vol::io::write_grid(folder / "vts/cube.vts", cube());
  write<float>(folder / "plot3d/text", true, false);
  write<float>(folder / "plot3d/f32", false, false);
  write<double>(folder / "plot3d/f64-records", false, true);
}
