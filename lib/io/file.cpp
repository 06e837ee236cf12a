#include "io/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <mutex>

#include "base/error.h"

namespace vol::io {
namespace {

constexpr std::size_t kBufferSize = 1 << 16;
constexpr std::size_t kLongestName = 255;      // bytes, on most file systems
constexpr std::size_t kLongestExtension = 16;  // that a temporary name keeps: libraries know none so long
constexpr int kMostLinks = 40;                 // as many as Linux follows

// Uncommitted outputs, where a signal handler can read them: fixed memory, a slot is in use while its flag is
// set, and the name is complete before the flag is.
struct PendingOutput {
  std::atomic<bool> in_use{false};
  std::array<char, 4096> path{};
};
std::array<PendingOutput, 64> pending_outputs;
std::mutex pending_mutex;

void remember(const std::string& path) {
  const std::lock_guard lock(pending_mutex);
  for (auto& slot : pending_outputs) {
    if (slot.in_use.load() || path.size() + 1 > slot.path.size()) continue;
    std::memcpy(slot.path.data(), path.c_str(), path.size() + 1);
    slot.in_use.store(true);
    return;
  }
}

void forget(const std::string& path) {
  const std::lock_guard lock(pending_mutex);
  for (auto& slot : pending_outputs) {
    if (slot.in_use.load() && path == slot.path.data()) slot.in_use.store(false);
  }
}

[[noreturn]] void fail(const std::string& name, const char* what) {
  throw Error(name + ": " + what + ": " + std::strerror(errno));
}

/// Where a name leads: a symbolic link stays one, and the file behind it is replaced, or made where it is not
/// there yet.
std::filesystem::path behind_links(const std::filesystem::path& path) {
  std::filesystem::path place = path;
  std::error_code failure;
  for (int links = 0; std::filesystem::is_symlink(place, failure); ++links) {
    if (links == kMostLinks) failure = std::make_error_code(std::errc::too_many_symbolic_link_levels);
    const auto target = failure ? std::filesystem::path() : std::filesystem::read_symlink(place, failure);
    if (failure) {
      errno = failure.value();
      fail(path.string(), "cannot write");
    }
    place = place.parent_path() / target;  // which is the target itself where that is absolute
  }
  return place;
}

/// Where an output goes.
struct Place {
  std::filesystem::path path;
  bool is_in_place = false;  ///< a device or a pipe, written where it is; else a file, replaced when whole
};

Place place_of(const std::filesystem::path& path) {
  struct stat status {};
  const bool exists = ::stat(path.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) {
    throw Error(path.string() + ": is a folder, expected a file to write");
  }
  const bool may_be_made = !exists && errno == ENOENT && path.has_filename();
  if (exists ? ::access(path.c_str(), W_OK) != 0 : !may_be_made) fail(path.string(), "cannot write");
  if (exists && !S_ISREG(status.st_mode)) return {path, true};
  return {behind_links(path)};
}

/// A name beside `place` that no other output has: process and object make it unique. The final extension
/// stays, for libraries that choose by it; of the rest as much as fits.
std::filesystem::path temporary_beside(const std::filesystem::path& place, const void* object) {
  std::string extension = place.extension().string();
  if (extension.size() > kLongestExtension) extension.clear();
  const std::string ending = "." + std::to_string(::getpid()) + "." +
                             std::to_string(reinterpret_cast<std::uintptr_t>(object) >> 4 & 0xffff) +
                             ".partial" + extension;
  return place.parent_path() /
         ("." + place.stem().string().substr(0, kLongestName - 1 - ending.size()) + ending);
}

void write_all(int descriptor, const char* data, std::size_t n, const std::string& name) {
  while (n > 0) {
    const ssize_t done = ::write(descriptor, data, n);
    if (done < 0) {
      if (errno == EINTR) continue;
      fail(name, "cannot write");
    }
    data += done;
    n -= static_cast<std::size_t>(done);
  }
}

}  // namespace

bool is_standard_stream(const std::filesystem::path& path) {
  return path == "-";
}

std::string output_name(const std::filesystem::path& path) {
  return is_standard_stream(path) ? "standard output" : path.string();
}

std::string display_name(const std::filesystem::path& path) {
  return is_standard_stream(path) ? "standard input" : path.string();
}

InputFile::InputFile(const std::filesystem::path& path) : path_(path), buffer_(kBufferSize) {
  if (is_standard_stream(path)) {
    descriptor_ = STDIN_FILENO;
  } else {
    descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor_ < 0) fail(display_name(path), "cannot read");
  }
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) fail(display_name(path), "cannot read");
  if (S_ISDIR(status.st_mode)) {
    if (descriptor_ != STDIN_FILENO) ::close(descriptor_);
    throw Error(display_name(path) + ": is a folder, expected a file");
  }
  if (S_ISREG(status.st_mode)) {
    const off_t at = descriptor_ == STDIN_FILENO ? ::lseek(descriptor_, 0, SEEK_CUR) : 0;
    size_ = static_cast<std::int64_t>(status.st_size - (at > 0 ? at : 0));
  }
}

