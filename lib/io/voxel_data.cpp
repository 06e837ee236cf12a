#include "io/voxel_data.h"

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "base/checked.h"
#include "base/error.h"
#include "base/heap.h"
#include "base/parallel.h"
#include "io/header_text.h"

namespace vol::io {
namespace {

static_assert(std::endian::native == std::endian::little, "the readers swap big-endian data only");

constexpr std::size_t kFirstRoom = std::size_t{64} << 20;  // bytes; untouched pages of it cost nothing

/// Calls fill(voxels, from, to) until all `total` voxels are there, with room for the next ones made before:
/// at once where their coming is certain, else in doubling steps.
template <class T, class Fill>
void grow(Buffer<T>& voxels, std::size_t total, bool certain, const Fill& fill) {
  std::size_t have = 0;
  while (have < total) {
    const std::size_t room = certain ? total : std::max(2 * have, kFirstRoom / sizeof(T));
    const std::size_t next = std::min(total, room);
    voxels.reserve(next);
    voxels.resize(next);
    prefer_large_pages(voxels.data() + have, (next - have) * sizeof(T));
    fill(voxels, have, next);
    have = next;
  }
}

template <class T>
void swap_bytes(Buffer<T>& voxels) {
  if constexpr (sizeof(T) > 1) {
    parallel_for(0, static_cast<std::int64_t>(voxels.size()), 1 << 18,
                 [&](std::int64_t begin, std::int64_t end) {
                   for (std::int64_t n = begin; n < end; ++n) {
                     unsigned char bytes[sizeof(T)];
                     std::memcpy(bytes, &voxels[static_cast<std::size_t>(n)], sizeof(T));
                     std::reverse(bytes, bytes + sizeof(T));
                     std::memcpy(static_cast<void*>(&voxels[static_cast<std::size_t>(n)]), bytes, sizeof(T));
                   }
                 });
  }
}

template <class T>
T parse_voxel(const std::string& name, std::string_view word, volume::VoxelType type) {
  const auto refuse = [&] {
    throw Error(name + ": " + in_quotes(word) + " among the data is not a " + std::string(volume::name(type)));
  };
  std::string_view digits = word;
  if (!digits.empty() && digits.front() == '+') digits.remove_prefix(1);
  const char* end = digits.data() + digits.size();
  if constexpr (std::is_integral_v<T>) {
    std::int64_t whole = 0;
    const auto result = std::from_chars(digits.data(), end, whole);
    if (result.ec == std::errc{} && result.ptr == end) {
      if (whole < std::numeric_limits<T>::min() || whole > std::numeric_limits<T>::max()) refuse();
      return static_cast<T>(whole);
    }
  }
  double value = 0;
  const auto result = std::from_chars(digits.data(), end, value);
  if (result.ptr != end || digits.empty() || result.ec == std::errc::invalid_argument) refuse();
  if (result.ec == std::errc::result_out_of_range) value = std::strtod(std::string(digits).c_str(), nullptr);
  if constexpr (std::is_integral_v<T>) {
    if (!(value >= std::numeric_limits<T>::min() && value <= std::numeric_limits<T>::max()) ||
        value != std::trunc(value)) {
      refuse();  // "3.0" for an integer is met in the wild, "3.5" is not one
    }
    return static_cast<T>(value);
  } else if constexpr (std::is_same_v<T, double>) {
    return value;
  } else {
    if (std::isfinite(value) && std::abs(value) > static_cast<double>(std::numeric_limits<T>::max()))
      refuse();
    return static_cast<T>(static_cast<float>(value));
  }
}

}  // namespace

std::int64_t ReadOptions::physical_memory() {
  const auto pages = static_cast<std::int64_t>(::sysconf(_SC_PHYS_PAGES));
  const auto page = static_cast<std::int64_t>(::sysconf(_SC_PAGESIZE));
  return pages > 0 && page > 0 ? pages * page : std::numeric_limits<std::int64_t>::max();
}

std::int64_t checked_bytes(const std::string& name, const VoxelLayout& layout, const ReadOptions& options) {
  std::int64_t bytes = 0;
  try {
    layout.geometry.validate();
    bytes = checked_product(layout.geometry.count(),
                            static_cast<std::int64_t>(volume::size_in_bytes(layout.type)));
  } catch (const Error& e) {
    throw Error(name, e);
  }
  if (bytes > options.memory_limit) {
    const Dims& d = layout.geometry.dims;
    throw Error(name + ": " + std::to_string(d[0]) + " x " + std::to_string(d[1]) + " x " +
                std::to_string(d[2]) + " voxels need " + std::to_string(bytes) + " bytes, more than the " +
                std::to_string(options.memory_limit) + " of memory there are");
  }
  return bytes;
}

volume::Volume read_binary(ByteSource& source, const VoxelLayout& layout, const ReadOptions& options) {
  const std::int64_t bytes = checked_bytes(source.name(), layout, options);
  const std::int64_t known = source.remaining();
  if (known >= 0 && known < bytes) {
    throw Error(source.name() + ": data ends after " + std::to_string(known) + " of " +
                std::to_string(bytes) + " bytes");
  }
  return volume::dispatch(layout.type, [&]<class T>() {
    volume::Grid<T> grid;
    grid.geometry = layout.geometry;
    grow(grid.voxels, static_cast<std::size_t>(layout.geometry.count()), known >= 0,
         [&](Buffer<T>& voxels, std::size_t from, std::size_t to) {
           const std::size_t wanted = (to - from) * sizeof(T);
           const std::size_t got = source.read(static_cast<void*>(voxels.data() + from), wanted);
           if (got != wanted) {
             throw Error(source.name() + ": data ends after " + std::to_string(from * sizeof(T) + got) +
                         " of " + std::to_string(bytes) + " bytes");
           }
         });
    if (layout.big_endian) swap_bytes(grid.voxels);
    volume::Volume result;
    result.grid = std::move(grid);
    return result;
  });
}

volume::Volume read_ascii(Scanner& scanner, const VoxelLayout& layout, const ReadOptions& options) {
  (void)checked_bytes(scanner.name(), layout, options);
  const std::int64_t count = layout.geometry.count();
  const std::int64_t known = scanner.remaining();
  // A digit and a space a number, at the very least.
  const auto refuse = [&](std::int64_t got) {
    throw Error(scanner.name() + ": data ends after " + std::to_string(got) + " of " + std::to_string(count) +
                " numbers");
  };
  if (known >= 0 && known / 2 + 1 < count) refuse(known / 2 + 1);
  return volume::dispatch(layout.type, [&]<class T>() {
    volume::Grid<T> grid;
    grid.geometry = layout.geometry;
    grow(grid.voxels, static_cast<std::size_t>(count), false,
         [&](Buffer<T>& voxels, std::size_t from, std::size_t to) {
           for (std::size_t n = from; n < to; ++n) {
             const std::string_view word = scanner.word();
             if (word.empty()) refuse(static_cast<std::int64_t>(n));
             voxels[n] = parse_voxel<T>(scanner.name(), word, layout.type);
           }
         });
    volume::Volume result;
    result.grid = std::move(grid);
    return result;
  });
}

void deflate_to(const void* data, std::size_t n, bool gzip,
                const std::function<void(const void*, std::size_t)>& sink) {
  z_stream stream{};
  const int window_bits = gzip ? 15 + 16 : 15;
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY) != Z_OK) {
    throw Error("zlib has no memory");
  }
  struct End {
    z_stream& stream;
    ~End() { deflateEnd(&stream); }
  } const end{stream};
  std::vector<unsigned char> out(1 << 16);
  auto* in = const_cast<unsigned char*>(
      static_cast<const unsigned char*>(data));  // zlib's interface lacks the const
  int status = Z_OK;
  while (status != Z_STREAM_END) {
    const std::size_t part = std::min<std::size_t>(n, 1U << 30);
    if (stream.avail_in == 0) {
      stream.next_in = in;
      stream.avail_in = static_cast<uInt>(part);
      in += part;
      n -= part;
    }
    stream.next_out = out.data();
    stream.avail_out = static_cast<uInt>(out.size());
    status = deflate(&stream, n == 0 ? Z_FINISH : Z_NO_FLUSH);
    if (status != Z_OK && status != Z_STREAM_END && status != Z_BUF_ERROR)
      throw Error("zlib cannot compress");
    sink(out.data(), out.size() - stream.avail_out);
  }
}

volume::Volume widened(const volume::Volume& volume) {
  volume::Volume wide;
  wide.grid = volume::converted<float>(volume);
  wide.attributes = volume.attributes;
  wide.attributes[kVoxelTypeAttribute] = "f16";
  return wide;
}

void narrow_if_marked(volume::Volume& volume) {
  const auto mark = volume.attributes.find(kVoxelTypeAttribute);
  if (mark == volume.attributes.end() || mark->second != "f16") return;
  const auto* wide = std::get_if<volume::Grid<float>>(&volume.grid);
  if (wide == nullptr) return;
  const bool exact = std::all_of(wide->voxels.begin(), wide->voxels.end(),
                                 [](float v) { return static_cast<float>(volume::half(v)) == v; });
  if (!exact) return;
  volume.grid = volume::converted<volume::half>(volume);
  volume.attributes.erase(mark);
}

}  // namespace vol::io
