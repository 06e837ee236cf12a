#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "packet_scenes.h"
#include "render/packet.h"
#include "render/raycast.h"

// How the packet caster's pictures are held against those of its oracle.
namespace vol::render {

inline constexpr int kSamples = 4, kDepth = 5;

struct Difference {
  double colour = 0, samples = 0, depth = 0;
};

/// Largest differences of R, G, B, A; of samples; of depth where both pictures have one.
inline Difference difference(const image::Image& a, const image::Image& b) {
  Difference d;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      for (int c = 0; c < 4; ++c)
        d.colour = std::max(d.colour, std::abs(double(a.at(x, y, c)) - b.at(x, y, c)));
      d.samples = std::max(d.samples, std::abs(double(a.at(x, y, kSamples)) - b.at(x, y, kSamples)));
      if (std::isfinite(a.at(x, y, kDepth)) && std::isfinite(b.at(x, y, kDepth))) {
        d.depth = std::max(d.depth, std::abs(double(a.at(x, y, kDepth)) - b.at(x, y, kDepth)));
      }
    }
  }
  return d;
}

/// Same picture, bit for bit; the samples channel only where asked.
inline void expect_same_bits(const image::Image& a, const image::Image& b, bool samples_too) {
  ASSERT_EQ(a.pixels.size(), b.pixels.size());
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    if (i % a.channels.size() == kSamples && !samples_too) continue;
    ASSERT_EQ(a.pixels[i], b.pixels[i])
        << "value " << i % a.channels.size() << " of pixel " << i / a.channels.size();
  }
}

/// Same picture and counts, bit for bit, of any number of threads.
inline void expect_threads_change_nothing(const volume::Volume& v, const Scene& scene,
                                          RenderOptions options) {
  options.width = 97;
  options.height = 70;
  set_thread_count(1);
  const RenderResult one = raycast_packet(v, scene, options);
  for (const int threads : {2, 3, 0}) {
    set_thread_count(threads);
    const RenderResult many = raycast_packet(v, scene, options);
    expect_same_bits(one.image, many.image, true);
    EXPECT_EQ(one.counts.samples, many.counts.samples);
    EXPECT_EQ(one.counts.skipped, many.counts.skipped);
    EXPECT_EQ(one.counts.gradients, many.counts.gradients);
  }
}

/// The packet caster within its bound of the oracle, and the same samples where nothing is skipped.
inline void expect_oracle(const volume::Volume& v, const Scene& scene, RenderOptions options,
                          double largest = 1, const index::IndexVolume* index = nullptr) {
  options.skip_empty = false;
  const RenderResult plain = raycast_plain(v, scene, options, index);
  const RenderResult packet = raycast_packet(v, scene, options, index);
  double nodes = 0, coverage = 0;
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      nodes = std::max(nodes, double(plain.image.at(x, y, kSamples)));
      coverage = std::max(coverage, double(plain.image.at(x, y, 0)));
    }
  }
  ASSERT_GT(coverage, 0.01 * largest) << "an empty picture tests nothing";
  const Difference d = difference(plain.image, packet.image);
  EXPECT_LE(d.colour, packet_tolerance(nodes) * largest);
  EXPECT_EQ(d.samples, 0);
  // Depth: T moves by the tolerance where its slope along the ray may be a hundredth.
  if (scene.model == Model::composite) {
    EXPECT_LE(d.depth, 1e-3);
  }
  EXPECT_EQ(plain.counts.rays, packet.counts.rays);
  EXPECT_EQ(plain.counts.samples, packet.counts.samples);
  // Preintegrated packets light every sample: whether its segment is visible is known too late.
  if (options.quadrature != Quadrature::preintegrated) {
    EXPECT_EQ(plain.counts.gradients, packet.counts.gradients);
  }
  EXPECT_EQ(plain.counts.terminated, packet.counts.terminated);
}

}  // namespace vol::render
