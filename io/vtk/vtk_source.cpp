#include "io/vtk/vtk_source.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>
#include <vector>

#include "io/headers/decoded_file.h"
#include "io/headers/header_fields.h"
#include "io/headers/raw/raw_source.h"
#include "io/headers/volume_description.h"
#include "io/vtk/vtk_bytes.h"
#include "io/vtk/vtk_image.h"
#include "src/base/error.h"
#include "src/base/files/json_field.h"
#include "src/base/sources/volume_channels.h"

namespace sluice {
namespace {

class VtkSource final : public RawSource, public ChanneledSource {
 public:
  VtkSource(VolumeLayout layout, std::endian byte_order, RawSegment segment, std::string identity,
            std::vector<std::string> names)
      : RawSource(std::move(layout), byte_order, {std::move(segment)}, nullptr,
                  std::move(identity)),
        names_(std::move(names)) {}
  std::span<const std::string> channelNames() const override { return names_; }

 private:
  const std::vector<std::string> names_;
};

bool isReadable(const VtkArray& array) {
  return array.components == 1 && vtkVoxelType(array.type).has_value();
}

std::string described(const VtkArray& array) {
  if (array.type == kVtkTextColors && array.components == 1)
    return fmt::format(
        "{} (COLOR_SCALARS as text, 1 a {}; write the file as BINARY, or the numbers as SCALARS)",
        inQuotes(array.name), array.is_of_cells ? "cell" : "point");
  return fmt::format("{} ({} of {} a {})", inQuotes(array.name), array.components,
                     inQuotes(array.type), array.is_of_cells ? "cell" : "point");
}

// The arrays that are channels, the active one first, and a note of those that are not.
std::vector<VtkArray> channelsOf(const VtkImage& image, const ChannelWish& wish,
                                 const std::string& path, VolumeLayout& layout) {
  const auto any = [&](const auto& test) {
    return std::any_of(image.arrays.begin(), image.arrays.end(), test);
  };
  const bool has_points =
      any([](const VtkArray& array) { return isReadable(array) && !array.is_of_cells; });
  // Arrays of points come first, unless one of cells is asked for by its name.
  const bool is_named_of_cells = any([&](const VtkArray& array) {
    return array.is_of_cells && isReadable(array) && !wish.number && array.name == wish.name;
  });
  const bool of_cells = is_named_of_cells || !has_points;
  std::vector<VtkArray> channels;
  std::string others;
  for (const VtkArray& array : image.arrays) {
    if (isReadable(array) && array.is_of_cells == of_cells)
      channels.push_back(array);
    else if (others.size() < 200)
      others += (others.empty() ? "" : ", ") + described(array);
  }
  if (channels.empty())
    fail(
        "{}: expected an array of one number a point or cell, of 8 to 32 bits or a float, "
        "found {}",
        path, others.empty() ? "no array" : others);
  const std::string& active = of_cells ? image.active_cell : image.active_point;
  std::stable_partition(channels.begin(), channels.end(),
                        [&](const VtkArray& array) { return array.name == active; });
  if (!others.empty())
    layout.notes.push_back(fmt::format("{}: arrays that are left out: {}", path, others));
  return channels;
}

VtkImage imageOfFile(File& file) {
  const ByteInput input = [&file](uint64_t offset, std::span<std::byte> out) {
    return file.readSome(offset, out);
  };
  std::array<std::byte, 64> front;
  const size_t got = file.readSome(0, front);
  if (isLegacyVtk({reinterpret_cast<const char*>(front.data()), got}))
    return parseLegacyVtk(input, file.path());
  return parseVti(input, file.path());
}

}  // namespace

std::unique_ptr<VolumeSource> openVtk(const std::filesystem::path& path, const ChannelWish& channel,
                                      const DecodeOptions& decode) {
  auto file = std::make_shared<File>(path);
  const VtkImage image = imageOfFile(*file);
  std::vector<std::string> notes, names;
  VolumeLayout choice;
  const std::vector<VtkArray> arrays = channelsOf(image, channel, file->path(), choice);
  for (const VtkArray& array : arrays) names.push_back(printable(array.name, kLongestName));
  choice.channels = static_cast<int64_t>(arrays.size());
  if (choice.channels > 1 || channel.given()) chooseChannel(file->path(), channel, names, choice);
  const VtkArray& array = arrays[static_cast<size_t>(choice.channel)];

  VolumeLayout layout = vtkLayout(image, array.is_of_cells, file->path());
  layout.type = *vtkVoxelType(array.type);
  layout.name = path.filename().string();
  layout.path = file->path();
  layout.channels = choice.channels;
  layout.channel = choice.channel;
  std::ranges::move(choice.notes, std::back_inserter(layout.notes));
  const auto bytes = static_cast<uint64_t>(checkedVolumeBytes(file->path(), layout));
  std::endian order = image.byte_order;
  RawSegment segment;
  if (array.form == VtkForm::kText) {
    // TextVoxels writes numbers in this machine's order.
    order = std::endian::native;
    segment.store =
        std::make_shared<DecodedFile>(std::vector<EncodedFile>{{.file = file,
                                                                .offset_bytes = array.offset,
                                                                .keep_bytes = bytes,
                                                                .end_bytes = array.end}},
                                      Codec::kText, layout.type, sizeArithmetic(layout, 0), decode);
  } else {
    const VtkBytes found = openVtkBytes(file, image, array, bytes);
    segment = {found.store, found.offset};
  }
  const std::string identity =
      fmt::format("{}|array {} of {}", file->identity(), choice.channel, array.is_of_cells);
  return std::make_unique<VtkSource>(std::move(layout), order, std::move(segment), identity,
                                     std::move(names));
}

}  // namespace sluice
