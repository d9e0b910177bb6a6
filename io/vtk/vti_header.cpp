#include <algorithm>
#include <array>

#include "io/headers/header_fields.h"
#include "io/vtk/vtk_image.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr size_t kMostNameBytes = 1000;

bool isWhite(std::byte c) {
  return c == std::byte{' '} || (c >= std::byte{'\t'} && c <= std::byte{'\r'});
}

// The first byte from `offset` on that is not white space.
uint64_t skipWhite(const ByteInput& input, uint64_t offset) {
  std::array<std::byte, 256> piece;
  for (;;) {
    const size_t got = input(offset, piece);
    const auto end = piece.begin() + static_cast<std::ptrdiff_t>(got);
    const auto found = std::find_if_not(piece.begin(), end, isWhite);
    offset += static_cast<uint64_t>(found - piece.begin());
    if (found != end || got < piece.size()) return offset;
  }
}

class VtiParser {
 public:
  VtiParser(const ByteInput& input, const std::string& path) : input_(input), path_(path) {}

  VtkImage parse() {
    scanXml(input_, path_,
            {.begin = [this](const XmlTag& tag) { return begin(tag); },
             .end = [this](std::string_view name, uint64_t at) { end(name, at); },
             .text = {}});
    if (pieces_ == 0) fail("{}: expected an ImageData element with a Piece, found none", path_);
    // Offsets count from behind the '_' of AppendedData, which follows all arrays.
    for (const size_t array : appended_) image_.arrays[array].offset += appended_at_.value_or(0);
    if (!appended_.empty() && !appended_at_)
      fail("{}: expected an AppendedData element, found none", path_);
    return std::move(image_);
  }

 private:
  template <class Value, size_t kCount, class Parse>
  std::array<Value, kCount> numbers(std::string_view text, const char* attribute,
                                    const Parse& parse) const {
    const std::vector<std::string_view> words = splitWords(text);
    std::array<Value, kCount> found{};
    for (size_t i = 0; i < kCount; ++i) {
      const auto value = words.size() == kCount ? parse(words[i]) : std::nullopt;
      if (!value)
        fail("{}: expected {} numbers as {}, found {}", path_, kCount, attribute, inQuotes(text));
      found[i] = *value;
    }
    return found;
  }
  std::array<int64_t, 6> extent(std::string_view text, const char* attribute) const {
    return numbers<int64_t, 6>(text, attribute, parseInteger);
  }
  Vec3d vector(std::string_view text, const char* attribute) const {
    const auto n = numbers<double, 3>(text, attribute, parseReal);
    return {n[0], n[1], n[2]};
  }

  void file(const XmlTag& tag) {
    const std::string_view type = tag.find("type").value_or("");
    if (type != "ImageData")
      fail("{}: expected a VTK file of ImageData, found one of {}", path_, inQuotes(type));
    const std::string_view order = tag.find("byte_order").value_or("LittleEndian");
    if (order != "LittleEndian" && order != "BigEndian")
      fail("{}: expected the byte_order LittleEndian or BigEndian, found {}", path_,
           inQuotes(order));
    image_.byte_order = order == "BigEndian" ? std::endian::big : std::endian::little;
    const std::string_view header = tag.find("header_type").value_or("UInt32");
    if (header != "UInt32" && header != "UInt64")
      fail("{}: expected the header_type UInt32 or UInt64, found {}", path_, inQuotes(header));
    image_.header_bytes = header == "UInt64" ? 8 : 4;
    image_.has_block_headers = true;
    constexpr std::pair<std::string_view, VtkCodec> kCodecs[] = {
        {"", VtkCodec::kNone},
        {"vtkZLibDataCompressor", VtkCodec::kZlib},
        {"vtkLZ4DataCompressor", VtkCodec::kLz4},
        {"vtkLZMADataCompressor", VtkCodec::kXz}};
    const std::string_view compressor = tag.find("compressor").value_or("");
    const auto* const known =
        std::find_if(std::begin(kCodecs), std::end(kCodecs),
                     [&](const auto& codec) { return codec.first == compressor; });
    if (known == std::end(kCodecs))
      fail("{}: expected the compressor vtkZLib-, vtkLZ4- or vtkLZMADataCompressor, found {}",
           path_, inQuotes(compressor));
    image_.codec = known->second;
  }

  void place(const XmlTag& tag) {
    const auto whole = tag.find("WholeExtent");
    if (!whole) fail("{}: expected a WholeExtent of ImageData, found none", path_);
    image_.extent = extent(*whole, "WholeExtent");
    if (const auto origin = tag.find("Origin")) image_.origin = vector(*origin, "Origin");
    if (const auto spacing = tag.find("Spacing")) image_.spacing = vector(*spacing, "Spacing");
    if (const auto direction = tag.find("Direction"))
      image_.direction = numbers<double, 9>(*direction, "Direction", parseReal);
    has_place_ = true;
  }

