// VolPack's shear-warp (Lacroute & Levoy 1994), asked for one frame a line: one thread, 8 bits, one sample a
// slice, at the volume's resolution and then warped.
//
//   volpack VOLUME.nrrd EDGE SIZE HALF_WIDTH RIGHT UP VALUE OPACITY [VALUE OPACITY ...]
//
// Standard input: azimuth, elevation and a file for the picture (PGM, linear grey) or -; standard output:
// {"seconds"}. RIGHT and UP move the volume by so many voxels. Grey is the value; unshaded: its lookup shader
// is given the value in the place of the normal.
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <vector>
extern "C" {
#include <volpack.h>
}

namespace {

struct Voxel {
  short shade;
  unsigned char value, gradient;
};

void require(vpContext* context, vpResult result, const char* what) {
  if (result == VP_OK) return;
  std::fprintf(stderr, "volpack: %s: %s\n", what, vpGetErrorString(vpGetError(context)));
  std::exit(2);
}

std::vector<Voxel> read(const char* path, int edge) {
  const auto count = static_cast<std::streamoff>(edge) * edge * edge;
  std::vector<unsigned char> values(static_cast<std::size_t>(count));
  std::ifstream file(path, std::ios::binary);
  file.seekg(-count, std::ios::end);  // the samples of a raw NRRD are its end
  if (!file.read(reinterpret_cast<char*>(values.data()), count)) std::exit(2);
  std::vector<Voxel> voxels(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) voxels[i] = {values[i], values[i], 0};
  return voxels;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 11) return 2;
  const int edge = std::atoi(argv[2]), size = std::atoi(argv[3]);
  const double half = std::atof(argv[4]), right = std::atof(argv[5]) / edge, up = std::atof(argv[6]) / edge;
  auto voxels = read(argv[1], edge);
  std::vector<int> at;
  std::vector<float> opacity;
  for (int i = 7; i + 1 < argc; i += 2) {
    at.push_back(std::atoi(argv[i]));
    opacity.push_back(static_cast<float>(std::atof(argv[i + 1])));
  }
  if (at.back() < 255) {
    at.push_back(255);
    opacity.push_back(opacity.back());
  }
  vpContext* c = vpCreateContext();
  vpSetVolumeSize(c, edge, edge, edge);
  vpSetVoxelSize(c, sizeof(Voxel), 3, 2, 2);
  vpSetVoxelField(c, 0, sizeof(short), offsetof(Voxel, shade), VP_NORM_MAX);
  vpSetVoxelField(c, 1, 1, offsetof(Voxel, value), 255);
  vpSetVoxelField(c, 2, 1, offsetof(Voxel, gradient), VP_GRAD_MAX);
  const int row = edge * static_cast<int>(sizeof(Voxel));
  vpSetRawVoxels(c, voxels.data(), static_cast<int>(voxels.size() * sizeof(Voxel)), sizeof(Voxel), row,
                 edge * row);
  std::vector<float> ramp(256), gradients(VP_GRAD_MAX + 1, 1.F), grey(VP_NORM_MAX + 1, 255.F);
  vpRamp(ramp.data(), sizeof(float), static_cast<int>(at.size()), at.data(), opacity.data());
  for (int i = 0; i < 256; ++i) grey[i] = static_cast<float>(i);
  require(c, vpSetClassifierTable(c, 0, 1, ramp.data(), 256 * sizeof(float)), "opacity");
  require(c,
          vpSetClassifierTable(c, 1, 2, gradients.data(), static_cast<int>(gradients.size() * sizeof(float))),
          "gradient");
  require(c,
          vpSetLookupShader(c, 1, 1, 0, grey.data(), static_cast<int>(grey.size() * sizeof(float)), 0,
                            nullptr, 0),
          "grey");
  vpSetd(c, VP_MIN_VOXEL_OPACITY, .001);
  vpSetd(c, VP_MAX_RAY_OPACITY, .98);
  vpSeti(c, VP_CONCAT_MODE, VP_CONCAT_LEFT);
  std::vector<unsigned char> picture(static_cast<std::size_t>(size) * size);
  require(c, vpSetImage(c, picture.data(), size, size, size, VP_LUMINANCE), "image");
  require(c, vpClassifyVolume(c), "classification");
  double azimuth = 0, elevation = 0;
  char path[1000];
  while (std::scanf("%lf %lf %999s", &azimuth, &elevation, path) == 3) {
    vpCurrentMatrix(c, VP_MODEL);
    vpIdentityMatrix(c);
    vpRotate(c, VP_Y_AXIS, azimuth);
    vpRotate(c, VP_X_AXIS, -elevation);
    vpTranslate(c, right, up, 0);
    vpScale(c, 1, 1, -1);  // it looks along +z
    vpCurrentMatrix(c, VP_PROJECT);
    vpIdentityMatrix(c);
    vpWindow(c, VP_PARALLEL, -half, half, -half, half, -1, 1);
    const auto start = std::chrono::steady_clock::now();
    require(c, vpRenderClassifiedVolume(c), "rendering");
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (path[0] != '-') {
      if (std::FILE* file = std::fopen(path, "wb")) {
        std::fprintf(file, "P5\n%d %d\n255\n", size, size);
        for (int y = size - 1; y >= 0; --y)
          std::fwrite(&picture[static_cast<std::size_t>(y) * size], 1, size, file);
        std::fclose(file);
      }
    }
    std::printf("{\"seconds\": %.6f}\n", seconds);
    std::fflush(stdout);
  }
}
