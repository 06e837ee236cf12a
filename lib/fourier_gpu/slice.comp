#version 450 core
// One number of the Hermitian slice an invocation: column kx, row q in FFT order. As lib/fourier/projection.cpp and
// slice_kernel.cpp have it, names too.
layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform sampler3D spectrum;             // with its margins
layout(std430, binding = 0) readonly buffer Weights { float coefficients[]; };  // degree * taps + tap
layout(std430, binding = 1) readonly buffer PhasesX { vec2 phase_x[]; };
layout(std430, binding = 2) readonly buffer PhasesY { vec2 phase_y[]; };
layout(std430, binding = 3) buffer Slice { vec2 slice[]; };

uniform int width, height;    // of the slice
uniform int stride;           // of its rows
uniform int first_element;    // of this channel
uniform int taps, degree;
uniform float weight;         // of this spectrum in this channel
uniform int accumulate;       // 0: the first spectrum of the channel
uniform dvec3 per_x, per_y, nyquist;
uniform ivec3 zero;           // texel of kx = ky = kz = 0

const int kMostTaps = 16;

vec2 times(vec2 a, vec2 b) { return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }
vec2 conjugate(vec2 a) { return vec2(a.x, -a.y); }

void weights(float s, out float w[kMostTaps]) {
  for (int t = 0; t < taps; ++t) {
    float v = coefficients[degree * taps + t];
    for (int d = degree - 1; d >= 0; --d) v = v * s + coefficients[d * taps + t];
    w[t] = v;
  }
}

const double kRounding = 1e-10lf;  // SliceView::kRounding

bool on_face(double at, int axis) { return abs(at) >= (1.0lf - kRounding) * nyquist[axis]; }
bool line_in_face(double half_line, double across, int axis) {
  return on_face(half_line, axis) && abs(across) <= kRounding * nyquist[axis];
}
/// SliceView::face_share
float face_share(dvec3 g, bool unpaired_x, bool unpaired_y) {
  dvec3 end_x = 0.5lf * double(width) * per_x, end_y = 0.5lf * double(height) * per_y;
  float share = 1;
  for (int a = 0; a < 3; ++a) {
    if (!on_face(g[a], a)) continue;
    if (unpaired_x && line_in_face(end_x[a], end_y[a], a)) continue;
    if (unpaired_y && line_in_face(end_y[a], end_x[a], a)) continue;
    share *= 0.5;
  }
  return share;
}

/// The spectrum at slice frequency (kx, ky); 0 beyond the Nyquist box.
vec2 resampled(int kx, int ky) {
  dvec3 g = double(kx) * per_x + double(ky) * per_y;
  if (!all(lessThanEqual(abs(g), nyquist * (1.0lf + kRounding)))) return vec2(0);
  float share = face_share(g, 2 * abs(kx) == width, 2 * abs(ky) == height);
  bool mirrored = g.x < 0.0lf;
  dvec3 from = (mirrored ? -g : g) - 0.5lf * double(taps);
  dvec3 below = floor(from);
  vec3 s = vec3(2.0lf * (from - below) - 1.0lf);
  ivec3 first = ivec3(below) + 1 + zero;
  float wx[kMostTaps], wy[kMostTaps], wz[kMostTaps];
  weights(s.x, wx);
  weights(s.y, wy);
  weights(s.z, wz);
  vec2 sum = vec2(0);
  for (int c = 0; c < taps; ++c) {
    for (int b = 0; b < taps; ++b) {
      vec2 row = vec2(0);
      for (int a = 0; a < taps; ++a) row += wx[a] * texelFetch(spectrum, first + ivec3(a, b, c), 0).xy;
      sum += wy[b] * wz[c] * row;
    }
  }
  sum *= share;
  return mirrored ? conjugate(sum) : sum;
}

vec2 centred(int kx, int ky, int q) {
  vec2 x = kx < 0 ? conjugate(phase_x[-kx]) : phase_x[kx];
  vec2 y = ky == -(height / 2) && height % 2 == 0 ? conjugate(phase_y[q]) : phase_y[q];
  return times(resampled(kx, ky), times(x, y));
}

void main() {
  int column = int(gl_GlobalInvocationID.x), q = int(gl_GlobalInvocationID.y);
  int half_w = width / 2, half_h = height / 2;
  if (column > half_w || q >= height) return;
  bool edge = width % 2 == 0 && column == half_w, unpaired = height % 2 == 0 && q == half_h;
  int ky = q <= half_h ? q : q - height;
  vec2 value;
  if (unpaired) {
    value = 0.5 * (centred(column, half_h, q) + centred(edge ? -half_w : column, -half_h, q));
  } else if (edge) {
    value = 0.5 * (centred(half_w, ky, q) + centred(-half_w, ky, q));
  } else {
    value = centred(column, ky, q);
  }
  int at = first_element + q * stride + column;
  slice[at] = (accumulate != 0 ? slice[at] : vec2(0)) + weight * value;
}
