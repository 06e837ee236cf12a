#pragma once
#include <memory>
#include <optional>

#include "index/index_volume.h"
#include "index/macrocells.h"
#include "render/raycast.h"
#include "render/voxel_blocks.h"

namespace vol::render {

/// What packets do not draw whatever the volume, by name; null where the volume decides.
[[nodiscard]] const char* not_for_packets(const Scene& scene, const RenderOptions& options);

/// A volume as the packets take it, made once for any number of pictures: checked for NaN and infinity, of a
/// type that they read, with its macrocells.
class PacketVolume {
 public:
  /// Refers to the volume, which must live longer. \param macrocells  for composite pictures; others need
  /// none \throws vol::Error on NaN or infinity in the volume
  explicit PacketVolume(const volume::Volume& volume, bool macrocells = true);
  explicit PacketVolume(volume::Volume&&, bool = true) = delete;

  [[nodiscard]] const volume::Volume& original() const { return volume_; }
  /// False where float does not hold the values: small signals on large offsets, magnitudes near its end.
  [[nodiscard]] bool fits() const { return fits_; }
  [[nodiscard]] const volume::Volume& native() const { return converted_ ? *converted_ : volume_; }
  /// The copy that native() is, where the volume's own type is not read: its owner may take its voxels.
  [[nodiscard]] volume::Volume* converted() { return converted_ ? &*converted_ : nullptr; }
  /// \throws vol::Error when they were not asked for, or are forgotten
  [[nodiscard]] const index::Macrocells& macrocells() const;
  /// Frees the macrocells, an eighth of a volume of bytes: scenes need them to be prepared, not to be cast.
  void forget_macrocells() { macrocells_.reset(); }

 private:
  const volume::Volume& volume_;
  bool fits_ = true;
  std::optional<volume::Volume> converted_;
  std::optional<index::Macrocells> macrocells_;
};

/// The fast ray caster: packets of rays in SIMD (AVX-512, AVX2, SSE4 or one lane, chosen when it runs), float
/// arithmetic, threads over tiles of the image. Everything of the scene but its view is prepared once, for
/// any number of pictures. Same semantics as its oracle, raycast_plain: same nodes, same rules, same
/// channels. Split has no oracle of its own but the truth, raycast_reference.
///
/// What holds exactly:
///  - the picture and the counts do not depend on the number of threads, nor the counts on the instruction
///  set
///    (but for rounding at a border of visibility or at `termination`);
///  - without an index skip_empty changes no bit of the picture (split: nothing beyond rounding): only
///  segments
///    that add exactly zero are dropped. With one, empty space is left at the first lattice node that may be
///    visible, whatever the entries say there; raycast_plain does the same;
///  - an index of zeros gives the uniform picture bit for bit. These hold because the position of node i is
///  one
///    fixed-point number, entry + i times the step, 31 binary digits behind the point, however i was reached.
///
/// With options.step_tolerance the nodes are the oracle's too, but where an estimate is within rounding of
/// the tolerance, or in a shaded scene g of it over a power of four: a ray on the other side of it is off by
/// a few tolerances. Leaving empty space changes steps there.
///
/// What holds within a bound, for n nodes a ray: colour and alpha differ from the oracle's, and from one
/// instruction set to another, by at most 2e-6 + 1e-8 n times the largest colour where opacity and colour are
/// continuous functions of the value (packet_tolerance, tested). Positions lag by at most n 2^-31 voxel. At a
/// jump of the transfer function, a kink of the gradient or a cell border of nearest, a node within rounding
/// of it may fall on the other side, and one sample's contribution with it. xray: relative to max |f| times
/// length. Split with three nodes differs from the truth by at most 2e-5 in the tests, 1e-6 and less on large
/// smooth volumes; its depth is linear within a piece. With options.max_error the picture has a channel
/// `error`, what each ray estimates of its own (max_error.h). Preintegrated and split packets light every
/// sample.
///
/// Voxels of type u8, u16, i16 and f32 are read as they are; other types are converted to f32, once, where
/// that keeps 1e-6 of their range. What the packets do not cover is passed to raycast_plain (split:
/// raycast_split_plain): Catmull-Rom and B-spline reconstruction, more than 32767 nodes on a ray (the bound
/// above would be 3e-4 and more), volumes of 2^31 samples (f32) or bytes or more, transfer functions with
/// more than one point in 1/65536 of the data's range; for preintegrated also opacity 1 and segments that
/// light passes with less than 2^-64; for split media that halve light within 1/1024 of a cell, nearest,
/// xray, mip and an axis of one sample.
class PacketScene {
 public:
  /// Refers to the volume and the index, which must live longer. \throws vol::Error as raycast_plain does;
  /// also for split with an index
  PacketScene(const PacketVolume& volume, const Scene& scene, const RenderOptions& options,
              const index::IndexVolume* index = nullptr);
  PacketScene(PacketVolume&&, const Scene&, const RenderOptions&,
              const index::IndexVolume* = nullptr) = delete;
  ~PacketScene();
  PacketScene(const PacketScene&) = delete;
  PacketScene& operator=(const PacketScene&) = delete;

  /// \param spare  an image whose memory the picture may take, such as the last frame's
  /// \throws vol::Error as camera::Camera does, and where float cannot hold a pixel
  [[nodiscard]] RenderResult cast(const camera::View& view, image::Image spare = {}) const;

  /// From now on the voxels are read from `blocks`, those of volume(), which must live longer; pictures stay
  /// the same to the last bit.
  void read_from(const VoxelBlocks& blocks);

  /// Whether packets draw it: else the oracle does, at a twentieth of their speed and less.
  [[nodiscard]] bool in_packets() const { return tables_ != nullptr; }

  [[nodiscard]] const volume::Volume& volume() const { return volume_.original(); }
  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const RenderOptions& options() const { return options_; }

 private:
  struct Tables;
  [[nodiscard]] bool set_tables(const RenderOptions& options, Tables& tables) const;
  void prepare_first_view() const;

  const PacketVolume& volume_;
  Scene scene_;
  RenderOptions options_;
  const index::IndexVolume* index_;
  std::unique_ptr<Tables> tables_;  // none: what the packets do not cover
};

/// A single picture, from scene.view.
[[nodiscard]] RenderResult raycast_packet(const volume::Volume& volume, const Scene& scene,
                                          const RenderOptions& options,
                                          const index::IndexVolume* index = nullptr);

/// Bound of the difference from the oracle for n nodes a ray, on the colour scale (colours up to 1).
[[nodiscard]] constexpr double packet_tolerance(double nodes) {
  return 2e-6 + 1e-8 * nodes;
}

/// With options.max_error: what float arithmetic may add to a pixel's error, and how much of the bound is
/// asked of the reference where packets do not go.
inline constexpr double kPacketRounding = 2e-5;
inline constexpr double kReferenceShare = 0.25;

/// Name of the instruction set that raycast_packet uses here: AVX3, AVX2, SSE4, SCALAR ...
[[nodiscard]] const char* packet_instruction_set();

}  // namespace vol::render
