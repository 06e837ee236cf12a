#version 450 core
// One pass of an inverse transform by decimation in frequency (split stream, Jansen et al. 2004; mixed radix after
// Stockham, so that nothing is reversed at the end). Lines of n numbers, done in factors; of the factors before this
// one the product is s, and m = n/(s radix):
//     y[q + s (radix p + j)] = w_n^(s p j) sum_k x[q + s (p + m k)] w_radix^(j k),   p < m, q < s, w_n = exp(2 pi i/n)
// An invocation makes all radix outputs of one (p, q) of one line.
layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 0) readonly buffer Twiddles { vec2 twiddle[]; };  // exp(2 pi i t/n), t < n
layout(std430, binding = 1) readonly buffer From { vec2 from[]; };
layout(std430, binding = 2) writeonly buffer To { vec2 to[]; };

uniform int n, s, radix;
uniform int lines;
uniform int step, line_step;  // from a number to the next, from a line to the next
uniform int first_element;
uniform int hermitian;        // 1: the line is half of one, x[n - k] = conj x[k], and n/2 + 1 numbers long

vec2 times(vec2 a, vec2 b) { return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }

vec2 element(int base, int i) {
  if (hermitian == 0 || 2 * i < n) {
    vec2 v = from[base + i * step];
    return hermitian != 0 && i == 0 ? vec2(v.x, 0) : v;
  }
  vec2 v = from[base + (n - i) * step];
  return 2 * i == n ? vec2(v.x, 0) : vec2(v.x, -v.y);
}

void main() {
  int index = int(gl_GlobalInvocationID.x), line = int(gl_GlobalInvocationID.y);
  if (index >= n / radix || line >= lines) return;
  int p = index / s, q = index % s, m = n / (s * radix);
  int base = first_element + line * line_step;
  vec2 x[7];
  for (int k = 0; k < radix; ++k) x[k] = element(base, q + s * (p + m * k));
  for (int j = 0; j < radix; ++j) {
    vec2 sum = x[0];
    for (int k = 1; k < radix; ++k) sum += times(x[k], twiddle[(j * k % radix) * (n / radix)]);
    to[base + (q + s * (radix * p + j)) * step] = times(sum, twiddle[s * p * j % n]);
  }
}
