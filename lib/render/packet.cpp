#include "render/packet.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "base/error.h"
#include "render/packet_cast.h"
#include "render/packet_rays.h"
#include "render/packet_set_up.h"
#include "render/packet_transfer.h"
#include "render/picture.h"
#include "render/step_control.h"
#include "render/visibility.h"
#include "volume/grid_sampler.h"

namespace vol::render {
namespace {

using volume::VoxelType;

constexpr double kMostPieces = 64;
constexpr double kLongestStep = 1e6;        // diagonals: float holds the last segment's share of a step
constexpr double kLeastPiece = 1.0 / 1024;  // of the longest way through a cell
constexpr double kTouching = index::Macrocells::kEdge;

bool is_covered(const volume::Volume& volume, const Scene& scene, const RenderOptions& options) {
  if (not_for_packets(scene, options) != nullptr) return false;
  // Below this, rounding would take most of what errors are allowed.
  if (options.max_error > 0 && options.max_error < 4 * kPacketRounding * brightest(scene)) return false;
  if (options.quadrature == Quadrature::split) {
    // An axis of one sample has no cells to go through.
    const Dims& dims = volume.geometry().dims;
    if (std::any_of(dims.begin(), dims.end(), [](std::int64_t n) { return n == 1; })) return false;
  }
  const volume::FieldBounds bounds = volume::field_bounds(volume.geometry());
  const double diagonal = longest_diagonal(bounds);
  if (!(diagonal / options.step < kMostSegments - 1)) return false;
  if (!(options.step / diagonal < kLongestStep)) return false;
  constexpr double kAddressable = 2147483647.0;
  const auto count = static_cast<double>(volume.geometry().count());
  switch (volume.voxel_type()) {
    case VoxelType::u8:
      return count < kAddressable;
    case VoxelType::u16:
    case VoxelType::i16:
      return 2 * count < kAddressable;
    default:
      return count < kAddressable;
  }
}

/// What the packets' tables do not hold.
RenderResult otherwise(const volume::Volume& volume, const Scene& scene, RenderOptions options,
                       const index::IndexVolume* index) {
  if (options.max_error > 0) {
    options.tolerance = kReferenceShare * options.max_error;
    return raycast_reference(volume, scene, options);
  }
  return options.quadrature == Quadrature::split ? raycast_split_plain(volume, scene, options)
                                                 : raycast_plain(volume, scene, options, index);
}

/// `options`, with the step that the packets take: split goes from cell to cell and measures lengths in
/// voxels.
RenderOptions packet_steps(RenderOptions options, const volume::GridGeometry& geometry) {
  if (options.quadrature == Quadrature::split) options.step = geometry.spacing.minCoeff();
  if (options.step_tolerance > 0) {
    options.step /= 1 << most_halvings(volume::field_bounds(geometry), options.step);
  }
  return options;
}

}  // namespace

const char* not_for_packets(const Scene& scene, const RenderOptions& options) {
  using volume::Reconstruction;
  const bool nearest = options.reconstruction == Reconstruction::nearest;
  if (options.quadrature == Quadrature::reference) return "quadrature reference";
  if (!nearest && options.reconstruction != Reconstruction::trilinear) return "cubic reconstructions";
  if (options.quadrature == Quadrature::split && (nearest || scene.model != Model::composite)) {
    return "quadrature split, unless composite and trilinear";
  }
  return nullptr;
}

PacketVolume::PacketVolume(const volume::Volume& volume, bool macrocells) : volume_(volume) {
  const bool native = are_read_as_they_are(volume.voxel_type());
  const bool floating = volume::is_floating_point(volume.voxel_type());
  if (!native || floating) {  // small integers hold neither NaN nor infinity, and float holds them
    const volume::Range range = volume::value_range(volume);
    const double magnitude = std::max(std::abs(range.min), std::abs(range.max));
    // Sums of differences of values must stay within float, and float must hold what differs: it loses 6e-8.
    const bool exact = native || (!floating && magnitude <= 16777216);
    fits_ = magnitude < double(std::numeric_limits<float>::max()) / 64 &&
            (exact || magnitude * 6e-8 <= 1e-6 * (range.max - range.min));
    if (!fits_) return;
  }
  if (!native) converted_.emplace(volume::Volume{volume::converted<float>(volume), {}});
  if (macrocells) macrocells_.emplace(index::macrocells(this->native()));
}

const index::Macrocells& PacketVolume::macrocells() const {
  if (!macrocells_) throw Error("a composite picture needs the volume's macrocells");
  return *macrocells_;
}

/// The job but for its rays, and what it points into.
struct PacketScene::Tables {
  PacketJob job;
  Visibility visible;
  VisibilityAhead ahead{visible};
};

PacketScene::~PacketScene() = default;

PacketScene::PacketScene(const PacketVolume& volume, const Scene& scene, const RenderOptions& options,
                         const index::IndexVolume* index)
    : volume_(volume), scene_(scene), options_(options), index_(index) {
  require_valid(options);
  if (index && options.quadrature == Quadrature::split) {
    throw Error("quadrature split goes from cell to cell and takes no index");
  }
  if (options.step_tolerance > 0) require_adaptive_steps_can_be(scene, index != nullptr);
  const RenderOptions stepped = packet_steps(options, volume.original().geometry());
  if (!volume.fits() || !is_covered(volume.original(), scene, stepped)) return;
  const Dims& dims = volume.native().geometry().dims;
  if (index && index->volume_dims() != dims)
    throw Error("index volume was built for other dims than the volume's");
  auto tables = std::make_unique<Tables>();
  if (!set_tables(stepped, *tables)) return;
  tables_ = std::move(tables);
  if (!tables_->visible.all_visible) prepare_first_view();
}

/// The distances that most rays of the scene's own view will ask for.
void PacketScene::prepare_first_view() const {
  const volume::GridGeometry& geometry = volume_.native().geometry();
  const volume::FieldBounds bounds = volume::field_bounds(geometry);
  const camera::Camera camera(scene_.view, bounds.centre(), bounds.longest_edge(), options_.width,
                              options_.height);
  const Vec3 along = geometry.world_to_index_matrix() * camera.direction();
  int octant = 0;
  for (int a = 0; a < 3; ++a) octant |= int{along[a] < 0} << a;
  static_cast<void>(tables_->ahead.distance(octant));
}

bool PacketScene::set_tables(const RenderOptions& options, Tables& tables) const {
  const volume::GridGeometry& geometry = volume_.native().geometry();
  PacketJob& job = tables.job;
  set_volume(volume_.native(), job);
  job.nearest = options.reconstruction == volume::Reconstruction::nearest;
  job.rule = options.quadrature == Quadrature::rectangle   ? PacketRule::rectangle
             : options.quadrature == Quadrature::trapezoid ? PacketRule::trapezoid
             : options.quadrature == Quadrature::split     ? PacketRule::split
                                                           : PacketRule::preintegrated;
  job.nodes = options.nodes;
  job.termination = static_cast<float>(options.termination);
  if (index_) set_index(*index_, job);
  if (options.step_tolerance > 0) {
    using Limits = std::numeric_limits<float>;
    job.step_tolerance =
        static_cast<float>(std::clamp(options.step_tolerance, double(Limits::min()), double(Limits::max())));
    job.halvings = most_halvings(volume::field_bounds(volume_.original().geometry()), options_.step);
    job.longest_hop = static_cast<float>(1 << job.halvings);
  }
  if (scene_.model != Model::composite) return true;

  const index::Macrocells& macrocells = volume_.macrocells();
  const double spacing = geometry.spacing.minCoeff();
  const double reference_length = resolved_reference_length(scene_, spacing);
  const bool integral = job.type != PacketVoxels::f32;
  if (!tabulate(Optics(scene_.transfer, reference_length), macrocells.all, integral,
                options.step / reference_length, job.rule, job.transfer)) {
    return false;
  }
  // A piece halves the light at most: so many are the pieces of a segment.
  if (job.rule == PacketRule::preintegrated &&
      job.transfer.steepest * double(job.longest_hop) < -kMostPieces) {
    return false;
  }
  // Where that takes less than a small part of a cell, the rays do not get on.
  if (job.rule == PacketRule::split &&
      shortest_piece(job.transfer) < kLeastPiece * geometry.spacing.norm() / options.step) {
    return false;
  }
  if (scene_.shading) set_shading(geometry, *scene_.shading, job);
  if (scene_.shading && options.step_tolerance > 0) {
    // A node's y is log2 of its share of a step, half of the step's extinction: s = 2 ln 2 |y| / step.
    const double share =
        shading_share(*scene_.shading, options.step, smallest_cell(geometry, options.reconstruction)) * 2 *
        std::numbers::ln2 / options.step;
    constexpr double kFinite = 1e30;  // as a float
    job.shading_share = static_cast<float>(std::min(share / double(job.step_tolerance), kFinite));
  }
  if (options.max_error > 0) set_budget(scene_, options, job);
  // Preintegrated segments are left out between macrocells that touch: no step may pass over one.
  const bool touching = job.rule != PacketRule::preintegrated || options.step <= kTouching * spacing;
  if (!touching && index_ && options.skip_empty) return false;
  if (options.skip_empty && touching) tables.visible = visibility(macrocells, scene_.transfer);
  job.macro_stride[1] = static_cast<std::int32_t>(macrocells.dims[0]);
  job.macro_stride[2] = static_cast<std::int32_t>(macrocells.dims[0] * macrocells.dims[1]);
  return true;
}

void PacketScene::read_from(const VoxelBlocks& blocks) {
  if (!tables_) throw Error("only packets read voxels from blocks");
  tables_->job.voxels = blocks.data();
  tables_->job.blocks = blocks.strides();
  tables_->job.in_blocks = true;
}

RenderResult PacketScene::cast(const camera::View& view, image::Image spare) const {
  Scene scene = scene_;
  scene.view = view;
  if (!tables_) return otherwise(volume_.original(), scene, options_, index_);
  const volume::GridGeometry& geometry = volume_.native().geometry();
  const RenderOptions options = packet_steps(options_, geometry);
  const volume::FieldBounds bounds = volume::field_bounds(geometry);
  const RayBox box(bounds);
  const camera::Camera camera(view, bounds.centre(), bounds.longest_edge(), options.width, options.height);
  const PacketRayMaker maker(geometry, box, camera, options.step, index_);
  RenderResult result{
      blank_image(options, std::move(spare)), {}, std::numeric_limits<double>::quiet_NaN(), "packets"};
  const Visibility* const visible = tables_->visible.all_visible ? nullptr : &tables_->visible;
  result.counts = cast_picture({tables_->job, visible, &tables_->ahead, maker, scene, options, result.image});
  return result;
}

RenderResult raycast_packet(const volume::Volume& volume, const Scene& scene, const RenderOptions& options,
                            const index::IndexVolume* index) {
  const PacketVolume prepared(volume, scene.model == Model::composite);
  return PacketScene(prepared, scene, options, index).cast(scene.view);
}

}  // namespace vol::render
