#include "io/byte_source.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>

#include "base/error.h"

namespace vol::io {
namespace {

[[noreturn]] void ends_early(const std::string& name, std::int64_t got, std::int64_t wanted) {
  throw Error(name + ": data ends after " + std::to_string(got) + " of " + std::to_string(wanted) + " bytes");
}

}  // namespace

void ByteSource::read_exactly(void* to, std::size_t n) {
  const std::size_t got = read(to, n);
  if (got != n) ends_early(name_, static_cast<std::int64_t>(got), static_cast<std::int64_t>(n));
}

void ByteSource::skip(std::int64_t n) {
  if (n < 0) throw Error(name_ + ": negative number of bytes to skip");
  const std::int64_t known = remaining();
  if (known >= 0 && known < n) ends_early(name_, known, n);
  std::array<char, 16384> scratch;
  for (std::int64_t done = 0; done < n;) {
    const auto part = std::min<std::int64_t>(n - done, scratch.size());
    const auto got = static_cast<std::int64_t>(read(scratch.data(), static_cast<std::size_t>(part)));
    done += got;
    if (got != part) ends_early(name_, done, n);
  }
}

std::int64_t FileSource::remaining() const {
  return file_.size() < 0 ? -1 : std::max<std::int64_t>(0, file_.size() - file_.position());
}

std::size_t MemorySource::read(void* to, std::size_t n) {
  const std::size_t part = std::min(n, bytes_.size());
  if (part > 0) std::memcpy(to, bytes_.data(), part);
  bytes_.remove_prefix(part);
  return part;
}

std::size_t LimitedSource::read(void* to, std::size_t n) {
  const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(n, static_cast<std::uint64_t>(left_)));
  const std::size_t got = from_.read(to, part);
  left_ = got == part ? left_ - static_cast<std::int64_t>(got) : 0;
  return got;
}

std::int64_t LimitedSource::remaining() const {
  const std::int64_t known = from_.remaining();
  return known < 0 ? -1 : std::min(known, left_);
}

InflateSource::InflateSource(ByteSource& from) : ByteSource(from.name()), from_(from), input_(1 << 16) {
  constexpr int kWindowBitsTellingTheWrapper = 15 + 32;
  if (inflateInit2(&stream_, kWindowBitsTellingTheWrapper) != Z_OK)
    throw Error(name() + ": zlib has no memory");
  gzip_ = refill() && stream_.next_in[0] == 0x1f;
}

InflateSource::~InflateSource() {
  inflateEnd(&stream_);
}

bool InflateSource::refill() {
  stream_.next_in = input_.data();
  stream_.avail_in = static_cast<uInt>(from_.read(input_.data(), input_.size()));
  return stream_.avail_in > 0;
}

std::size_t InflateSource::read(void* to, std::size_t n) {
  auto* out = static_cast<unsigned char*>(to);
  std::size_t done = 0;
  while (done < n && !ended_) {
    if (stream_.avail_in == 0 && !refill()) {
      if (done == 0) throw Error(name() + ": compressed data are cut off");
      break;  // the caller finds its data short
    }
    const auto part = static_cast<uInt>(std::min<std::size_t>(n - done, 1U << 30));
    stream_.next_out = out + done;
    stream_.avail_out = part;
    const int status = inflate(&stream_, Z_NO_FLUSH);
    done += part - stream_.avail_out;
    if (status == Z_STREAM_END) {
      const bool more = gzip_ && (stream_.avail_in > 0 || refill()) && stream_.next_in[0] == 0x1f;
      ended_ = !more || inflateReset(&stream_) != Z_OK;
    } else if (status != Z_OK && status != Z_BUF_ERROR) {
      throw Error(name() + ": compressed data are damaged after " + std::to_string(done) +
                  " bytes of this part (" + (stream_.msg != nullptr ? stream_.msg : "zlib error") + ")");
    }
  }
  return done;
}

int Base64Source::next_character() {
  for (;;) {
    if (begin_ == end_) {
      begin_ = 0;
      end_ = from_.read(input_.data(), input_.size());
      if (end_ == 0) return -1;
    }
    const int c = input_[begin_];
    if (c == '<') return -1;
    ++begin_;
    if (std::isspace(c) == 0) return c;
  }
}

bool Base64Source::decode_quartet() {
  static constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  static const auto kValues = [] {
    std::array<int, 256> values{};
    values.fill(-1);
    for (std::size_t i = 0; i < kDigits.size(); ++i)
      values[static_cast<unsigned char>(kDigits[i])] = static_cast<int>(i);
    return values;
  }();
  std::uint32_t bits = 0;
  int digits = 0;
  for (int i = 0; i < 4; ++i) {
    const int c = next_character();
    if (c < 0) {
      if (i == 0) return false;
      throw Error(name() + ": base64 data end inside a group of four");
    }
    const int value = c == '=' ? 0 : kValues[static_cast<std::size_t>(c)];
    if (value < 0 || (c == '=' && i < 2) || (c != '=' && digits < i)) {
      throw Error(name() + ": base64 data hold a character that is none of base64 (code " +
                  std::to_string(c) + ")");
    }
    if (c != '=') ++digits;
    bits = bits << 6 | static_cast<std::uint32_t>(value);
  }
  for (int i = 0; i < 3; ++i) decoded_[i] = static_cast<unsigned char>(bits >> (16 - 8 * i));
  decoded_at_ = 0;
  decoded_size_ = digits - 1;
  return true;
}

