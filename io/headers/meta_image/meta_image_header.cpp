#include "io/headers/meta_image/meta_image_header.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "io/files/length_unit.h"
#include "io/headers/header_fields.h"
#include "src/base/error.h"
#include "src/base/values/letter_case.h"

namespace sluice {
namespace {

constexpr std::string_view kDataFile = "ElementDataFile";

struct Fields {
  std::string path;
  std::map<std::string, std::string_view, std::less<>> values;
  std::vector<std::string_view> listed_files;
  size_t header_bytes = 0;

  // The first of `names` that is there: keys have had several names.
  std::optional<std::string_view> find(std::initializer_list<std::string_view> names) const {
    for (const std::string_view name : names)
      if (const auto found = values.find(name); found != values.end()) return found->second;
    return std::nullopt;
  }
  std::string_view demand(std::string_view name) const {
    const std::optional<std::string_view> value = find({name});
    if (!value) fail("{}: the MetaImage header has no {}", path, name);
    return *value;
  }
};

bool isList(std::string_view data_file) {
  return data_file == "LIST" || data_file.starts_with("LIST ");
}

std::optional<std::pair<std::string_view, std::string_view>> keyAndValue(std::string_view line) {
  const size_t equals = line.find('=');
  if (equals == std::string_view::npos) return std::nullopt;
  return std::pair(trimmed(line.substr(0, equals)), trimmed(line.substr(equals + 1)));
}

Fields readFields(std::string_view text, const std::string& path) {
  Fields fields;
  fields.path = path;
  LineReader lines(text);
  // This key ends the header. The names of a list, or the voxels themselves, may follow its line.
  while (!fields.find({kDataFile})) {
    const std::optional<std::string_view> line = lines.next();
    if (!line) fail("{}: no MetaImage file: the header has no {}", path, kDataFile);
    if (trimmed(*line).empty()) continue;
    const auto entry = keyAndValue(*line);
    if (!entry) fail("{}: header line {} is no 'Key = Value'", path, inQuotes(*line));
    if (!fields.values.emplace(entry->first, entry->second).second)
      fail("{}: the header has the key {} twice", path, inQuotes(entry->first));
  }
  fields.header_bytes = lines.position();
  if (isList(fields.demand(kDataFile)))
    while (const std::optional<std::string_view> line = lines.next())
      if (!trimmed(*line).empty()) fields.listed_files.push_back(trimmed(*line));
  return fields;
}

constexpr std::array<std::string_view, 37> kKnownKeys = {"AcquisitionDate",
                                                         "AnatomicalOrientation",
                                                         "BinaryData",
                                                         "BinaryDataByteOrderMSB",
                                                         "CenterOfRotation",
                                                         "Color",
                                                         "Comment",
                                                         "CompressedData",
                                                         "CompressedDataSize",
                                                         "CompressionLevel",
                                                         "DimSize",
                                                         "DistanceUnits",
                                                         "ElementByteOrderMSB",
                                                         "ElementDataFile",
                                                         "ElementMax",
                                                         "ElementMin",
                                                         "ElementNumberOfChannels",
                                                         "ElementSize",
                                                         "ElementSpacing",
                                                         "ElementToIntensityFunctionOffset",
                                                         "ElementToIntensityFunctionSlope",
                                                         "ElementType",
                                                         "HeaderSize",
                                                         "HeaderSizePerSlice",
                                                         "ID",
                                                         "Modality",
                                                         "NDims",
                                                         "Name",
                                                         "ObjectSubType",
                                                         "ObjectType",
                                                         "Offset",
                                                         "Orientation",
                                                         "Origin",
                                                         "ParentID",
                                                         "Position",
                                                         "Rotation",
                                                         "TransformMatrix"};

// Programs add keys of their own (ITK adds DICOM's), which are no mistakes; a key that almost
// equals a known one is.
void noteMisspeltKeys(const Fields& fields, VolumeLayout& layout) {
  std::vector<std::string> misspelt;
  for (const auto& field : fields.values) {
    const std::string& key = field.first;
    const bool is_known = std::find(kKnownKeys.begin(), kKnownKeys.end(), key) != kKnownKeys.end();
    // Short names resemble one another.
    if (!is_known && std::any_of(kKnownKeys.begin(), kKnownKeys.end(), [&](std::string_view known) {
          return known.size() > 4 && isNearMiss(key, known);
        }))
      misspelt.push_back(key);
  }
  if (!misspelt.empty()) layout.notes.push_back(unknownFieldsNote(fields.path, misspelt));
}

int64_t integer(const Fields& fields, std::string_view name, std::string_view text, int64_t least,
                int64_t most = std::numeric_limits<int64_t>::max()) {
  const std::optional<int64_t> value = parseInteger(text);
  if (!value || *value < least || *value > most)
    fail("{}: {} = {} is no whole number from {} to {}", fields.path, name, inQuotes(text), least,
         most);
  return *value;
}

bool flag(const Fields& fields, std::initializer_list<std::string_view> names, bool otherwise) {
  const std::optional<std::string_view> value = fields.find(names);
  if (!value) return otherwise;
  const std::string text = lowercase(*value);
  if (text == "true" || text == "t" || text == "1") return true;
  if (text == "false" || text == "f" || text == "0") return false;
  fail("{}: {} = {} is neither True nor False", fields.path, *names.begin(), inQuotes(*value));
}

// Empty if none of the names is there.
std::vector<double> reals(const Fields& fields, std::initializer_list<std::string_view> names,
                          size_t count) {
  std::vector<double> values;
  const std::optional<std::string_view> text = fields.find(names);
  if (!text) return values;
  const std::vector<std::string_view> words = splitWords(*text);
  if (words.size() != count)
    fail("{}: {} has {} numbers, {} expected", fields.path, *names.begin(), words.size(), count);
  for (const std::string_view word : words) {
    const std::optional<double> value = parseReal(word);
    if (!value) fail("{}: {}: {} is no number", fields.path, *names.begin(), inQuotes(word));
    values.push_back(*value);
  }
  return values;
}

VoxelType elementType(const Fields& fields) {
  constexpr std::array<std::pair<std::string_view, VoxelType>, 10> kTypes = {
      {{"MET_UCHAR", VoxelType::kU8},
       {"MET_CHAR", VoxelType::kI8},
       {"MET_USHORT", VoxelType::kU16},
       {"MET_SHORT", VoxelType::kI16},
       {"MET_UINT", VoxelType::kU32},
       {"MET_INT", VoxelType::kI32},
       // MetaIO writes four bytes for both, whatever the machine's long is.
       {"MET_ULONG", VoxelType::kU32},
       {"MET_LONG", VoxelType::kI32},
       {"MET_FLOAT", VoxelType::kF32},
       {"MET_DOUBLE", VoxelType::kF64}}};
  const std::string_view text = fields.demand("ElementType");
  for (const auto& [name, type] : kTypes)
    if (name == text) return type;
  fail("{}: ElementType {} is not read; scalars of 8 to 32 bits and MET_DOUBLE are", fields.path,
       inQuotes(text));
}

void demandScalarImage(const Fields& fields) {
  const std::string_view object = fields.find({"ObjectType"}).value_or("Image");
  if (object != "Image") fail("{}: ObjectType {} is no Image", fields.path, inQuotes(object));
  const std::string_view channels = fields.find({"ElementNumberOfChannels"}).value_or("1");
  const int64_t count = integer(fields, "ElementNumberOfChannels", channels, 1);
  if (count != 1)
    fail("{}: {} channels; only volumes of one value per voxel are read", fields.path, count);
}

std::vector<int64_t> sizes(const Fields& fields) {
  const size_t dimension =
      static_cast<size_t>(integer(fields, "NDims", fields.demand("NDims"), 2, 4));
  const std::vector<std::string_view> words = splitWords(fields.demand("DimSize"));
  if (words.size() != dimension)
    fail("{}: DimSize has {} numbers, NDims is {}", fields.path, words.size(), dimension);
  std::vector<int64_t> values;
  values.reserve(dimension);
  for (const std::string_view word : words) values.push_back(integer(fields, "DimSize", word, 1));
  return values;
}

// ITK's world is DICOM's, whatever the voxels' axes are called; MetaIO writes "???" if it knows of
// none.
WorldFrame frameOf(const Fields& fields) {
  const auto says = fields.find({"AnatomicalOrientation"});
  if (!says)
    return fields.find({"TransformMatrix", "Orientation", "Rotation"}) ? WorldFrame::kLps
                                                                       : WorldFrame::kNone;
  const std::string letters = lowercase(*says);
  const bool known = letters.size() >= 3 && letters.find_first_not_of("rlapsi") == letters.npos;
  return known ? WorldFrame::kLps : WorldFrame::kNone;
}

void readGeometry(const Fields& fields, size_t dimension, VolumeLayout& layout) {
  const size_t axes = std::min<size_t>(dimension, 3);
  const std::vector<double> spacing = reals(fields, {"ElementSpacing", "ElementSize"}, dimension);
  const std::vector<double> matrix =
      reals(fields, {"TransformMatrix", "Orientation", "Rotation"}, dimension * dimension);
  const std::vector<double> offset = reals(fields, {"Offset", "Position", "Origin"}, dimension);
  std::vector<Vec3d> steps(axes);
  Vec3d origin;
  for (size_t axis = 0; axis < axes; ++axis) {
    const double size = spacing.empty() ? 1 : spacing[axis];
    for (size_t i = 0; i < axes; ++i) {
      const double direction = matrix.empty() ? (i == axis ? 1 : 0) : matrix[axis * dimension + i];
      // A row of the matrix is the direction of an axis.
      steps[axis][static_cast<int>(i)] = direction * size;
    }
    if (!offset.empty()) origin[static_cast<int>(axis)] = offset[axis];
  }
  setSteps(fields.path, steps, layout);
  // A fourth one is of time.
  const std::span of_space = std::span(spacing).first(std::min(axes, spacing.size()));
  if (const std::string note = negativeSpacingNote(fields.path, of_space); !note.empty())
    layout.notes.push_back(note);
  setOrigin(fields.path, origin, layout);
  layout.frame = frameOf(fields);
  layout.unit = lengthUnit(fields.find({"DistanceUnits"}).value_or(""));
}

void readValues(const Fields& fields, VolumeLayout& layout) {
  const std::vector<double> least = reals(fields, {"ElementMin"}, 1);
  const std::vector<double> greatest = reals(fields, {"ElementMax"}, 1);
  if (!least.empty() && !greatest.empty())
    setStoredRange(fields.path, least[0], greatest[0], layout);
  const std::vector<double> slope = reals(fields, {"ElementToIntensityFunctionSlope"}, 1);
  const std::vector<double> offset = reals(fields, {"ElementToIntensityFunctionOffset"}, 1);
  setValueScale(fields.path, slope.empty() ? 1 : slope[0], offset.empty() ? 0 : offset[0], layout);
}

FileSet readFiles(const Fields& fields, const std::vector<int64_t>& size) {
  FileSet files;
  const std::string_view text = fields.demand(kDataFile);
  const std::vector<std::string_view> words = splitWords(text);
  size_t held = size.size() - 1;  // dimensions that each file holds
  if (text == "LOCAL" || text == "Local" || text == "local") return files;
  if (isList(text)) {
    for (const std::string_view name : fields.listed_files) addFileName(fields.path, name, files);
    if (words.size() > 1) {
      const std::string_view number =
          words[1].substr(0, words[1].find_last_not_of("Dd") + 1);  // "2D" or "2"
      held = static_cast<size_t>(
          integer(fields, kDataFile, number, 1, static_cast<int64_t>(size.size())));
    }
    if (files.names.empty()) fail("{}: {} = LIST and no names after it", fields.path, kDataFile);
  } else if (words.size() == 4 && words[0].find('%') != std::string_view::npos) {
    files = parseFilePattern(fields.path, words[0], words[1], words[2], words[3]);
  } else {
    addFileName(fields.path, text, files);
    return files;
  }
  int64_t wanted = 1;
  for (size_t axis = held; axis < size.size(); ++axis)
    if (__builtin_mul_overflow(wanted, size[axis], &wanted))
      fail("{}: DimSize does not fit 63 bits", fields.path);
  if (files.count() != wanted)
    fail("{}: {} data files of {} dimensions named, {} expected for its DimSize", fields.path,
         files.count(), held, wanted);
  return files;
}

void readSkip(const Fields& fields, VolumeDescription& description) {
  const std::optional<std::string_view> text = fields.find({"HeaderSize"});
  if (!text) return;
  const int64_t bytes = integer(fields, "HeaderSize", *text, -1, kMostSkipBytes);
  // Data in the header's own file start behind it, whatever HeaderSize is.
  if (description.files.attached()) return;
  description.byte_skip = bytes;
  if (bytes == VolumeDescription::kSkipToEnd && description.encoding != Encoding::kRaw)
    fail("{}: HeaderSize -1 needs data that are neither compressed nor text", fields.path);
}

}  // namespace

bool metaImageHeaderComplete(std::string_view text) {
  LineReader lines(text);
  while (const std::optional<std::string_view> line = lines.next()) {
    const auto entry = keyAndValue(*line);
    if (!entry || entry->first != kDataFile) continue;
    // Ended by a line feed, not by the end of the bytes read so far.
    return text[lines.position() - 1] == '\n' && !isList(entry->second);
  }
  return false;
}

VolumeDescription parseMetaImageHeader(std::string_view text, const std::string& path) {
  const Fields fields = readFields(text, path);
  demandScalarImage(fields);
  VolumeDescription description;
  VolumeLayout& layout = description.layout;
  layout.type = elementType(fields);
  const std::vector<int64_t> size = sizes(fields);
  layout.dims = {size[0], size[1], size.size() > 2 ? size[2] : 1};
  layout.time_steps = size.size() > 3 ? size[3] : 1;
  checkedVolumeBytes(path, layout);
  readGeometry(fields, size.size(), layout);
  readValues(fields, layout);
  noteMisspeltKeys(fields, layout);
  const bool msb = flag(fields, {"ElementByteOrderMSB", "BinaryDataByteOrderMSB"}, false);
  description.byte_order = msb ? std::endian::big : std::endian::little;
  if (flag(fields, {"CompressedData"}, false)) description.encoding = Encoding::kDeflate;
  if (!flag(fields, {"BinaryData"}, true)) {
    if (description.encoding == Encoding::kDeflate)
      fail("{}: CompressedData = True needs BinaryData = True", path);
    description.encoding = Encoding::kText;
  }
  if (const auto bytes = fields.find({"CompressedDataSize"}))
    integer(fields, "CompressedDataSize", *bytes, 0);
  description.files = readFiles(fields, size);
  description.data_offset = fields.header_bytes;
  readSkip(fields, description);
  return description;
}

}  // namespace sluice
