#include "curvilinear/face.h"

#include "base/parallel.h"

namespace vol::curvilinear {

FacePatch face_patch(const Block& block, const Face& face, CellKind kind, double beta) {
  // In the order of the solids' own operators, the lower axis first, so that rounding is theirs.
  const std::size_t axis = face.axis;
  const std::size_t first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
  const CurveOperator c1(face.at[first], block.dims[first], kind, beta);
  const CurveOperator c2(face.at[second], block.dims[second], kind, beta);
  Dims at{face.at[0], face.at[1], face.at[2]};
  Vec3 samples[4], b[4], along[4][4];  // [control point along first][sample along second]
  for (int j = 0; j < c2.count(); ++j) {
    at[second] = c2.first() + j;
    for (int i = 0; i < c1.count(); ++i) {
      at[first] = c1.first() + i;
      samples[i] = block.points[block.offset(at[0], at[1], at[2])];
    }
    c1(samples, b);
    for (int r = 0; r < 4; ++r) along[r][j] = b[r];
  }
  FacePatch patch;
  const bool turned = axis == 1;  // u along z, v along x
  for (int r = 0; r < 4; ++r) {
    c2(along[r], b);
    for (int s = 0; s < 4; ++s) patch[static_cast<std::size_t>(turned ? s + 4 * r : r + 4 * s)] = b[s];
  }
  return patch;
}

Vec3 cell_parameters(const Face& face, bool before, double u, double v) {
  Vec3 p;
  const int axis = static_cast<int>(face.axis);
  p[axis] = before ? 1 : 0;
  p[(axis + 1) % 3] = u;
  p[(axis + 2) % 3] = v;
  return p;
}

int handedness(const Block& block) {
  const Dims cells = block.cells();
  const double volume = parallel_reduce<double>(
      0, block.cell_count(), 4096,
      [&](std::int64_t begin, std::int64_t end) {
        double sum = 0;
        for (auto n = begin; n < end; ++n) {
          const std::size_t at =
              block.offset(n % cells[0], n / cells[0] % cells[1], n / (cells[0] * cells[1]));
          Mat3 d = Mat3::Zero();
          for (int corner = 0; corner < 8; ++corner) {
            const Vec3& p = block.points[at + block.offset(corner & 1, corner >> 1 & 1, corner >> 2)];
            for (int a = 0; a < 3; ++a) d.col(a) += (corner >> a & 1) != 0 ? Vec3(p) : Vec3(-p);
          }
          sum += d.determinant();
        }
        return sum;
      },
      [](double& sum, double part) { sum += part; });
  return volume < 0 ? -1 : 1;
}

}  // namespace vol::curvilinear