std::size_t Base64Source::read(void* to, std::size_t n) {
  auto* out = static_cast<unsigned char*>(to);
  std::size_t done = 0;
  while (done < n) {
    if (decoded_at_ == decoded_size_) {
      if (ended_ || !decode_quartet()) {
        ended_ = true;
        break;
      }
    }
    out[done++] = decoded_[decoded_at_++];
  }
  return done;
}

std::unique_ptr<InputFile> open_data_file(const std::filesystem::path& path) {
  std::error_code ignored;
  const auto status = std::filesystem::status(path, ignored);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    throw Error(path.string() + ": is not a regular file, expected the data that the header names");
  }
  return std::make_unique<InputFile>(path);
}

DataFilesSource::DataFilesSource(DataFiles files)
    : ByteSource(files.paths.at(0).string()), files_(std::move(files)) {
  open_next();
}

ByteSource& DataFilesSource::open() const {
  return inflated_ ? static_cast<ByteSource&>(*inflated_) : static_cast<ByteSource&>(*raw_);
}

void DataFilesSource::open_next() {
  inflated_.reset();
  raw_.reset();
  file_ = open_data_file(files_.paths[next_++]);
  for (std::int64_t line = 0; line < files_.line_skip; ++line) (void)file_->read_line(std::size_t{1} << 24);
  if (files_.byte_skip < 0) {
    file_->require(files_.bytes_each);
    file_->skip(file_->size() - file_->position() - files_.bytes_each);
  }
  raw_ = std::make_unique<FileSource>(*file_);
  if (files_.inflate) inflated_ = std::make_unique<InflateSource>(*raw_);
  if (files_.byte_skip > 0) open().skip(files_.byte_skip);
  left_ = files_.bytes_each;
}

std::size_t DataFilesSource::read(void* to, std::size_t n) {
  auto* out = static_cast<char*>(to);
  std::size_t done = 0;
  while (done < n) {
    if (left_ == 0) {
      if (raw_ != nullptr) expect_end(open(), files_.bytes_each);
      if (next_ == files_.paths.size()) {
        raw_.reset();
        break;
      }
      open_next();
    }
    if (raw_ == nullptr) break;
    const auto part =
        static_cast<std::size_t>(std::min<std::uint64_t>(n - done, static_cast<std::uint64_t>(left_)));
    const std::size_t got = open().read(out + done, part);
    done += got;
    left_ -= static_cast<std::int64_t>(got);
    if (got != part) ends_early(open().name(), files_.bytes_each - left_, files_.bytes_each);
  }
  return done;
}

std::int64_t DataFilesSource::remaining() const {
  if (files_.paths.size() != 1 || files_.inflate || raw_ == nullptr) return -1;
  return std::min(raw_->remaining(), left_);
}

bool Scanner::fill() {
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  const std::size_t got = from_.read(buffer_.data() + end_, buffer_.size() - end_);
  end_ += got;
  return got > 0;
}

std::string_view Scanner::word() {
  constexpr std::size_t kLongest = 4096;
  const auto is_space = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  for (;;) {
    while (begin_ < end_ && is_space(buffer_[begin_])) ++begin_;
    if (begin_ < end_) break;
    if (!fill()) return {};
  }
  if (end_ - begin_ <= kLongest) fill();
  std::size_t stop = begin_;
  while (stop < end_ && !is_space(buffer_[stop])) {
    if (++stop - begin_ > kLongest) throw Error(name() + ": a word of text longer than 4096 bytes");
  }
  const std::string_view found(buffer_.data() + begin_, stop - begin_);
  begin_ = stop;
  return found;
}

std::string Scanner::line() {
  std::string text;
  while (begin_ < end_ || fill()) {
    const char c = buffer_[begin_++];
    if (c == '\n') break;
    if (text.size() >= 65536) throw Error(name() + ": a header line longer than 65536 bytes");
    text.push_back(c);
  }
  if (!text.empty() && text.back() == '\r') text.pop_back();
  return text;
}

std::size_t Scanner::read(void* to, std::size_t n) {
  const std::size_t part = std::min(n, end_ - begin_);
  if (part > 0) std::memcpy(to, buffer_.data() + begin_, part);
  begin_ += part;
  return part == n ? n : part + from_.read(static_cast<char*>(to) + part, n - part);
}

std::int64_t Scanner::remaining() const {
  const std::int64_t known = from_.remaining();
  return known < 0 ? -1 : known + static_cast<std::int64_t>(end_ - begin_);
}

void expect_end(ByteSource& source, std::int64_t bytes) {
  char more = 0;
  if (source.read(&more, 1) != 0) {
    throw Error(source.name() + ": holds more than the " + std::to_string(bytes) +
                " bytes that its header promises");
  }
}

}  // namespace vol::io
