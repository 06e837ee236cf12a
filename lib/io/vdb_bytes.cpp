#include "io/vdb_bytes.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "base/error.h"

namespace vol::io {
namespace {

constexpr std::size_t kIdAt = 21;    // magic 8, file version 4, library version 8, offsets flag 1
constexpr std::size_t kIdSize = 36;  // a UUID as text

/// An id that follows from the content: two 64-bit FNV-1a hashes over words, in the layout of a UUID of
/// version 8.
std::string content_id(std::string_view bytes) {
  std::uint64_t a = 0xcbf29ce484222325u;
  std::uint64_t b = 0x9e3779b97f4a7c15u;
  for (std::size_t n = 0; n < bytes.size(); n += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + n, std::min<std::size_t>(8, bytes.size() - n));
    a = (a ^ word) * 0x100000001b3u;
    a ^= a >> 29;
    b = (b + word) * 0xbf58476d1ce4e5b9u;
    b ^= b >> 31;
  }
  constexpr std::string_view kLayout = "xxxxxxxx-xxxx-8xxx-9xxx-xxxxxxxxxxxx";
  std::string id(kLayout);
  int digit = 0;
  for (char& c : id) {
    if (c != 'x') continue;
    const std::uint64_t half = digit < 16 ? a : b;
    c = "0123456789abcdef"[half >> (4 * (digit % 16)) & 15];
    ++digit;
  }
  return id;
}

}  // namespace

void set_content_id(std::string& bytes) {
  if (bytes.size() < kIdAt + kIdSize) throw Error("OpenVDB wrote nothing");
  bytes.replace(kIdAt, kIdSize, std::string(kIdSize, '0'));
  bytes.replace(kIdAt, kIdSize, content_id(bytes));
}

bool is_intact(std::span<std::byte> bytes) {
  if (bytes.size() < kIdAt + kIdSize) return false;
  auto* const id_at = reinterpret_cast<char*>(bytes.data()) + kIdAt;
  const std::string id(id_at, kIdSize);
  if (id[14] != '8' || id[19] != '9') return true;
  std::fill_n(id_at, kIdSize, '0');
  const bool intact = content_id({reinterpret_cast<const char*>(bytes.data()), bytes.size()}) == id;
  std::copy(id.begin(), id.end(), id_at);
  return intact;
}

}  // namespace vol::io
