#include "io/synth/synth_source.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "io/synth/mean_levels.h"
#include "io/synth/synth_fields.h"
#include "src/base/error.h"
#include "src/base/sources/region_check.h"

namespace sluice {
namespace {

struct KindEntry {
  SynthKind kind;
  std::string_view name, description;
  std::unique_ptr<SynthField> (*make)(const SynthOptions&);
  int64_t most_steps = 1;
};
constexpr std::array<KindEntry, 10> kKinds = {{
    {SynthKind::kPhantom, "phantom", "the 3D Shepp-Logan head with fine texture", makePhantomField},
    {SynthKind::kShells, "shells", "five nested spherical shells", makeShellsField},
    {SynthKind::kMarschnerLobb, "marschner-lobb", "the test signal of Marschner and Lobb",
     makeMarschnerLobbField},
    {SynthKind::kNoise, "noise", "clouds of noise over a threshold", makeNoiseField},
    {SynthKind::kSparse, "sparse", "scattered balls of 31 voxels", makeSparseField},
    {SynthKind::kSlab, "slab", "a textured slab across the middle of z", makeSlabField},
    {SynthKind::kFlow, "flow", "vortex rings in a flow, varying with time", makeFlowField,
     kMaxSynthSteps},
    {SynthKind::kMixing, "mixing", "two gases mixing across a layer, varying with time",
     makeMixingField, kMaxSynthSteps},
    {SynthKind::kCube, "cube", "one value everywhere", makeCubeField},
    {SynthKind::kParts, "parts", "the parts of the phantom as labels, 1 to 10", makePartsField},
}};
constexpr std::array<SynthKind, kKinds.size()> kKindList = [] {
  std::array<SynthKind, kKinds.size()> list{};
  for (size_t i = 0; i < list.size(); ++i) list[i] = kKinds[i].kind;
  return list;
}();

// Raised when a kind's voxels change, so that data computed from older ones is rejected.
constexpr int kRevision = 3;

const KindEntry& entryOf(SynthKind kind) {
  return kKinds[static_cast<size_t>(kind)];
}

std::string kindNames() {
  std::string names;
  for (const KindEntry& entry : kKinds) {
    if (!names.empty()) names += ", ";
    names += entry.name;
  }
  return names;
}

template <class T>
bool parseNumber(std::string_view text, T& number) {
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), number);
  return status == std::errc() && end == text.data() + text.size();
}

