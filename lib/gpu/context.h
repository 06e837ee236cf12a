#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace vol::gpu {

/// An OpenGL 4.5 core context without window or display, current on the thread that made it: of the first EGL
/// device that has one, else of EGL's surfaceless platform (Mesa's software renderer where there is no GPU).
class Context {
 public:
  /// \throws vol::DeviceError where this machine has none
  Context();
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  /// The renderer's name and version.
  [[nodiscard]] const std::string& device() const { return device_; }

 private:
  void* display_ = nullptr;
  void* context_ = nullptr;
  std::string device_;
};

/// Throws vol::Error naming `what` if OpenGL has noted an error since the last call.
void require_no_error(const char* what);

/// A compute shader. Uniforms are set by name; a name that the compiler has dropped is no error.
class ComputeProgram {
 public:
  /// \throws vol::Error with the compiler's first line
  ComputeProgram(const char* name, const std::string& source);
  ~ComputeProgram();
  ComputeProgram(const ComputeProgram&) = delete;
  ComputeProgram& operator=(const ComputeProgram&) = delete;

  void set(const char* uniform, int value) const;
  void set(const char* uniform, float value) const;
  void set(const char* uniform, const double (&value)[3]) const;
  void set(const char* uniform, const int (&value)[3]) const;
  /// Groups of 8 x 8 for x times y invocations, and waits for what they write before what comes next reads
  /// it.
  void run(std::int64_t x, std::int64_t y) const;

 private:
  unsigned id_;
};

/// Memory that shaders read and write, bound by number.
class StorageBuffer {
 public:
  explicit StorageBuffer(std::size_t bytes, const void* data = nullptr);
  ~StorageBuffer();
  StorageBuffer(StorageBuffer&& other) noexcept : id_(std::exchange(other.id_, 0)), bytes_(other.bytes_) {}
  StorageBuffer& operator=(StorageBuffer&&) = delete;

  void bind(unsigned binding) const;
  void write(const void* data, std::size_t bytes);
  void read(void* data, std::size_t bytes) const;
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  unsigned id_ = 0;
  std::size_t bytes_;
};

/// A 3D texture of pairs of floats, for texelFetch.
class PairTexture {
 public:
  /// \param data  width * height * depth pairs
  /// \throws vol::Error where the device has no room for it
  PairTexture(std::int64_t width, std::int64_t height, std::int64_t depth, const float* data);
  ~PairTexture();
  PairTexture(PairTexture&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  PairTexture& operator=(PairTexture&&) = delete;
  void bind(unsigned unit) const;

 private:
  unsigned id_ = 0;
};

/// Waits until the device has done what it was told: for timing.
void finish();

}  // namespace vol::gpu
