#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace vol::cli {

/// SHA-256 (FIPS 180-4), fed piece by piece.
class Sha256 {
 public:
  void update(std::span<const std::byte> data);
  void update(const void* data, std::size_t n) { update({static_cast<const std::byte*>(data), n}); }
  /// The digest of all that came so far, as 64 lower-case hexadecimal digits. Ends the hash.
  [[nodiscard]] std::string hex();

 private:
  void block(const std::byte* data);
  std::array<std::uint32_t, 8> state_ = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                         0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::byte, 64> pending_{};
  std::size_t pending_size_ = 0;
  std::uint64_t length_ = 0;
};

[[nodiscard]] std::string sha256_hex(std::span<const std::byte> data);

}  // namespace vol::cli
