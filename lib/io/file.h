#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vol::io {

/// True for "-", which stands for standard input or output.
[[nodiscard]] bool is_standard_stream(const std::filesystem::path& path);

/// What a message calls a file that is read: its path, or "standard input".
[[nodiscard]] std::string display_name(const std::filesystem::path& path);
/// What a message calls a file that is written: its path, or "standard output".
[[nodiscard]] std::string output_name(const std::filesystem::path& path);

/// Sequential reader of a regular file or a pipe, buffered. Memory is never taken on a header's word alone:
/// read_exactly() into memory the caller sized must be preceded by require() where the size is known, and
/// for pipes grows with what really comes.
class InputFile {
 public:
  /// Opens a file, or standard input for "-". Throws vol::Error naming it.
  explicit InputFile(const std::filesystem::path& path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Total size in bytes; -1 for a pipe.
  [[nodiscard]] std::int64_t size() const { return size_; }
  /// Bytes consumed so far.
  [[nodiscard]] std::int64_t position() const { return position_; }
  /// The next n bytes without consuming them (fewer at the end): magic bytes. n <= 4096.
  [[nodiscard]] std::string_view peek(std::size_t n);
  /// Reads up to n bytes; less only at the end of the file.
  std::size_t read(void* to, std::size_t n);
  /// Reads exactly n bytes or throws `data ends after A of N bytes`.
  void read_exactly(void* to, std::size_t n);
  /// One text line without its line end; throws when it is longer than `limit` or the file has ended.
  [[nodiscard]] std::string read_line(std::size_t limit = 65536);
  [[nodiscard]] bool at_end();
  void skip(std::int64_t n);
  /// Throws `data ends after A of N bytes` where the file's size shows that n more bytes cannot come;
  /// for a pipe does nothing.
  void require(std::int64_t n) const;
  /// All that is left; throws when it is more than `limit` bytes.
  [[nodiscard]] std::vector<std::byte> read_rest(std::int64_t limit);

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::int64_t size_ = -1;
  std::int64_t position_ = 0;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  bool fill();
};

/// A file that appears whole or not at all: written beside its place under a temporary name, renamed by
/// commit(), removed when it goes out of scope uncommitted or when the process is interrupted.
/// "-" is standard output, written straight through. A symbolic link stays one: the file that it leads to is
/// written, whether that is there yet or not.
class OutputFile {
 public:
  explicit OutputFile(const std::filesystem::path& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(const void* data, std::size_t n);
  void write(std::string_view text) { write(text.data(), text.size()); }
  template <class T>
  void write(std::span<const T> data) {
    write(data.data(), data.size_bytes());
  }
  [[nodiscard]] std::int64_t bytes_written() const { return written_; }
  /// The temporary path, for libraries that insist on opening a file by name (call before any write()).
  [[nodiscard]] const std::filesystem::path& temporary_path() const { return temporary_; }
  /// Flushes and renames into place; throws vol::Error (full disk, ...) and leaves what was there before.
  void commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path place_;  // what path_ leads to
  std::filesystem::path temporary_;
  int descriptor_ = -1;
  std::int64_t written_ = 0;
  bool committed_ = false;
  std::vector<char> buffer_;
  void flush();
};

/// Throws vol::Error where a file could not be written at all: its folder is missing or closed, it is a
/// folder, write-protected, or a link that leads in a circle. For tools to ask before long work; a full disk
/// shows later.
void require_writable(const std::filesystem::path& path);

/// Removes every uncommitted output of this process. Async-signal-safe; called by the signal handler.
void remove_uncommitted_outputs() noexcept;

}  // namespace vol::io
