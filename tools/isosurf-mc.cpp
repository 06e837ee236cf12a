// isosurf-mc: isosurfaces of a volume as a triangle mesh.
//   isosurf-mc head.nrrd --isovalue 90 -o head.ply
//   isosurf-mc labels.nrrd --label all -o region-{label}.ply
//   isosurf-mc protein.nrrd --isovalue 0.2,-0.2 --close -o protein.obj --stats mesh.json
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "cli/naming.h"
#include "cli/options.h"
#include "cli/run.h"
#include "cli/volume_input.h"
#include "io/mesh.h"
#include "io/volume.h"
#include "isosurface/marching_cubes.h"
#include "mesh/measures.h"
#include "mesh/weld.h"
#include "volume/labels.h"

namespace {

using namespace vol;
using nlohmann::json;

struct Options {
  cli::VolumeInput input;
  std::filesystem::path output;
  std::vector<std::string> isovalue_texts;
  std::string labels;
  std::string type = "f32";
  isosurface::MarchingCubesOptions mesh;
  io::MeshWriteOptions write;
  bool no_normals = false, no_weld = false, no_measures = false;
};

void declare(CLI::App& app, Options& o) {
  cli::add_volume_input(app, o.input);
  app.add_option(
         "-o,--output", o.output,
         "Mesh (.ply .obj .stl); - is standard output; with {label} in the name a file for each --label")
      ->required()
      ->group("Files");
  app.add_option("--format", o.write.format, "ply, obj or stl [by extension; ply]")
      ->check(CLI::IsMember({"ply", "obj", "stl"}))
      ->group("Files");

  const char* surface = "Surface";
  auto* isovalue = app.add_option("--isovalue", o.isovalue_texts,
                                  "Values of the surfaces, in the volume's units; VALUE or VALUE,VALUE,...")
                       ->allow_extra_args(false)
                       ->take_all()
                       ->type_name("VALUE,...")
                       ->group(surface);
  app.add_option(
         "--label,--labels", o.labels,
         "The volume holds labels, whole numbers 0 to 255: the surface around each of these, where it "
         "has half a share of a point by trilinear interpolation; LABEL,LABEL,... or all")
      ->excludes(isovalue)
      ->type_name("LABEL,...")
      ->group(surface);
  app.add_flag("--close", o.mesh.close, "Close the surface at the volume's border: all beyond is outside")
      ->group(surface);
  app.add_flag(
         "--no-weld", o.no_weld,
         "Leave vertices at the same place and triangles without area, where samples equal the isovalue: the "
         "manifold, whose sheets welding may make touch")
      ->group(surface);

  const char* contents = "Contents of the file";
  app.add_flag("--no-normals", o.no_normals, "Do not write the field's normals")->group(contents);
  app.add_option("--type", o.type, "Positions: f32 or f64 (ply, obj)")
      ->check(CLI::IsMember({"f32", "f64"}))
      ->capture_default_str()
      ->group(contents);
  app.add_flag("--no-measures", o.no_measures,
               "Do not count components, edges, area and volume for the stats record")
      ->group(contents);
}

json measures(const mesh::TriangleMesh& mesh, const mesh::Topology& t) {
  const mesh::Extent e = mesh::extent(mesh);
  json result{{"vertices", t.vertices},
              {"triangles", t.triangles},
              {"edges", t.edges},
              {"components", t.components},
              {"euler_characteristic", t.euler},
              {"boundary_edges", t.boundary_edges},
              {"boundary_loops", t.boundary_loops},
              {"non_manifold_edges", t.non_manifold_edges},
              {"non_manifold_vertices", t.non_manifold_vertices},
              {"misoriented_edges", t.misoriented_edges},
              {"area", e.area}};
  // Of an open surface, or of sheets that touch and may disagree about the outside: none.
  result["volume"] = t.boundary_edges == 0 && t.is_manifold() ? json(e.volume) : json();
  return result;
}

json before_welding(const mesh::Topology& t) {
  return {{"components", t.components},
          {"euler_characteristic", t.euler},
          {"boundary_edges", t.boundary_edges},
          {"non_manifold_edges", t.non_manifold_edges},
          {"non_manifold_vertices", t.non_manifold_vertices}};
}

/// The surface of one isovalue as it goes to the file; adds its figures to an entry of the result, and the
/// counts.
mesh::TriangleMesh make_surface(const volume::Volume& volume, double isovalue, const Options& o, json& entry,
                                std::map<std::string, std::int64_t>& counts, cli::Record& record) {
  auto surface =
      record.repeated("extract", [&] { return isosurface::marching_cubes(volume, isovalue, o.mesh); });
  counts["cells"] += surface.counts.cells;
  counts["active_cells"] += surface.counts.active_cells;
  counts["ambiguous_cells"] += surface.counts.ambiguous_cells;
  counts["tubes"] += surface.counts.tubes;
  mesh::Topology topology;
  if (!o.no_measures) topology = record.timed("measures", [&] { return mesh::topology(surface.mesh); });
  record.timed("round", [&] {
    if (o.type == "f32") return mesh::round_to_float(surface.mesh, volume.geometry().spacing.minCoeff());
    mesh::require_finite(surface.mesh);
  });
  if (!o.no_weld) {
    if (!o.no_measures) entry["before_welding"] = before_welding(topology);
    const auto welded = record.timed("weld", [&] { return mesh::weld(surface.mesh); });
    if (!o.no_measures && welded.vertices_merged != 0) {
      topology = record.timed("measures", [&] { return mesh::topology(surface.mesh); });
    }
    counts["vertices_merged"] += welded.vertices_merged;
    counts["triangles_dropped"] += welded.triangles_dropped;
    counts["flat_triangles"] += welded.flat_triangles;
  }
  counts["vertices"] += static_cast<std::int64_t>(surface.mesh.positions.size());
  counts["triangles"] += static_cast<std::int64_t>(surface.mesh.triangles.size());
  if (!o.no_measures)
    entry.update(record.timed("measures", [&] { return measures(surface.mesh, topology); }));
  return std::move(surface.mesh);
}

constexpr const char* kLabelInName = "{label}";

void write(const std::filesystem::path& path, const mesh::TriangleMesh& mesh, const Options& o,
           cli::Record& record) {
  const auto lost = record.timed("write", [&] { return io::write_mesh(path, mesh, o.write); });
  for (const auto& sentence : lost) record.say(sentence);
  record.output(path);
}

/// Surfaces one after the other, and where they go: all to one file, or each label's to its own.
class Surfaces {
 public:
  Surfaces(Options& options, cli::Record& record)
      : o_(options), record_(record), name_(options.output.string()), at_(name_.find(kLabelInName)) {}