InputFile::~InputFile() {
  if (descriptor_ > STDIN_FILENO) ::close(descriptor_);
}

bool InputFile::fill() {
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  while (end_ < buffer_.size()) {
    const ssize_t got = ::read(descriptor_, buffer_.data() + end_, buffer_.size() - end_);
    if (got < 0) {
      if (errno == EINTR) continue;
      fail(display_name(path_), "cannot read");
    }
    if (got == 0) return end_ > 0;
    end_ += static_cast<std::size_t>(got);
    return true;
  }
  return true;
}

std::string_view InputFile::peek(std::size_t n) {
  while (end_ - begin_ < n) {
    const std::size_t before = end_ - begin_;
    fill();
    if (end_ - begin_ == before) break;
  }
  return {buffer_.data() + begin_, std::min(n, end_ - begin_)};
}

std::size_t InputFile::read(void* to, std::size_t n) {
  auto* out = static_cast<char*>(to);
  std::size_t done = std::min(n, end_ - begin_);
  if (done > 0) std::memcpy(out, buffer_.data() + begin_, done);  // an empty buffer has no address either
  begin_ += done;
  while (done < n) {  // what is larger than the buffer goes straight to its place
    const ssize_t got = ::read(descriptor_, out + done, n - done);
    if (got < 0) {
      if (errno == EINTR) continue;
      fail(display_name(path_), "cannot read");
    }
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  position_ += static_cast<std::int64_t>(done);
  return done;
}

void InputFile::read_exactly(void* to, std::size_t n) {
  const std::size_t got = read(to, n);
  if (got != n) {
    throw Error(display_name(path_) + ": data ends after " + std::to_string(got) + " of " +
                std::to_string(n) + " bytes");
  }
}

std::string InputFile::read_line(std::size_t limit) {
  std::string line;
  if (at_end()) throw Error(display_name(path_) + ": ends where a header line was expected");
  while (!at_end()) {
    const char* from = buffer_.data() + begin_;
    const auto* newline = static_cast<const char*>(std::memchr(from, '\n', end_ - begin_));
    const std::size_t n = newline != nullptr ? static_cast<std::size_t>(newline - from) : end_ - begin_;
    if (line.size() + n > limit) {
      throw Error(display_name(path_) + ": header line longer than " + std::to_string(limit) + " bytes");
    }
    line.append(from, n);
    const std::size_t consumed = n + (newline != nullptr ? 1 : 0);
    begin_ += consumed;
    position_ += static_cast<std::int64_t>(consumed);
    if (newline != nullptr) break;
  }
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return line;
}

bool InputFile::at_end() {
  if (begin_ < end_) return false;
  begin_ = end_ = 0;
  return !fill();
}

void InputFile::skip(std::int64_t n) {
  require(n);
  std::array<char, 4096> scratch;
  for (std::int64_t done = 0; done < n;) {
    const auto part = static_cast<std::size_t>(std::min<std::int64_t>(n - done, scratch.size()));
    const std::size_t got = read(scratch.data(), part);
    done += static_cast<std::int64_t>(got);
    if (got != part) {
      throw Error(display_name(path_) + ": data ends after " + std::to_string(done) + " of " +
                  std::to_string(n) + " bytes");
    }
  }
}

void InputFile::require(std::int64_t n) const {
  if (n < 0) throw Error(display_name(path_) + ": negative data size");
  if (size_ >= 0 && n > size_ - position_) {
    throw Error(display_name(path_) + ": data ends after " +
                std::to_string(std::max<std::int64_t>(0, size_ - position_)) + " of " + std::to_string(n) +
                " bytes");
  }
}

std::vector<std::byte> InputFile::read_rest(std::int64_t limit) {
  std::vector<std::byte> bytes;
  std::size_t done = 0;
  std::size_t room =
      size_ >= 0 ? static_cast<std::size_t>(std::min(limit, size_ - position_)) + 1 : kBufferSize;
  for (;;) {
    bytes.resize(done + room);
    done += read(bytes.data() + done, room);
    if (done < bytes.size()) break;
    if (static_cast<std::int64_t>(done) > limit) {
      throw Error(display_name(path_) + ": more than " + std::to_string(limit) + " bytes");
    }
    room = std::max(kBufferSize, done);  // doubles, so that a pipe costs what it brings
  }
  bytes.resize(done);
  if (static_cast<std::int64_t>(done) > limit) {
    throw Error(display_name(path_) + ": more than " + std::to_string(limit) + " bytes");
  }
  return bytes;
}

OutputFile::OutputFile(const std::filesystem::path& path) : path_(path) {
  buffer_.reserve(kBufferSize);
  if (is_standard_stream(path)) {
    descriptor_ = STDOUT_FILENO;
    return;
  }
  const Place place = place_of(path);
  if (place.is_in_place) {
    descriptor_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ < 0) fail(path.string(), "cannot write");
    return;
  }
  place_ = place.path;
  temporary_ = temporary_beside(place_, this);
  remember(temporary_.string());
  // Exclusively, so that nothing is written through a link that lies in wait; a process of this number that
  // was killed may have left the name behind.
  const auto create = [&] {
    return ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  };
  descriptor_ = create();
  if (descriptor_ < 0 && errno == EEXIST && ::unlink(temporary_.c_str()) == 0) descriptor_ = create();
  if (descriptor_ < 0) {
    const int reason = errno;
    forget(temporary_.string());
    errno = reason;
    fail(path.string(), "cannot write");
  }
}