  void piece(const XmlTag& tag) {
    if (!has_place_) fail("{}: expected a Piece inside ImageData, found one elsewhere", path_);
    const auto own = tag.find("Extent");
    if (++pieces_ > 1 || (own && extent(*own, "Extent") != image_.extent))
      fail("{}: expected one Piece of the whole extent, found a part; save the image as one piece",
           path_);
  }

  void array(const XmlTag& tag) {
    VtkArray array;
    array.name = tag.find("Name").value_or("");
    array.type = tag.find("type").value_or("");
    if (image_.arrays.size() >= kMostVtkArrays || array.name.size() > kMostNameBytes ||
        array.type.size() > kMostNameBytes)
      fail("{}: expected at most {} arrays with names of at most {} bytes, found more", path_,
           kMostVtkArrays, kMostNameBytes);
    array.is_of_cells = *are_cells_;
    if (const auto components = tag.find("NumberOfComponents"))
      array.components = numbers<int64_t, 1>(*components, "NumberOfComponents", parseInteger)[0];
    const std::string_view format = tag.find("format").value_or("ascii");
    if (format == "appended") {
      const auto at =
          numbers<int64_t, 1>(tag.find("offset").value_or(""), "offset", parseInteger)[0];
      constexpr int64_t kMostOffset = int64_t{1} << 62;
      // The sum with the place of the appended data must not overflow later.
      if (at < 0 || at > kMostOffset)
        fail("{}: expected an offset of 0 or more, found {}", path_, at);
      array.offset = static_cast<uint64_t>(at);
      appended_.push_back(image_.arrays.size());
    } else if (format == "binary" || format == "ascii") {
      array.form = format == "binary" ? VtkForm::kBase64 : VtkForm::kText;
      array.offset = skipWhite(input_, tag.content_at);
      is_in_array_ = true;
    } else {
      fail("{}: expected the format ascii, binary or appended, found {}", path_, inQuotes(format));
    }
    image_.arrays.push_back(std::move(array));
  }

  void appended(const XmlTag& tag) {
    const std::string_view encoding = tag.find("encoding").value_or("base64");
    if (encoding != "raw" && encoding != "base64")
      fail("{}: expected the encoding raw or base64, found {}", path_, inQuotes(encoding));
    const uint64_t at = skipWhite(input_, tag.content_at);
    std::array<std::byte, 1> mark{};
    if (input_(at, mark) != 1 || mark[0] != std::byte{'_'})
      fail("{}: expected '_' in front of the appended data, found none", path_);
    appended_at_ = at + 1;
    for (const size_t array : appended_)
      image_.arrays[array].form = encoding == "raw" ? VtkForm::kRaw : VtkForm::kBase64;
  }

  bool begin(const XmlTag& tag) {
    if (tag.name == "VTKFile") {
      file(tag);
      is_known_ = true;
    } else if (!is_known_) {
      fail("{}: expected a VTKFile element, found {}", path_, inQuotes(tag.name));
    } else if (tag.name == "ImageData") {
      place(tag);
    } else if (tag.name == "Piece") {
      piece(tag);
    } else if (tag.name == "PointData" || tag.name == "CellData") {
      are_cells_ = tag.name == "CellData";
      std::string& active = *are_cells_ ? image_.active_cell : image_.active_point;
      active = tag.find("Scalars").value_or("");
    } else if (tag.name == "DataArray" && are_cells_) {
      array(tag);
    } else if (tag.name == "AppendedData") {
      appended(tag);
      return false;  // no XML follows
    }
    return true;
  }

  void end(std::string_view name, uint64_t at) {
    if (name == "PointData" || name == "CellData") are_cells_.reset();
    if (name != "DataArray" || !is_in_array_) return;
    image_.arrays.back().end = at;
    is_in_array_ = false;
  }

  const ByteInput& input_;
  const std::string& path_;
  VtkImage image_;
  bool is_known_ = false, has_place_ = false, is_in_array_ = false;
  int pieces_ = 0;
  std::optional<bool> are_cells_;  // inside PointData or CellData
  std::vector<size_t> appended_;   // arrays whose numbers are appended
  std::optional<uint64_t> appended_at_;
};

}  // namespace

VtkImage parseVti(const ByteInput& input, const std::string& path) {
  return VtiParser(input, path).parse();
}

}  // namespace sluice