  void add(const volume::Volume& volume, const char* of, double number, double isovalue) {
    json entry{{of, number}};
    mesh::TriangleMesh surface = make_surface(volume, isovalue, o_, entry, counts_, record_);
    result_.push_back(std::move(entry));
    if (at_ != std::string::npos) {
      std::string name = name_;
      name.replace(at_, std::string(kLabelInName).size(), std::to_string(static_cast<int>(number)));
      o_.write.attributes = record_.provenance();
      return write(name, surface, o_, record_);
    }
    o_.write.parts.push_back({number, surface.positions.size(), surface.triangles.size()});
    if (all_.positions.empty()) {
      all_ = std::move(surface);
    } else {
      record_.timed("join", [&] { mesh::append(all_, surface); });
    }
  }

  void finish() {
    for (const auto& [name, n] : counts_) record_.count(name, n);
    record_.result("surfaces", result_);
    if (at_ != std::string::npos) return;
    o_.write.attributes = record_.provenance();
    write(o_.output, all_, o_, record_);
  }

 private:
  Options& o_;
  cli::Record& record_;
  std::string name_;
  std::size_t at_;  // of {label} in the name
  json result_ = json::array();
  std::map<std::string, std::int64_t> counts_;
  mesh::TriangleMesh all_;
};

int work(Options& o, cli::Record& record) {
  const bool by_label = !o.labels.empty();
  if (o.isovalue_texts.empty() && !by_label) throw Error("--isovalue or --label is required");
  if (!by_label && o.output.string().find(kLabelInName) != std::string::npos) {
    throw Error(std::string("-o: ") + kLabelInName + " in the name is for --label");
  }
  const auto isovalues = cli::parse_numbers("--isovalue", o.isovalue_texts);
  std::vector<int> labels;
  if (by_label && o.labels != "all") labels = cli::parse_labels("--label", o.labels);
  o.write.double_precision = o.type == "f64";
  o.mesh.normals = io::require_mesh_format(o.output, o.write) != "stl" && !o.no_normals;  // STL has none
  const volume::Volume volume = cli::load(o.input, record);
  o.mesh.memory_limit = io::ReadOptions::physical_memory();
  Surfaces surfaces(o, record);
  for (const double isovalue : isovalues) surfaces.add(volume, "isovalue", isovalue, isovalue);
  if (by_label) {
    o.write.part_name = "label";
    const auto grid = cli::naming(
        o.input.path, [&] { return record.timed("labels", [&] { return volume::label_grid(volume); }); });
    if (o.labels == "all") labels = volume::labels_in(grid);
    for (const int label : labels) {
      const auto share = record.timed("labels", [&] { return volume::indicator(grid, label); });
      surfaces.add(share, "label", label, 0.5);
    }
  }
  surfaces.finish();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Isosurfaces of a volume as a triangle mesh: marching cubes with the topology of the trilinear field.\n"
      "Values at least the isovalue are inside, ties too; the mesh has no cracks, whatever the data.\n"
      "With --label the surfaces around the regions of a label volume."};
  Options options;
  declare(app, options);
  return cli::run(
      app,
      {.name = "isosurf-mc",
       .example = "vol-phantom marschner-lobb -o - | isosurf-mc - --isovalue 0.5 -o ml.ply",
       .references = "Lorensen & Cline 1987; Nielson & Hamann 1991; Nielson 2003; Custodio et al. 2013",
       .repeats = true},
      argc, argv, [&](cli::Record& record) { return work(options, record); });
}
