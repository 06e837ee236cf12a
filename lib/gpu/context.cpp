#include "gpu/context.h"

#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <algorithm>

#include "base/error.h"

namespace vol::gpu {
namespace {

/// libepoxy ends the process where a library is missing: ask before it does.
void require_library(std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (dlopen(name, RTLD_LAZY | RTLD_GLOBAL) != nullptr) return;
  }
  throw DeviceError(std::string("this machine has no ") + *names.begin() +
                    ", and so no OpenGL without a display; use fvr-slice");
}

bool has_extension(EGLDisplay display, const char* name) {
  const char* all = eglQueryString(display, EGL_EXTENSIONS);
  return all != nullptr && std::string(all).find(name) != std::string::npos;
}

/// A context of OpenGL 4.5 core on this display, or null and nothing left behind.
EGLContext context_on(EGLDisplay display) {
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) return EGL_NO_CONTEXT;
  constexpr EGLint kAttributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                    4,
                                    EGL_CONTEXT_MINOR_VERSION,
                                    5,
                                    EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                    EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                    EGL_NONE};
  if (eglBindAPI(EGL_OPENGL_API)) {
    const EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, kAttributes);
    if (context != EGL_NO_CONTEXT) {
      if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) return context;
      eglDestroyContext(display, context);
    }
  }
  eglTerminate(display);
  return EGL_NO_CONTEXT;
}

}  // namespace

Context::Context() {
  require_library({"libEGL.so.1"});
  require_library({"libOpenGL.so.0", "libGL.so.1"});
  std::vector<EGLDisplay> displays;
  if (has_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device") &&
      has_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration")) {
    EGLDeviceEXT devices[16];
    EGLint count = 0;
    if (eglQueryDevicesEXT(16, devices, &count)) {
      for (EGLint i = 0; i < count; ++i) {
        displays.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
      }
    }
  }
  if (has_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) {
    displays.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
  }
  for (const EGLDisplay display : displays) {
    context_ = context_on(display);
    if (context_ == EGL_NO_CONTEXT) continue;
    display_ = display;
    device_ = std::string(reinterpret_cast<const char*>(glGetString(GL_RENDERER))) + ", OpenGL " +
              reinterpret_cast<const char*>(glGetString(GL_VERSION));
    return;
  }
  throw DeviceError("no EGL device offers OpenGL 4.5 without a display; use fvr-slice");
}

Context::~Context() {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
  eglTerminate(display_);
}

void require_no_error(const char* what) {
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return;
  while (glGetError() != GL_NO_ERROR) {
  }
  if (error == GL_OUT_OF_MEMORY)
    throw Error(std::string(what) + ": the device has no room for it; use fvr-slice, or less --pad");
  throw Error(std::string(what) + ": OpenGL error " + std::to_string(error));
}

ComputeProgram::ComputeProgram(const char* name, const std::string& source) {
  const GLuint shader = glCreateShader(GL_COMPUTE_SHADER);
  const char* text = source.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  id_ = glCreateProgram();
  glAttachShader(id_, shader);
  glLinkProgram(id_);
  GLint linked = 0;
  glGetProgramiv(id_, GL_LINK_STATUS, &linked);
  if (linked == 0) {
    char log[1024] = {};
    glGetShaderInfoLog(shader, sizeof log, nullptr, log);
    if (log[0] == 0) glGetProgramInfoLog(id_, sizeof log, nullptr, log);
    glDeleteShader(shader);
    glDeleteProgram(id_);
    throw Error(std::string("shader ") + name + ": " +
                std::string(log).substr(0, std::string(log).find('\n')));
  }
  glDeleteShader(shader);
}

ComputeProgram::~ComputeProgram() {
  glDeleteProgram(id_);
}

void ComputeProgram::set(const char* uniform, int value) const {
  glProgramUniform1i(id_, glGetUniformLocation(id_, uniform), value);
}
void ComputeProgram::set(const char* uniform, float value) const {
  glProgramUniform1f(id_, glGetUniformLocation(id_, uniform), value);
}
void ComputeProgram::set(const char* uniform, const double (&v)[3]) const {
  glProgramUniform3d(id_, glGetUniformLocation(id_, uniform), v[0], v[1], v[2]);
}
void ComputeProgram::set(const char* uniform, const int (&v)[3]) const {
  glProgramUniform3i(id_, glGetUniformLocation(id_, uniform), v[0], v[1], v[2]);
}

void ComputeProgram::run(std::int64_t x, std::int64_t y) const {
  glUseProgram(id_);
  glDispatchCompute(static_cast<GLuint>((x + 7) / 8), static_cast<GLuint>((y + 7) / 8), 1);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

StorageBuffer::StorageBuffer(std::size_t bytes, const void* data) : bytes_(bytes) {
  glCreateBuffers(1, &id_);
  glNamedBufferStorage(id_, static_cast<GLsizeiptr>(bytes), data, GL_DYNAMIC_STORAGE_BIT);
  require_no_error("a buffer of the device");
}
StorageBuffer::~StorageBuffer() {
  if (id_ != 0) glDeleteBuffers(1, &id_);
}
void StorageBuffer::bind(unsigned binding) const {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, id_);
}
void StorageBuffer::write(const void* data, std::size_t bytes) {
  glNamedBufferSubData(id_, 0, static_cast<GLsizeiptr>(bytes), data);
}
void StorageBuffer::read(void* data, std::size_t bytes) const {
  glGetNamedBufferSubData(id_, 0, static_cast<GLsizeiptr>(bytes), data);
}

PairTexture::PairTexture(std::int64_t width, std::int64_t height, std::int64_t depth, const float* data) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &most);
  if (width > most || height > most || depth > most) {
    throw Error("the spectrum has " + std::to_string(std::max({width, height, depth})) +
                " numbers along an axis, this device takes " + std::to_string(most) +
                "; use fvr-slice, or less --pad");
  }
  glCreateTextures(GL_TEXTURE_3D, 1, &id_);
  const auto w = static_cast<GLsizei>(width), h = static_cast<GLsizei>(height),
             d = static_cast<GLsizei>(depth);
  glTextureStorage3D(id_, 1, GL_RG32F, w, h, d);
  require_no_error("the spectrum's texture");  // Mesa 22.3 caps one at 2 GiB and says so here
  glTextureParameteri(id_, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(id_, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTextureSubImage3D(id_, 0, 0, 0, 0, w, h, d, GL_RG, GL_FLOAT, data);
  require_no_error("the spectrum's texture");
}
PairTexture::~PairTexture() {
  if (id_ != 0) glDeleteTextures(1, &id_);
}
void PairTexture::bind(unsigned unit) const {
  glBindTextureUnit(unit, id_);
}

void finish() {
  glFinish();
}

}  // namespace vol::gpu