OutputFile::~OutputFile() {
  if (descriptor_ > STDOUT_FILENO) ::close(descriptor_);
  if (!committed_ && !temporary_.empty()) {
    ::unlink(temporary_.c_str());
    forget(temporary_.string());
  }
}

void OutputFile::write(const void* data, std::size_t n) {
  const auto* bytes = static_cast<const char*>(data);
  written_ += static_cast<std::int64_t>(n);
  if (buffer_.size() + n <= kBufferSize) {
    buffer_.insert(buffer_.end(), bytes, bytes + n);
    return;
  }
  flush();
  if (n >= kBufferSize) {
    write_all(descriptor_, bytes, n, output_name(path_));
  } else {
    buffer_.assign(bytes, bytes + n);
  }
}

void OutputFile::flush() {
  write_all(descriptor_, buffer_.data(), buffer_.size(), output_name(path_));
  buffer_.clear();
}

void OutputFile::commit() {
  flush();
  committed_ = true;
  if (temporary_.empty()) return;
  const bool closed = ::close(descriptor_) == 0;
  descriptor_ = -1;
  if (!closed || ::rename(temporary_.c_str(), place_.c_str()) != 0) {
    const int reason = errno;
    ::unlink(temporary_.c_str());
    forget(temporary_.string());
    errno = reason;
    fail(path_.string(), "cannot write");
  }
  forget(temporary_.string());
}

void require_writable(const std::filesystem::path& path) {
  if (is_standard_stream(path)) return;
  const Place place = place_of(path);
  const auto folder = place.path.parent_path();
  if (!place.is_in_place && ::access(folder.empty() ? "." : folder.c_str(), W_OK | X_OK) != 0)
    fail(path.string(), "cannot write");
}

void remove_uncommitted_outputs() noexcept {
  for (auto& slot : pending_outputs) {
    if (slot.in_use.load()) ::unlink(slot.path.data());
  }
}

}  // namespace vol::io
