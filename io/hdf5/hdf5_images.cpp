#include "io/hdf5/hdf5_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <optional>
#include <utility>

#include "io/files/length_unit.h"
#include "io/hdf5/bdv_xml.h"
#include "io/headers/header_fields.h"
#include "io/stores/folder_store.h"
#include "io/zarr/n5/n5_volume.h"
#include "io/zarr/reading/stacked_array.h"
#include "src/base/error.h"
#include "src/base/files/json_field.h"

namespace sluice {
namespace {

constexpr size_t kMostLevels = 64;
constexpr int64_t kMostParts = 1'000'000;  // time steps, channels

// An image as both formats have it.
struct Stack {
  std::string name, title;
  int64_t times = 1, channels = 1;
  std::vector<std::string> channel_names;
  struct Level {
    Vec3d factor{1, 1, 1};         // finest voxels along x, y and z
    std::vector<int64_t> extents;  // along z, y and x; empty: the array's
  };
  std::vector<Level> levels;
  std::array<Vec3d, 3> steps{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // world, along x, y and z
  Vec3d origin;                                                   // of the finest first voxel
  std::string unit;
  std::vector<std::string> places, identities, notes;
  // Null: there is no such array.
  std::function<std::unique_ptr<ChunkedArray>(size_t level, int64_t time, int64_t channel)> open;
};

// The channel whose arrays tell the shape; others may differ.
int64_t channelOf(const Stack& stack, const ChannelWish& wish) {
  if (wish.number) return std::clamp<int64_t>(*wish.number, 0, stack.channels - 1);
  const auto& names = stack.channel_names;
  const auto at = std::find(names.begin(), names.end(), wish.name);
  return wish.name.empty() || at == names.end() ? 0 : at - names.begin();
}

std::unique_ptr<VolumeSource> openStack(Stack stack, const ChunkedOptions& options) {
  ChunkedVolume volume;
  volume.name = volume.said_by = stack.name;
  volume.title = stack.title;
  volume.is_image = true;
  volume.places = stack.places;
  volume.identities = stack.identities;
  volume.notes = stack.notes;
  ZarrImage& image = volume.image;
  image.axes = {{"t", "time", ""},
                {"c", "channel", ""},
                {"z", "space", stack.unit},
                {"y", "space", stack.unit},
                {"x", "space", stack.unit}};
  image.channels = stack.channel_names;
  image.frame = WorldFrame::kPictureRows;
  std::array<Vec3d, 3> directions;
  Vec3d spacing;
  for (int a = 0; a < 3; ++a) {
    const Vec3d step = stack.steps[static_cast<size_t>(a)];
    spacing[a] = std::hypot(step.x, step.y, step.z);
    if (!(spacing[a] > 0) || !std::isfinite(spacing[a]))
      fail("{}: expected steps between voxels that are not 0, found ({}, {}, {})", stack.name,
           step.x, step.y, step.z);
    directions[static_cast<size_t>(a)] = step / spacing[a];
  }
  if (directions != std::array<Vec3d, 3>{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}})
    image.directions = directions;
  for (size_t i = 0; i < stack.levels.size(); ++i) {
    const Vec3d factor = stack.levels[i].factor;
    image.levels.push_back(std::to_string(i));
    ZarrPlace& place = image.places.emplace_back();
    place.scale = {1, 1};
    place.translation = {0, 0};
    place.is_translated = true;
    for (int a = 2; a >= 0; --a) {
      place.scale.push_back(spacing[a] * factor[a]);
      // The middle of a coarse voxel lies between those of the finest ones that it covers.
      place.translation.push_back(stack.origin[a] + spacing[a] * (factor[a] - 1) / 2);
    }
  }
  image.scale = image.places[0].scale;
  image.translation = image.places[0].translation;
  const int64_t channel = channelOf(stack, options.channel);
  volume.open = [stack, channel](size_t level) {
    OpenedArray opened;
    opened.array = std::make_unique<StackedArray>(
        stack.times, stack.channels, channel, stack.levels[level].extents,
        [open = stack.open, level](int64_t time, int64_t of) { return open(level, time, of); },
        stack.name);
    return opened;
  };
  return std::make_unique<ChunkedSource>(std::move(volume), options);
}

std::unique_ptr<ChunkedArray> openArrayOf(const Hdf5Input& input, const std::string& path,
                                          bool are_unsigned) {
  const std::string name = input.file->path() + ":" + path;
  std::unique_ptr<Hdf5Set> set = input.inside->open(path);
  ZarrArray array = hdf5ArrayOf(set->description(), name);
  // BigDataViewer stores unsigned 16-bit voxels as signed ones.
  if (are_unsigned && array.type == VoxelType::kI16) array.type = VoxelType::kU16;
  return hdf5Chunks(input, std::move(set), std::move(array), name);
}

// How many there are of what a name is made for, from 0 on.
int64_t countOf(Hdf5File& file, const std::function<std::string(int64_t)>& name) {
  int64_t count = 0;
  while (count < kMostParts && file.has(name(count))) ++count;
  return count;
}

// Imaris writes texts as arrays of single letters.
std::string textOf(const std::vector<Hdf5Attribute>& attributes, std::string_view name) {
  const Hdf5Attribute* const found = find(attributes, name);
  std::string text;
  if (found != nullptr)
    for (const std::string& letter : found->texts) text += letter;
  return text;
}

double numberOf(const std::vector<Hdf5Attribute>& attributes, const std::string& name,
                const std::string& path) {
  const std::string text = textOf(attributes, name);
  const auto number = parseReal(trimmed(text));
  if (!number || !std::isfinite(*number))
    fail("{}: expected a number as {}, found {}", path, name, inQuotes(text));
  return *number;
}

std::unique_ptr<VolumeSource> openImaris(const Hdf5Input& input, const std::string& path,
                                         const ChunkedOptions& options) {
  const auto levelName = [](int64_t level) {
    return fmt::format("/DataSet/ResolutionLevel {}", level);
  };
  const auto partName = [levelName](int64_t level, int64_t time, int64_t channel) {
    return fmt::format("{}/TimePoint {}/Channel {}", levelName(level), time, channel);
  };
  Hdf5File& file = *input.inside;
  Stack stack;
  stack.name = path;
  stack.title = std::filesystem::path(path).filename().string();
  stack.places = {path};
  stack.identities = {"imaris"};
  stack.times = countOf(
      file, [&](int64_t time) { return fmt::format("{}/TimePoint {}", levelName(0), time); });
  stack.channels = countOf(file, [&](int64_t channel) { return partName(0, 0, channel); });
  if (stack.times == 0 || stack.channels == 0)
    fail("{}: expected {} of an Imaris image, found none", path, partName(0, 0, 0));
  for (int64_t channel = 0; channel < stack.channels; ++channel)
    stack.channel_names.push_back(printable(
        textOf(file.attributes(fmt::format("/DataSetInfo/Channel {}", channel)), "Name")));
  const std::vector<Hdf5Attribute> info = file.attributes("/DataSetInfo/Image");
  stack.unit = lengthUnit(textOf(info, "Unit"));
  constexpr const char* kSizes[] = {"ImageSizeX", "ImageSizeY", "ImageSizeZ"};
  const int64_t levels = std::min<int64_t>(countOf(file, levelName), kMostLevels);
  for (int64_t level = 0; level < levels; ++level) {
    // Channels may differ in size.
    const std::string name = partName(level, 0, channelOf(stack, options.channel));
    const std::vector<Hdf5Attribute> attributes = file.attributes(name);
    Stack::Level& made = stack.levels.emplace_back();
    Vec3d size;
    for (int a = 2; a >= 0; --a) {
      size[a] = numberOf(attributes, kSizes[a], fmt::format("{}:{}", path, name));
      // Chunks of Imaris reach beyond the image, whose size is in the attributes.
      made.extents.push_back(static_cast<int64_t>(std::clamp(size[a], 0.0, 1e15)));
    }
    const Stack::Level& finest = stack.levels[0];
    for (int a = 0; a < 3; ++a)
      made.factor[a] =
          static_cast<double>(finest.extents[static_cast<size_t>(2 - a)]) / std::max(1.0, size[a]);
  }
  // The extent is the image's, so that all channels have voxels of one size.
  const std::vector<Hdf5Attribute> of_first = file.attributes(partName(0, 0, 0));
  for (int a = 0; a < 3; ++a) {
    const double lo = numberOf(info, fmt::format("ExtMin{}", a), path);
    const double hi = numberOf(info, fmt::format("ExtMax{}", a), path);
    const double step = (hi - lo) / std::max(1.0, numberOf(of_first, kSizes[a], path));
    stack.steps[static_cast<size_t>(a)] = Vec3d{};
    stack.steps[static_cast<size_t>(a)][a] = step;
    stack.origin[a] = lo + step / 2;
  }
  stack.open = [input, partName](size_t level, int64_t time, int64_t channel) {
    return openArrayOf(input, partName(static_cast<int64_t>(level), time, channel) + "/Data",
                       false);
  };
  return openStack(std::move(stack), options);
}

std::string bdvName(int64_t time, int64_t setup, size_t level) {
  return fmt::format("/t{:05}/s{:02}/{}/cells", time, setup, level);
}

// Rows of three numbers.
std::vector<Vec3d> factorsIn(const Hdf5Input& input, const std::string& path) {
  const std::unique_ptr<Hdf5Set> set = input.inside->open(path);
  const Hdf5Description& description = set->description();
  const std::vector<int64_t>& shape = description.shape;
  if (shape.size() != 2 || shape[0] < 1 || shape[0] > static_cast<int64_t>(kMostLevels) ||
      shape[1] != 3 || description.byte_order != std::endian::native)
    fail("{}:{}: expected factors of 1 to {} levels, 3 each, found another shape",
         input.file->path(), path, kMostLevels);
  std::vector<Vec3d> factors(static_cast<size_t>(shape[0]));
  visitVoxelType(description.type, [&](auto tag) {
    std::vector<decltype(tag)> numbers(3 * factors.size());
    set->readBox(std::array<int64_t, 2>{0, 0}, shape, std::as_writable_bytes(std::span(numbers)));
    for (size_t i = 0; i < numbers.size(); ++i)
      factors[i / 3][static_cast<int>(i % 3)] = static_cast<double>(numbers[i]);
  });
  for (const Vec3d& factor : factors)
    for (int a = 0; a < 3; ++a)
      if (!(factor[a] >= 1 && factor[a] <= 1e9))
        fail("{}:{}: expected factors of 1 or more, found {}", input.file->path(), path, factor[a]);
  return factors;
}

// Fills in levels and arrays of an .h5. `setups`: by channel.
void useBdvHdf5(const Hdf5Input& input, const std::vector<int64_t>& times,
                const std::vector<int64_t>& setups, int64_t channel, Stack& stack) {
  for (const Vec3d& factor :
       factorsIn(input, fmt::format("/s{:02}/resolutions", setups[static_cast<size_t>(channel)])))
    stack.levels.push_back({.factor = factor, .extents = {}});
  stack.open = [input, times, setups](size_t level, int64_t time, int64_t of) {
    const std::string name =
        bdvName(times[static_cast<size_t>(time)], setups[static_cast<size_t>(of)], level);
    return openArrayOf(input, name, true);
  };
}

// Leaves out views that the .xml calls missing, whatever is stored of them. `setups`: by channel.
void leaveOutMissing(const BdvImage& image, const std::vector<int64_t>& setups, Stack& stack) {
  if (image.missing_views.empty()) return;
  stack.open = [views = image.missing_views, times = image.times, setups, open = stack.open](
                   size_t level, int64_t time, int64_t of) -> std::unique_ptr<ChunkedArray> {
    if (views.contains({times[static_cast<size_t>(time)], setups[static_cast<size_t>(of)]}))
      return nullptr;
    return open(level, time, of);
  };
}

// The number of the first time point with a view of a set-up. Adds a note if others have none.
// Throws Error: none has.
int64_t firstViewOf(const BdvImage& image, int64_t setup, Stack& stack) {
  constexpr size_t kMostNumbers = 8;
  std::vector<std::string> missing;
  std::optional<int64_t> first;
  int64_t more = 0;
  for (size_t i = 0; i < image.times.size(); ++i) {
    if (!image.missing_views.contains({image.times[i], setup}))
      first = first.value_or(static_cast<int64_t>(i));
    else if (missing.size() < kMostNumbers)
      missing.push_back(std::to_string(image.times[i]));
    else
      ++more;
  }
  if (!first)
    fail(
        "{}: set-up {} has no view at any time point (MissingViews); choose another one with "
        "--channel",
        stack.name, setup);
  if (more > 0) missing.push_back(fmt::format("{} more", more));
  if (!missing.empty())
    stack.notes.push_back(fmt::format(
        "{}: set-up {} has no view at the time point{} {} (MissingViews) and is empty there",
        stack.name, setup, missing.size() > 1 ? "s" : "", fmt::join(missing, ", ")));
  return *first;
}

}  // namespace

std::unique_ptr<VolumeSource> openHdf5Image(const Hdf5Input& input, const std::string& path,
                                            const ChunkedOptions& options) {
  Hdf5File& file = *input.inside;
  if (file.has("/DataSet/ResolutionLevel 0")) return openImaris(input, path, options);
  if (!file.has(bdvName(0, 0, 0)) || !file.has("/s00/resolutions")) return nullptr;
  Stack stack;
  stack.name = path;
  stack.title = std::filesystem::path(path).filename().string();
  stack.places = {path};
  stack.identities = {"bdv"};
  stack.times = countOf(file, [](int64_t time) { return bdvName(time, 0, 0); });
  stack.channels = countOf(file, [](int64_t setup) { return bdvName(0, setup, 0); });
  std::vector<int64_t> times, setups;
  for (int64_t i = 0; i < stack.times; ++i) times.push_back(i);
  for (int64_t i = 0; i < stack.channels; ++i) setups.push_back(i);
  useBdvHdf5(input, times, setups, channelOf(stack, options.channel), stack);
  return openStack(std::move(stack), options);
}

std::unique_ptr<VolumeSource> openBdvXml(const std::string& path, const ChunkedOptions& options) {
  File xml{std::filesystem::path(path)};
  const BdvImage image = parseBdvXml(
      [&xml](uint64_t offset, std::span<std::byte> out) { return xml.readSome(offset, out); },
      path);
  const std::string data = (std::filesystem::path(path).parent_path() / image.data).string();
  Stack stack;
  stack.name = path;
  stack.title = std::filesystem::path(path).filename().string();
  stack.places = {path, data};
  stack.identities = {xml.identity()};
  stack.times = static_cast<int64_t>(image.times.size());
  stack.channels = static_cast<int64_t>(image.setups.size());
  std::vector<int64_t> setups;
  for (const BdvSetup& setup : image.setups) {
    setups.push_back(setup.id);
    stack.channel_names.push_back(printable(setup.name, kLongestName));
  }
  const int64_t channel = channelOf(stack, options.channel);
  const BdvSetup& setup = image.setups[static_cast<size_t>(channel)];
  if (setup.has_moved)
    stack.notes.push_back(fmt::format(
        "{}: set-up {} lies elsewhere at other time points; it is shown in its first place", path,
        setup.id));
  const int64_t first_view = firstViewOf(image, setup.id, stack);
  const BdvAffine& w = setup.world;
  // The columns of the affine matrix.
  for (size_t a = 0; a < 3; ++a) stack.steps[a] = {w[a], w[4 + a], w[8 + a]};
  stack.origin = {w[3], w[7], w[11]};
  stack.unit = setup.unit;
  if (image.format == "bdv.hdf5") {
    useBdvHdf5(openHdf5Input(data), image.times, setups, channel, stack);
    leaveOutMissing(image, setups, stack);
    return openStack(std::move(stack), options);
  }
  const StorePlace root = folderPlace(data);
  const auto placeOf = [root, times = image.times, setups](int64_t time, int64_t of) {
    return root.at(fmt::format("setup{}/timepoint{}", setups[static_cast<size_t>(of)],
                               times[static_cast<size_t>(time)]));
  };
  for (const Vec3d& factor :
       n5Factors(root.at(fmt::format("setup{}", setup.id)), placeOf(first_view, channel)))
    stack.levels.push_back({.factor = factor, .extents = {}});
  stack.open = [placeOf](size_t level, int64_t time, int64_t of) {
    return openN5Array(placeOf(time, of).at(fmt::format("s{}", level))).array;
  };
  leaveOutMissing(image, setups, stack);
  return openStack(std::move(stack), options);
}

}  // namespace sluice
