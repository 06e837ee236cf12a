#pragma once
#include <zlib.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "io/file.h"

// Private to lib/io: streams of bytes that readers chain (file, part of it, base64, deflate, pieces in
// several files). Nothing here takes memory on a header's word.
namespace vol::io {

/// A stream of bytes with the name that messages give it.
class ByteSource {
 public:
  explicit ByteSource(std::string name) : name_(std::move(name)) {}
  virtual ~ByteSource() = default;
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  /// Up to n bytes; fewer only at the end.
  virtual std::size_t read(void* to, std::size_t n) = 0;
  /// Bytes that can still come; -1 where it is not known.
  [[nodiscard]] virtual std::int64_t remaining() const { return -1; }
  /// n bytes, or an error `data ends after A of N bytes`.
  void read_exactly(void* to, std::size_t n);
  void skip(std::int64_t n);

 private:
  std::string name_;
};

/// What is left of an open file.
class FileSource : public ByteSource {
 public:
  explicit FileSource(InputFile& file) : ByteSource(display_name(file.path())), file_(file) {}
  std::size_t read(void* to, std::size_t n) override { return file_.read(to, n); }
  [[nodiscard]] std::int64_t remaining() const override;

 private:
  InputFile& file_;
};

class MemorySource : public ByteSource {
 public:
  MemorySource(std::string name, std::string_view bytes) : ByteSource(std::move(name)), bytes_(bytes) {}
  std::size_t read(void* to, std::size_t n) override;
  [[nodiscard]] std::int64_t remaining() const override { return static_cast<std::int64_t>(bytes_.size()); }

 private:
  std::string_view bytes_;
};

/// At most the next `limit` bytes of another source.
class LimitedSource : public ByteSource {
 public:
  LimitedSource(ByteSource& from, std::int64_t limit) : ByteSource(from.name()), from_(from), left_(limit) {}
  std::size_t read(void* to, std::size_t n) override;
  [[nodiscard]] std::int64_t remaining() const override;

 private:
  ByteSource& from_;
  std::int64_t left_;
};

/// A zlib or gzip stream, told apart by its first bytes; a gzip stream may have several members. Inflates
/// only what is asked for: a small stream that swells without end costs nothing beyond what its reader wants.
class InflateSource : public ByteSource {
 public:
  explicit InflateSource(ByteSource& from);
  ~InflateSource() override;
  std::size_t read(void* to, std::size_t n) override;

 private:
  ByteSource& from_;
  z_stream stream_{};
  std::vector<unsigned char> input_;
  bool gzip_ = false;
  bool ended_ = false;
  bool refill();
};

/// Base64 text up to its end or a '<'. Padding ends a run, and another run may follow at once, as VTK writes
/// it.
class Base64Source : public ByteSource {
 public:
  explicit Base64Source(ByteSource& from) : ByteSource(from.name()), from_(from), input_(1 << 14) {}
  std::size_t read(void* to, std::size_t n) override;

 private:
  ByteSource& from_;
  std::vector<unsigned char> input_;
  std::size_t begin_ = 0, end_ = 0;
  unsigned char decoded_[3] = {};
  int decoded_at_ = 0, decoded_size_ = 0;
  bool ended_ = false;
  int next_character();
  bool decode_quartet();
};

/// Opens a file that a header names; it must be a regular one, so that no device or pipe is waited for.
[[nodiscard]] std::unique_ptr<InputFile> open_data_file(const std::filesystem::path& path);

/// How a header says that its data lie in other files.
struct DataFiles {
  std::vector<std::filesystem::path> paths;
  std::int64_t bytes_each = 0;  ///< after inflation
  std::int64_t line_skip = 0;   ///< lines before the data of each file
  std::int64_t byte_skip =
      0;  ///< bytes after them (of the inflated stream, if it is one); -1: data end the file
  bool inflate = false;
};

/// The data of detached headers: `bytes_each` bytes from each file in turn. A file that holds fewer or more
/// is refused by its own name.
class DataFilesSource : public ByteSource {
 public:
  explicit DataFilesSource(DataFiles files);
  std::size_t read(void* to, std::size_t n) override;
  [[nodiscard]] std::int64_t remaining() const override;

 private:
  DataFiles files_;
  std::size_t next_ = 0;
  std::int64_t left_ = 0;  ///< of the open file
  std::unique_ptr<InputFile> file_;
  std::unique_ptr<FileSource> raw_;
  std::unique_ptr<InflateSource> inflated_;
  [[nodiscard]] ByteSource& open() const;
  void open_next();
};

/// Words and lines of text from a source, and the bytes between them.
class Scanner : public ByteSource {
 public:
  explicit Scanner(ByteSource& from) : ByteSource(from.name()), from_(from), buffer_(1 << 16) {}
  /// The next word, valid until the next call; empty at the end. Throws for a word over 4096 bytes.
  [[nodiscard]] std::string_view word();
  /// The rest of the line, without its end; throws when longer than 65536 bytes.
  [[nodiscard]] std::string line();
  [[nodiscard]] bool at_end() { return begin_ == end_ && !fill(); }
  std::size_t read(void* to, std::size_t n) override;
  [[nodiscard]] std::int64_t remaining() const override;

 private:
  ByteSource& from_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;
  bool fill();
};

/// Throws `name: holds more than the N bytes its header promises` unless the source has ended.
void expect_end(ByteSource& source, std::int64_t bytes);

}  // namespace vol::io
