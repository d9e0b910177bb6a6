#include "io/hdf5/hdf5_volume.h"

#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "io/files/missing_values.h"
#include "io/hdf5/hdf5_axes.h"
#include "io/hdf5/hdf5_images.h"
#include "io/hdf5/hdf5_input.h"
#include "io/headers/raw/raw_source.h"
#include "io/headers/volume_description.h"
#include "src/base/error.h"
#include "src/base/files/json_field.h"

namespace sluice {
namespace {

constexpr size_t kSpace = 3, kMostListed = 12;

VoxelType unsignedOf(VoxelType type) {
  switch (type) {
    case VoxelType::kI8:
      return VoxelType::kU8;
    case VoxelType::kI16:
      return VoxelType::kU16;
    case VoxelType::kI32:
      return VoxelType::kU32;
    default:
      return type;
  }
}

// Tells apart indices of volumes whose axes are taken differently.
std::string axesText(const ZarrImage& image) {
  std::string text;
  for (const ZarrAxis& axis : image.axes)
    text += fmt::format("{}{}", text.empty() ? "axes " : ",",
                        printable(axis.name + (axis.type.empty() ? "" : " " + axis.type)));
  return text;
}

// Voxels in one piece with x fastest, read where they lie; null: they are not.
std::unique_ptr<VolumeSource> inPlace(const std::shared_ptr<File>& file,
                                      const Hdf5Description& description, const ZarrArray& array,
                                      const ZarrView& view, VolumeLayout layout,
                                      const std::string& identity) {
  const size_t axes = array.axes();
  const bool is_in_order =
      view.space[0] == axes - 1 && view.space[1] == axes - 2 && view.space[2] == axes - 3;
  if (!description.in_place_at || !is_in_order) return nullptr;
  const int64_t voxels = volume(layout.dims);
  const auto bytes = static_cast<int64_t>(bytesPerVoxel(layout.type));
  const auto strideOf = [&](std::optional<size_t> axis) {
    int64_t stride = voxels;
    for (size_t a = axes - kSpace; axis && a-- > *axis + 1;) stride *= array.shape[a];
    return stride;
  };
  std::vector<RawSegment> segments;
  for (int64_t t = 0; t < layout.time_steps; ++t) {
    const int64_t first = t * strideOf(view.time) + layout.channel * strideOf(view.channel);
    const uint64_t at = *description.in_place_at + static_cast<uint64_t>(first * bytes);
    if (at > file->sizeBytes() || static_cast<uint64_t>(voxels * bytes) > file->sizeBytes() - at)
      fail("{}: expected voxels up to byte {}, found {} bytes; it was cut short", file->path(),
           at + static_cast<uint64_t>(voxels * bytes), file->sizeBytes());
    segments.push_back({file, at});
  }
  return std::make_unique<RawSource>(std::move(layout), description.byte_order, std::move(segments),
                                     nullptr, identity);
}

std::string listed(const std::vector<Hdf5Entry>& sets) {
  std::vector<std::string> names;
  for (const Hdf5Entry& set : sets) {
    if (names.size() == kMostListed) {
      names.push_back("...");
      break;
    }
    names.push_back(fmt::format("{} ({})", printable(set.path, 200), fmt::join(set.shape, " x ")));
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

// The one data set of three axes or more.
std::string onlySet(Hdf5File& file, const std::string& path) {
  constexpr size_t kMostSets = 1000;
  std::vector<Hdf5Entry> sets = file.sets(kMostSets);
  std::vector<Hdf5Entry> volumes;
  for (const Hdf5Entry& set : sets)
    if (set.shape.size() >= kSpace) volumes.push_back(set);
  if (volumes.size() == 1) return volumes[0].path;
  if (sets.empty()) fail("{}: expected a data set of three axes or more, found none", path);
  if (volumes.empty())
    fail(
        "{}: expected a data set of three axes or more, found {}; name one of two axes to open it "
        "as a volume of one slice, as {}:{}",
        path, listed(sets), path, sets[0].path);
  fail("{}: expected the path of one of its data sets after the name, as {}:{}; found {}: {}", path,
       path, volumes[0].path, volumes.size() == kMostSets ? "many" : std::to_string(volumes.size()),
       listed(volumes));
}

}  // namespace

std::unique_ptr<VolumeSource> openHdf5(const std::string& path, const std::string& set,
                                       const ChunkedOptions& options) {
  const Hdf5Input input = openHdf5Input(path);
  if (set.empty())
    if (auto image = openHdf5Image(input, path, options)) return image;
  const std::string set_path = set.empty() ? onlySet(*input.inside, path) : set;
  const std::string name = path + ":" + set_path;
  std::unique_ptr<Hdf5Set> opened = input.inside->open(set_path);
  const Hdf5Description& description = opened->description();
  ZarrArray array = hdf5ArrayOf(description, name);
  const Hdf5Image found = hdf5ImageOf(description, array.axes(), options.channel.given(), name);
  if (found.is_unsigned) array.type = unsignedOf(array.type);
  ChunkedVolume volume;
  volume.name = volume.said_by = name;
  volume.title = std::filesystem::path(set_path).filename().string();
  volume.image = found.image;
  volume.notes = found.notes;
  volume.identities = {fmt::format("hdf5 {}|{}", set_path, axesText(volume.image))};
  volume.places = {path};

  ZarrView view = viewZarr(array, volume.image, options.channel.given(), name);
  // Contiguous voxels are read where they lie, without chunks in memory and by any number of
  // threads.
  const bool is_as_stored = blankedNumbers(array.type, volume.image.missing).empty();
  if (is_as_stored && (view.channel || !options.channel.given())) {
    VolumeLayout layout = view.layout;
    layout.name = volume.title;
    layout.path = volume.name;
    layout.notes = volume.notes;
    if (const std::string note = missingValuesNote(volume.image.missing, layout); !note.empty())
      layout.notes.push_back(name + ": " + note);
    if (const std::string note =
            invalidValuesNote(volume.image.valid_least, volume.image.valid_greatest, layout);
        !note.empty())
      layout.notes.push_back(name + ": " + note);
    chooseChannel(name, options.channel, {}, layout);
    std::string identity = fmt::format("{}|hdf5 {}|{}|channel {}", input.file->identity(), set_path,
                                       axesText(volume.image), layout.channel);
    if (auto source = inPlace(input.file, description, array, view, std::move(layout), identity))
      return source;
  }
  // Opened once: the only level.
  auto shared = std::make_shared<std::unique_ptr<Hdf5Set>>(std::move(opened));
  volume.open = [input, shared, name, array](size_t) {
    OpenedArray made;
    made.array = hdf5Chunks(input, std::move(*shared), array, name);
    return made;
  };
  return std::make_unique<ChunkedSource>(std::move(volume), options);
}

}  // namespace sluice
