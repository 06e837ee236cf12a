#pragma once
#include <cstddef>
#include <ios>
#include <span>
#include <streambuf>
#include <string>
#include <string_view>
#include <vector>

// Private to lib/io: an OpenVDB file as bytes in memory, without OpenVDB.
namespace vol::io {

/// The first bytes of an OpenVDB file.
inline constexpr std::string_view kVdbMagic{"\x20\x42\x44\x56\0\0\0\0", 8};

/// Bytes in memory that a stream reads and seeks in.
class MemoryInput : public std::streambuf {
 public:
  explicit MemoryInput(std::vector<std::byte>& bytes) {
    auto* first = reinterpret_cast<char*>(bytes.data());
    setg(first, first, first + bytes.size());
  }

 private:
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    const off_type base = from == std::ios::beg   ? 0
                          : from == std::ios::cur ? gptr() - eback()
                                                  : egptr() - eback();
    if (offset > (egptr() - eback()) - base || offset < -base) return pos_type(off_type(-1));
    setg(eback(), eback() + base + offset, egptr());
    return base + offset;
  }
  pos_type seekpos(pos_type position, std::ios_base::openmode which) override {
    return seekoff(off_type(position), std::ios::beg, which);
  }
};

/// Memory that grows with what a stream writes.
class MemoryOutput : public std::streambuf {
 public:
  std::string bytes;

 private:
  std::streamsize xsputn(const char* data, std::streamsize n) override {
    bytes.append(data, static_cast<std::size_t>(n));
    return n;
  }
  int_type overflow(int_type c) override {
    if (!traits_type::eq_int_type(c, traits_type::eof())) bytes.push_back(traits_type::to_char_type(c));
    return traits_type::not_eof(c);
  }
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    const bool tell = offset == 0 && from != std::ios::beg;  // OpenVDB asks where it is; it never goes back
    return tell ? pos_type(static_cast<off_type>(bytes.size())) : pos_type(off_type(-1));
  }
};

/// Puts an id in place of OpenVDB's random one that follows from the content of the file. Throws vol::Error
/// for bytes too few to hold one.
void set_content_id(std::string& bytes);

/// False where bytes are too few for an id, or the id says that set_content_id() made it and it does not
/// follow from the content: the file was damaged after it was written. Ids of other programs say nothing.
[[nodiscard]] bool is_intact(std::span<std::byte> bytes);

}  // namespace vol::io