// "AxBxC".
template <class T>
bool parseTriple(std::string_view text, Vec3<T>& triple) {
  for (int a = 0; a < 3; ++a) {
    const size_t end = a < 2 ? text.find('x') : text.size();
    if (end == std::string_view::npos || !parseNumber(text.substr(0, end), triple[a])) return false;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return text.empty();
}

// True when the field is known and well-formed.
bool setField(SynthOptions& options, std::string_view field, std::string_view value) {
  if (field == "dims") return parseTriple(value, options.dims);
  if (field == "spacing") return parseTriple(value, options.spacing);
  if (field == "steps") return parseNumber(value, options.time_steps);
  if (field == "levels") return parseNumber(value, options.levels);
  if (field == "seed") return parseNumber(value, options.seed);
  if (field == "share") return parseNumber(value, options.object_share);
  if (field == "type") {
    const std::optional<VoxelType> type = parseVoxelType(value);
    if (type) options.type = *type;
    return type.has_value();
  }
  return false;
}

void validate(const SynthOptions& options) {
  const std::string spec = specOf(options);
  if (!isCountable(options.dims))
    fail("{}: expected dims of at least 1 and at most 2^59 voxels together", spec);
  for (int a = 0; a < 3; ++a)
    if (!(options.spacing[a] > 0 && std::isfinite(options.spacing[a])))
      fail("{}: expected a spacing above 0", spec);
  if (options.type != VoxelType::kU8 && options.type != VoxelType::kU16 &&
      options.type != VoxelType::kF32)
    fail("{}: expected a type of u8, u16 or f32, found {}", spec, name(options.type));
  if (options.kind == SynthKind::kParts && options.type == VoxelType::kF32)
    fail("{}: expected a type of u8 or u16 for labels, found f32", spec);
  if (options.kind == SynthKind::kParts && options.levels > 1)
    fail(
        "{}: expected 1 level, since labels have no means, found {}; sluice pack --downsample mode "
        "makes levels of labels",
        spec, options.levels);
  const int64_t most_steps = entryOf(options.kind).most_steps;
  if (options.time_steps < 1 || options.time_steps > most_steps)
    fail("{}: expected 1 to {} time steps of {}, found {}", spec, most_steps, name(options.kind),
         options.time_steps);
  if (volume(options.dims) > kMostVolumeVoxels / options.time_steps)
    fail("{}: expected at most 2^59 voxels in all time steps together", spec);
  constexpr int64_t kMostLevels = 32;
  if (options.levels < 1 || options.levels > kMostLevels)
    fail("{}: expected 1 to {} levels, found {}", spec, kMostLevels, options.levels);
  const double most_share = options.kind == SynthKind::kSparse ? 0.4 : 1;
  if (!(options.object_share > 0 && options.object_share <= most_share))
    fail("{}: expected a share above 0 and up to {} for {}, found {}", spec, most_share,
         name(options.kind), options.object_share);
}

// The type's value of 1; a shift by half makes the cast round.
template <class T>
constexpr std::pair<float, float> scaleAndRounding() {
  if constexpr (std::is_floating_point_v<T>) return {1.0F, 0.0F};
  return {static_cast<float>(std::numeric_limits<T>::max()), 0.5F};
}

template <class T>
void convertRow(std::span<const float> row, std::byte* out) {
  constexpr auto kScale = scaleAndRounding<T>();
  for (size_t i = 0; i < row.size(); ++i) {
    const auto voxel = static_cast<T>(row[i] * kScale.first + kScale.second);
    std::memcpy(out + i * sizeof(T), &voxel, sizeof(T));
  }
}

// The voxels are the same however many levels stand above them.
std::string identityOf(SynthOptions options) {
  options.levels = 1;
  return fmt::format("{},revision={}", specOf(options), kRevision);
}

class SynthSource : public VolumeSource, public LeveledSource {
 public:
  explicit SynthSource(const SynthOptions& options)
      : field_(entryOf(options.kind).make(options)), identity_(identityOf(options)) {
    layout_.dims = options.dims;
    layout_.type = options.type;
    layout_.spacing = options.spacing;
    layout_.time_steps = options.time_steps;
    layout_.name = name(options.kind);
    if (options.kind == SynthKind::kPhantom) layout_.frame = WorldFrame::kRas;  // it is a head
    convert_row_ = options.type == VoxelType::kU8    ? convertRow<uint8_t>
                   : options.type == VoxelType::kU16 ? convertRow<uint16_t>
                                                     : convertRow<float>;
    layout_.levels = options.levels;
    levels_.emplace(*this, options.levels, Spreads::kKept);
  }

  const VolumeLayout& layout() const override { return layout_; }
  std::string identity() const override { return identity_; }
  uint64_t storedBytesRead() const override { return 0; }
  std::span<const CoarserLevel> levelsAbove() const override { return levels_->levels(); }

  std::optional<Occupancy> occupancy(int64_t) override {
    const Box3 box = field_->objectBox();
    if (box == boxOf(layout_.dims)) return std::nullopt;
    Occupancy occupancy;
    if (!box.empty()) occupancy.boxes.push_back(box);
    return occupancy;
  }

  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override {
    const size_t voxel_bytes = bytesPerVoxel(layout_.type);
    checkRegion(layout_, time, box, out);
    std::vector<float> row(static_cast<size_t>(box.size().x));
    const size_t row_bytes = row.size() * voxel_bytes;
    std::byte* to = out.data();
    for (int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (int64_t y = box.lo.y; y < box.hi.y; ++y, to += row_bytes) {
        if (field_->fillRow(time, y, z, box.lo.x, row))
          convert_row_(row, to);
        else
          std::memset(to, 0, row_bytes);
      }
  }

 private:
  const std::unique_ptr<SynthField> field_;
  const std::string identity_;
  VolumeLayout layout_;  // constant after construction
  void (*convert_row_)(std::span<const float>, std::byte*) = nullptr;  // constant too
  std::optional<MeanLevels> levels_;                                   // constant too
};

}  // namespace

std::span<const SynthKind> synthKinds() {
  return kKindList;
}

std::string_view name(SynthKind kind) {
  return entryOf(kind).name;
}

std::string_view descriptionOf(SynthKind kind) {
  return entryOf(kind).description;
}

std::optional<SynthKind> parseSynthKind(std::string_view text) {
  for (const KindEntry& entry : kKinds)
    if (entry.name == text) return entry.kind;
  return std::nullopt;
}

SynthOptions parseSynthSpec(std::string_view spec) {
  std::string_view rest = spec;
  if (isSynthSpec(rest)) rest.remove_prefix(kSynthPrefix.size());
  SynthOptions options;
  for (bool first = true; first || !rest.empty(); first = false) {
    const std::string_view part = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(part.size() + 1, rest.size()));
    if (first) {
      const std::optional<SynthKind> kind = parseSynthKind(part);
      if (!kind) fail("{}: expected a kind of volume ({}), found '{}'", spec, kindNames(), part);
      options.kind = *kind;
      continue;
    }
    const size_t equals = std::min(part.find('='), part.size());
    if (equals == part.size() ||
        !setField(options, part.substr(0, equals), part.substr(equals + 1)))
      fail(
          "{}: expected dims=XxYxZ, type=u8|u16|f32, steps=N, seed=N, share=S, spacing=XxYxZ or "
          "levels=N, found '{}'",
          spec, part);
  }
  validate(options);
  return options;
}

std::string specOf(const SynthOptions& options) {
  const Vec3i d = options.dims;
  const Vec3d s = options.spacing;
  std::string spec =
      fmt::format("{}{},dims={}x{}x{},type={},steps={},seed={},share={},spacing={}x{}x{}",
                  kSynthPrefix, name(options.kind), d.x, d.y, d.z, name(options.type),
                  options.time_steps, options.seed, options.object_share, s.x, s.y, s.z);
  if (options.levels > 1) spec += fmt::format(",levels={}", options.levels);
  return spec;
}

std::unique_ptr<VolumeSource> openSynth(const SynthOptions& options) {
  validate(options);
  return std::make_unique<SynthSource>(options);
}

}  // namespace sluice
