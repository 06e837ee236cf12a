// The data of NRRD; its header: nrrd_header.h.
#include <algorithm>
#include <memory>

#include "base/checked.h"
#include "base/error.h"
#include "io/nrrd_header.h"
#include "io/volume_formats.h"
#include "io/voxel_data.h"

namespace vol::io {
namespace {

using nrrd::Header;

/// `data file`: a name, `pattern min max step [subdim]`, or LIST. The data are cut into equal parts.
std::vector<std::string> data_file_names(const Header& header, const std::vector<std::int64_t>& sizes) {
  const std::string& text = header.need("datafile");
  if (text.compare(0, 4, "LIST") == 0) {
    if (header.listed_files.empty())
      throw Error(header.name + ": 'data file: LIST' is followed by no file name");
    return header.listed_files;
  }
  const auto words = words_of(text);
  if (words.size() < 4 || text.find('%') == std::string::npos) return {text};
  const Field field = header.field("data file");
  std::vector<std::int64_t> numbers;
  for (std::size_t i = 1; i < words.size(); ++i) numbers.push_back(parse_integer(field, words[i]));
  if (numbers.size() > 4) field.refuse(text, "pattern, minimum, maximum, step and dimension of a file");
  const std::int64_t dimension = static_cast<std::int64_t>(sizes.size());
  const std::int64_t in_file = numbers.size() == 4 ? numbers[3] : dimension - 1;
  if (in_file < 1 || in_file > dimension)
    field.refuse(text, "files of 1 to " + std::to_string(dimension) + " axes");
  std::int64_t count = 1;
  for (std::int64_t a = in_file; a < dimension; ++a)
    count = checked_product(count, sizes[static_cast<std::size_t>(a)]);
  if (in_file == dimension && numbers[2] != 0) count = (numbers[1] - numbers[0]) / numbers[2] + 1;  // slabs
  return numbered_files(field, words[0], numbers[0], numbers[1], numbers[2], count);
}

std::int64_t parse_skip(const Header& header, std::string_view field, std::int64_t least) {
  const std::string* text = header.find(field);
  if (text == nullptr) return 0;
  const std::int64_t skip = parse_integer(header.field(field), *text);
  if (skip < least) header.field(field).refuse(*text, "at least " + std::to_string(least));
  return skip;
}

}  // namespace

bool is_nrrd(std::string_view start) {
  return start.compare(0, 4, "NRRD") == 0;
}

volume::Volume read_nrrd(InputFile& file, const ReadOptions& options) {
  Header header = nrrd::read_header(file);
  const std::int64_t dimension = parse_integer(header.field("dimension"), header.need("dimension"));
  if (dimension < 1 || dimension > 16) {
    header.field("dimension").refuse(header.need("dimension"), "1 to 16");
  }
  const auto sizes =
      parse_integers(header.field("sizes"), header.need("sizes"), static_cast<std::size_t>(dimension));
  for (const auto size : sizes) {
    if (size < 1) header.field("sizes").refuse(header.need("sizes"), "at least 1 for each axis");
  }
  VoxelLayout layout;
  layout.type = nrrd::voxel_type(header);
  layout.geometry = nrrd::parse_geometry(header, sizes);
  const std::int64_t bytes = checked_bytes(header.name, layout, options);

  const std::string encoding = lower_case(header.need("encoding"));
  const bool text = encoding == "ascii" || encoding == "text" || encoding == "txt";
  const bool gzip = encoding == "gzip" || encoding == "gz";
  if (!text && !gzip && encoding != "raw") {
    header.field("encoding").refuse(header.need("encoding"), "raw, gzip or ascii");
  }
  if (!text && volume::size_in_bytes(layout.type) > 1) {
    const std::string endian = lower_case(header.need("endian"));
    if (endian != "little" && endian != "big") header.field("endian").refuse(endian, "little or big");
    layout.big_endian = endian == "big";
  }
  const std::int64_t line_skip = parse_skip(header, "lineskip", 0);
  const std::int64_t byte_skip = parse_skip(header, "byteskip", encoding == "raw" ? -1 : 0);

  std::unique_ptr<ByteSource> whole, inflated;
  std::int64_t in_source = bytes;
  if (header.find("datafile") != nullptr) {
    DataFiles files;
    for (const auto& name : data_file_names(header, sizes)) files.paths.push_back(beside(file.path(), name));
    const auto parts = static_cast<std::int64_t>(files.paths.size());
    if (layout.geometry.count() % parts != 0 || (text && parts != 1)) {
      throw Error(header.name + ": " + std::to_string(layout.geometry.count()) + " voxels do not fill " +
                  std::to_string(parts) + " data files evenly");
    }
    files.line_skip = line_skip;
    files.byte_skip = byte_skip;
    files.inflate = gzip;
    files.bytes_each = in_source / parts;
    if (text) {
      const auto data = open_data_file(files.paths[0]);
      FileSource source(*data);
      Scanner scanner(source);
      for (std::int64_t n = 0; n < line_skip; ++n) {
        if (scanner.at_end()) throw Error(scanner.name() + ": ends within the lines to skip");
        (void)scanner.line();
      }
      scanner.skip(byte_skip);
      volume::Volume volume = read_ascii(scanner, layout, options);
      volume.attributes = std::move(header.attributes);
      return volume;
    }
    whole = std::make_unique<DataFilesSource>(std::move(files));
  } else {
    for (std::int64_t n = 0; n < line_skip; ++n) (void)file.read_line(nrrd::kLongestHeader);
    whole = std::make_unique<FileSource>(file);
    if (byte_skip < 0) {
      if (whole->remaining() < bytes && whole->remaining() >= 0) (void)read_binary(*whole, layout, options);
      if (whole->remaining() < 0) throw Error(header.name + ": byte skip -1 needs a file, not a pipe");
      whole->skip(whole->remaining() - bytes);
    } else if (!gzip) {
      whole->skip(byte_skip);
    }
    if (gzip) {
      inflated = std::make_unique<InflateSource>(*whole);
      inflated->skip(byte_skip);
    }
  }
  ByteSource& source = inflated ? *inflated : *whole;
  volume::Volume volume;
  if (text) {
    Scanner scanner(source);
    volume = read_ascii(scanner, layout, options);
  } else {
    volume = read_binary(source, layout, options);
    expect_end(source, bytes);
  }
  volume.attributes = std::move(header.attributes);
  if (const auto* content = header.find("content")) volume.attributes["content"] = *content;
  return volume;
}

}  // namespace vol::io
