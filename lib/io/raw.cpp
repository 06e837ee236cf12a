#include "base/error.h"
#include "io/volume_formats.h"
#include "io/voxel_data.h"

namespace vol::io {

volume::Volume read_raw(InputFile& file, const ReadOptions& options) {
  const RawLayout& raw = options.raw.value();
  const std::string name = display_name(file.path());
  VoxelLayout layout;
  layout.type = raw.type;
  layout.big_endian = raw.big_endian;
  layout.geometry.dims = raw.dims;
  layout.geometry.spacing = raw.spacing;
  const std::int64_t bytes = checked_bytes(name, layout, options);
  if (raw.skip < 0)
    throw Error(name + ": " + std::to_string(raw.skip) + " bytes to skip, expected 0 or more");
  FileSource source(file);
  const std::int64_t known = source.remaining();
  if (known >= 0 && (known < raw.skip || known - raw.skip != bytes)) {
    const Dims& d = raw.dims;
    throw Error(name + ": holds " + std::to_string(known) + " bytes, but a header of " +
                std::to_string(raw.skip) + " bytes and " + std::to_string(d[0]) + "x" + std::to_string(d[1]) +
                "x" + std::to_string(d[2]) + " voxels of type " + std::string(volume::name(raw.type)) + " (" +
                std::to_string(bytes) + " bytes) were expected");
  }
  source.skip(raw.skip);
  volume::Volume volume = read_binary(source, layout, options);
  expect_end(source, bytes);
  return volume;
}

Warnings write_raw(const std::filesystem::path& path, const volume::Volume& volume) {
  OutputFile out(path);
  with_voxel_bytes(volume, [&](const void* data, std::size_t n) { out.write(data, n); });
  out.commit();
  const auto& d = volume.geometry().dims;
  return {"raw holds voxels alone: read it with --raw-dims " + std::to_string(d[0]) + "x" +
          std::to_string(d[1]) + "x" + std::to_string(d[2]) + " --raw-type " +
          std::string(volume::name(volume.voxel_type()))};
}

}  // namespace vol::io
