#include <algorithm>
#include <array>
#include <cctype>

#include "io/headers/header_fields.h"
#include "io/headers/volume_description.h"
#include "io/vtk/vtk_image.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr size_t kMostWordBytes = 1000;

bool isSpace(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

// Words and lines of a file from its start, whose numbers in between are passed over.
class Words {
 public:
  Words(const ByteInput& input, const std::string& path) : input_(input), path_(path) {}

  uint64_t position() const { return window_at_ + begin_; }

  // Empty at the end of the file. Throws Error: it is longer than any.
  std::string next() {
    skipSpaces();
    std::string word;
    for (int c = peek(); c >= 0 && !isSpace(static_cast<char>(c)); c = peek()) {
      if (word.size() == kMostWordBytes)
        fail("{}: expected a word in the header at {}, found none that ends", path_, position());
      word += static_cast<char>(c);
      ++begin_;
    }
    return word;
  }
  // The rest of the line.
  std::string line() {
    std::string text;
    for (int c = peek(); c >= 0; c = peek()) {
      ++begin_;
      if (c == '\n') break;
      if (text.size() == kMostWordBytes)
        fail("{}: expected a line of the header at {}, found none that ends", path_, position());
      text += static_cast<char>(c);
    }
    return text;
  }
  void skipBytes(uint64_t bytes) {
    // Offsets near 2^64 would wrap around to a place inside of the file.
    constexpr uint64_t kFarthest = uint64_t{1} << 62;
    window_at_ = std::min(position() + std::min(bytes, kFarthest), kFarthest);
    begin_ = end_ = 0;
  }
  // Throws Error: the file has fewer.
  void skipWords(uint64_t count) {
    for (uint64_t i = 0; i < count; ++i) {
      skipSpaces();
      if (peek() < 0)
        fail("{}: expected {} numbers before the end of the file, found {}; it was cut short",
             path_, count, i);
      while (peek() >= 0 && !isSpace(static_cast<char>(peek()))) ++begin_;
    }
  }

 private:
  void skipSpaces() {
    while (peek() >= 0 && isSpace(static_cast<char>(peek()))) ++begin_;
  }
  // The next byte; negative at the end of the file.
  int peek() {
    if (begin_ == end_) {
      window_at_ += end_;
      begin_ = 0;
      end_ = input_(window_at_, window_);
      if (end_ == 0) return -1;
    }
    return static_cast<int>(window_[begin_]);
  }

  const ByteInput& input_;
  const std::string& path_;
  std::array<std::byte, 64 << 10> window_;
  uint64_t window_at_ = 0;
  size_t begin_ = 0, end_ = 0;
};

// Bytes of a number in a binary file; 0: a kind of another length.
uint64_t bytesOf(const std::string& type) {
  if (type == "long" || type == "unsigned_long" || type == "vtktypeint64" ||
      type == "vtktypeuint64")
    return 8;
  // VTK writes its identifiers as 32-bit numbers here, whatever their length in memory.
  if (type == "vtkIdType") return 4;
  const auto voxel = vtkVoxelType(type);
  return voxel ? bytesPerVoxel(*voxel) : 0;
}

// Names are written with "%20" for a space.
std::string decodedName(const std::string& name) {
  std::string decoded;
  for (size_t i = 0; i < name.size(); ++i) {
    const auto digit = [&](size_t at) {
      const std::string_view digits = "0123456789abcdef";
      const size_t found = at < name.size() ? digits.find(static_cast<char>(std::tolower(name[at])))
                                            : std::string::npos;
      return found == std::string::npos ? -1 : static_cast<int>(found);
    };
    if (name[i] == '%' && digit(i + 1) >= 0 && digit(i + 2) >= 0) {
      decoded += static_cast<char>(16 * digit(i + 1) + digit(i + 2));
      i += 2;
    } else {
      decoded += name[i];
    }
  }
  return decoded;
}

class LegacyParser {
 public:
  LegacyParser(const ByteInput& input, const std::string& path)
      : words_(input, path), path_(path) {}

  VtkImage parse() {
    words_.line();  // the version
    words_.line();  // a title
    const std::string form = words_.next();
    if (form != "ASCII" && form != "BINARY")
      fail("{}: expected ASCII or BINARY in line 3, found {}", path_, inQuotes(form));
    is_text_ = form == "ASCII";
    // Binary numbers of legacy files are big-endian on all machines.
    image_.byte_order = std::endian::big;
    const std::string data = words_.next(), kind = words_.next();
    if (data != "DATASET" || kind != "STRUCTURED_POINTS")
      fail("{}: expected DATASET STRUCTURED_POINTS, found {} {}", path_, inQuotes(data),
           inQuotes(kind));
    for (std::string word = words_.next(); !word.empty(); word = words_.next())
      if (!take(word)) break;
    if (!has_dimensions_) fail("{}: expected DIMENSIONS, found none", path_);
    return std::move(image_);
  }

 private:
  int64_t whole(const char* what) {
    const std::string word = words_.next();
    const auto value = parseInteger(word);
    if (!value || *value < 0)
      fail("{}: expected a whole number as {}, found {}", path_, what, inQuotes(word));
    return *value;
  }
  Vec3d vector(const char* what) {
    Vec3d found;
    for (int a = 0; a < 3; ++a) {
      const std::string word = words_.next();
      const auto value = parseReal(word);
      if (!value) fail("{}: expected a number as {}, found {}", path_, what, inQuotes(word));
      found[a] = *value;
    }
    return found;
  }

  // Passes over the numbers of an array, at which the file is. Returns false if the way beyond them
  // is not known.
  bool skipNumbers(const std::string& type, uint64_t count) {
    if (is_text_) {
      words_.skipWords(count);
      return true;
    }
    const uint64_t bytes = bytesOf(type);
    uint64_t all = 0;
    // Counts of the file may make any product.
    if (type == "bit")
      all = (count + 7) / 8;
    else if (bytes == 0 || __builtin_mul_overflow(count, bytes, &all))
      return false;
    words_.skipBytes(all);
    return true;
  }

  bool addArray(const std::string& name, const std::string& type, int64_t components,
                int64_t tuples) {
    VtkArray array{.name = decodedName(name),
                   .type = type,
                   .components = components,
                   .is_of_cells = are_cells_,
                   .form = is_text_ ? VtkForm::kText : VtkForm::kRaw,
                   .offset = words_.position()};
    uint64_t count = 0;
    if (components < 1 || __builtin_mul_overflow(components, tuples, &count))
      fail("{}: expected an array of 1 component or more, found {}", path_, components);
    const bool is_known = skipNumbers(type, count);
    array.end = words_.position();
    if (image_.arrays.size() == kMostVtkArrays)
      fail("{}: expected at most {} arrays, found more", path_, kMostVtkArrays);
    // A field's arrays may have any length; only one number a point or cell makes a volume.
    if (is_of_data_ && tuples == count_) image_.arrays.push_back(std::move(array));
    return is_known;
  }

  // SCALARS and its siblings: a name, and a type perhaps.
  bool attribute(const std::string& kind) {
    if (!is_of_data_)
      fail("{}: expected POINT_DATA or CELL_DATA before {}, found none", path_, kind);
    const std::string name = words_.next();
    int64_t components = kind == "TENSORS" ? 9 : kind == "TENSORS6" ? 6 : 3;
    // COLOR_SCALARS name no type: bytes if binary, fractions of 1 in text.
    std::string type = is_text_ ? std::string(kVtkTextColors) : "unsigned_char";
    if (kind == "TEXTURE_COORDINATES" || kind == "COLOR_SCALARS") components = whole("components");
    if (kind != "COLOR_SCALARS") type = words_.next();
    const std::string rest = words_.line();
    if (kind.ends_with("_IDS")) components = 1;
    if (kind == "SCALARS") {
      components = 1;
      if (const std::string_view said = trimmed(rest); !said.empty()) {
        const auto value = parseInteger(said);
        if (!value)
          fail("{}: expected components of {}, found {}", path_, inQuotes(name), inQuotes(said));
        components = *value;
      }
      if (const std::string table = words_.next(); table != "LOOKUP_TABLE")
        fail("{}: expected LOOKUP_TABLE after SCALARS {}, found {}", path_, inQuotes(name),
             inQuotes(table));
      words_.line();
      std::string& active = are_cells_ ? image_.active_cell : image_.active_point;
      if (active.empty()) active = decodedName(name);
    }
    return addArray(name, type, components, count_);
  }

  bool field() {
    words_.next();  // its name
    const int64_t arrays = whole("the number of a field's arrays");
    for (int64_t i = 0; i < arrays; ++i) {
      std::string name = words_.next();
      if (name == "METADATA") {
        metadata();
        name = words_.next();
      }
      if (name.empty())
        fail("{}: expected {} arrays of a field, found {}; the file was cut short", path_, arrays,
             i);
      const int64_t components = whole("components"), tuples = whole("the length of an array");
      const std::string type = words_.next();
      words_.line();
      if (!addArray(name, type, std::max<int64_t>(components, 1), components == 0 ? 0 : tuples))
        return false;
    }
    return true;
  }

  // Lines up to an empty one.
  void metadata() {
    words_.line();
    while (!trimmed(words_.line()).empty()) {
    }
  }

  bool take(const std::string& word) {
    if (word == "DIMENSIONS") {
      for (size_t a = 0; a < 3; ++a) image_.extent[2 * a + 1] = whole("DIMENSIONS") - 1;
      has_dimensions_ = true;
    } else if (word == "SPACING" || word == "ASPECT_RATIO") {
      image_.spacing = vector("SPACING");
    } else if (word == "ORIGIN") {
      image_.origin = vector("ORIGIN");
    } else if (word == "POINT_DATA" || word == "CELL_DATA") {
      if (!has_dimensions_) fail("{}: expected DIMENSIONS before {}, found none", path_, word);
      are_cells_ = word == "CELL_DATA";
      is_of_data_ = true;
      count_ = whole(word.c_str());
      words_.line();
      // The layout is checked before the count is compared: volume() must not overflow.
      VolumeLayout layout = vtkLayout(image_, are_cells_, path_);
      checkedVolumeBytes(path_, layout);
      if (count_ != volume(layout.dims))
        fail("{}: expected {} {}, as DIMENSIONS make, found {}", path_, word, volume(layout.dims),
             count_);
    } else if (word == "FIELD") {
      return field();
    } else if (word == "METADATA") {
      metadata();
    } else if (word == "LOOKUP_TABLE") {
      words_.next();
      const int64_t colors = whole("the length of a LOOKUP_TABLE");
      words_.line();
      return skipNumbers("unsigned_char", 4 * static_cast<uint64_t>(colors));
    } else {
      constexpr std::string_view kAttributes[] = {
          "SCALARS", "COLOR_SCALARS", "VECTORS",    "NORMALS",     "TEXTURE_COORDINATES",
          "TENSORS", "TENSORS6",      "GLOBAL_IDS", "PEDIGREE_IDS"};
      if (std::find(std::begin(kAttributes), std::end(kAttributes), word) == std::end(kAttributes))
        fail(
            "{}: expected DIMENSIONS, ORIGIN, SPACING, POINT_DATA, CELL_DATA, SCALARS or FIELD, "
            "found {}",
            path_, inQuotes(word));
      return attribute(word);
    }
    return true;
  }

  Words words_;
  const std::string& path_;
  VtkImage image_;
  bool is_text_ = false, has_dimensions_ = false;
  bool is_of_data_ = false, are_cells_ = false;  // after POINT_DATA or CELL_DATA
  int64_t count_ = 0;                            // of points or cells there
};

}  // namespace

VtkImage parseLegacyVtk(const ByteInput& input, const std::string& path) {
  return LegacyParser(input, path).parse();
}

}  // namespace sluice
