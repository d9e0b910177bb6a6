#include "tools/options.h"

#include <bit>

#include "src/base/bytes.h"
#include "src/classify/color_maps.h"
#include "tools/parse.h"

namespace sluice {
namespace {

auto numbers(size_t count) {
  return [count](const std::string& word) { return parseNumbers(word, count); };
}

std::optional<double> positive(const std::string& word) {
  const auto number = parseNumbers(word, 1);
  if (!number || !(number->front() > 0)) return std::nullopt;
  return number->front();
}

std::optional<double> unitShare(const std::string& word) {
  const auto number = parseNumbers(word, 1);
  if (!number || number->front() < 0 || number->front() > 1) return std::nullopt;
  return number->front();
}

std::optional<std::vector<double>> dimensions(const std::string& word) {
  auto found = parseNumbers(word, 3);
  if (!found) found = parseNumbers(word, 4);
  if (!found) return std::nullopt;
  for (const double n : *found)
    if (n < 1 || n > 9e15 || n != static_cast<double>(static_cast<int64_t>(n))) return std::nullopt;
  return found;
}

std::optional<std::endian> byteOrder(const std::string& word) {
  if (word == "little") return std::endian::little;
  if (word == "big") return std::endian::big;
  return std::nullopt;
}

std::optional<Mode> modeOf(const std::string& word) {
  if (word == "composite") return Mode::kComposite;
  if (word == "mip") return Mode::kMip;
  if (word == "minip") return Mode::kMinip;
  if (word == "average") return Mode::kAverage;
  return std::nullopt;
}

std::optional<Projection> projectionOf(const std::string& word) {
  if (word == "ortho") return Projection::kOrtho;
  if (word == "perspective") return Projection::kPerspective;
  return std::nullopt;
}

std::optional<Partition> parsePartition(const std::string& word) {
  if (word == "blocks") return Partition::kBlocks;
  if (word == "boxes") return Partition::kBoxes;
  return std::nullopt;
}

std::optional<double> positiveShare(const std::string& word) {
  const auto share = unitShare(word);
  return share && *share > 0 ? share : std::nullopt;
}

std::optional<Occlusion> parseOcclusion(const std::string& word) {
  if (word == "off") return Occlusion::kOff;
  if (word == "map") return Occlusion::kMap;
  if (word == "cull") return Occlusion::kCull;
  if (word == "clip") return Occlusion::kClip;
  return std::nullopt;
}

std::optional<int64_t> powerOfTwo(const std::string& word) {
  const auto number = parseNumbers(word, 1);
  if (!number || number->front() < 1 || number->front() > 1e15) return std::nullopt;
  const auto value = static_cast<int64_t>(number->front());
  if (static_cast<double>(value) != number->front() ||
      !std::has_single_bit(static_cast<uint64_t>(value)))
    return std::nullopt;
  return value;
}

std::optional<int64_t> blockSize(const std::string& word) {
  const auto size = powerOfTwo(word);
  if (!size || *size < 4 || *size > 1024) return std::nullopt;
  return size;
}

// A spacing must be positive along each axis.
std::optional<std::vector<double>> spacings(const std::string& word) {
  auto found = parseNumbers(word, 3);
  if (!found) {
    const auto one = parseNumbers(word, 1);
    if (!one) return std::nullopt;
    found = std::vector<double>(3, one->front());
  }
  for (const double n : *found)
    if (!(n > 0)) return std::nullopt;
  return found;
}

std::optional<std::vector<double>> cropBox(const std::string& word) {
  auto found = parseNumbers(word, 6);
  if (!found) return std::nullopt;
  for (size_t a = 0; a < 3; ++a)
    if ((*found)[a] < 0 || (*found)[a + 3] <= (*found)[a]) return std::nullopt;
  return found;
}

std::string mapNames() {
  std::string names;
  for (const std::string_view name : colorMapNames())
    names += (names.empty() ? "" : ", ") + std::string(name);
  return names;
}

}  // namespace

void addVolumeOptions(CLI::App& app, VolumeArguments& arguments) {
  app.add_option(
         "volume", arguments.inputs,
         "Files, a folder of slices, a Zarr store, a pattern ('step_%03d.raw'), or synth:KIND,...")
      ->required()
      ->type_name("VOLUME");
  addParsed(app, "--dims", "Raw: voxels along each axis, and time steps", "X,Y,Z[,T]", dimensions,
            [&arguments](const std::vector<double>& n) {
              arguments.open.dims = asVec3i(n);
              if (n.size() == 4) arguments.open.time_steps = static_cast<int64_t>(n[3]);
            });
  addParsed(
      app, "--type", "Raw: voxel type", "u8|i8|u16|i16|u32|i32|f32|f64",
      [](const std::string& word) { return parseVoxelType(word); },
      [&arguments](VoxelType type) { arguments.open.type = type; });
  addParsed(app, "--endian", "Raw: byte order", "little|big", byteOrder,
            [&arguments](std::endian order) { arguments.open.byte_order = order; });
  app.add_option("--skip", arguments.open.skip_bytes, "Raw: bytes before the voxels")
      ->check(CLI::NonNegativeNumber)
      ->type_name("BYTES");
  addParsed(app, "--spacing", "World units between voxels, in place of the file's", "X,Y,Z",
            spacings,
            [&arguments](const std::vector<double>& n) { arguments.open.spacing = asVec3d(n); });
  app.add_option("--grid", arguments.open.grid, "OpenVDB: the grid's name")->type_name("NAME");
  app.add_option("--channel", arguments.open.channel, "Zarr: which channel, from 0 (the first)")
      ->check(CLI::NonNegativeNumber)
      ->type_name("N");
  app.add_option("--time", arguments.time, "Time step, from 0")
      ->check(CLI::NonNegativeNumber)
      ->type_name("STEP");
}

void addLookOptions(CLI::App& app, LookArguments& arguments) {
  CLI::Option* threshold = app.add_option("--threshold", arguments.threshold,
                                          "Opacity 0 below this value and a ramp above it")
                               ->type_name("VALUE");
  CLI::Option* transfer = app.add_option("--transfer", arguments.transfer_file,
                                         "Transfer function: our JSON or ParaView's colour map")
                              ->type_name("FILE");
  threshold->excludes(transfer);
  app.add_option("--map", arguments.map, "Colour map: " + mapNames())->type_name("NAME");
  addParsed(app, "--opacity", "Opacity of one voxel length at the top of the ramp (0.05)", "0..1",
            unitShare, [&arguments](double opacity) { arguments.opacity = opacity; });
  app.add_flag("--shade", arguments.shade, "Gradient Phong lighting");
  CLI::Option* modulate =
      app.add_flag("--modulate", arguments.modulate,
                   "Opacity times a ramp of the gradient's magnitude, 0 where the volume is flat");
  addParsed(app, "--full-gradient",
            "The magnitude at which --modulate leaves all of it, as a share of the value range a "
            "voxel length (0.1)",
            "SHARE", positive, [&arguments](double share) { arguments.full_gradient = share; })
      ->needs(modulate);
  addParsed(app, "--background", "Background colour; without it PNG keeps alpha", "RRGGBB",
            parseColor, [&arguments](const std::array<float, 3>& color) {
              arguments.background = color;
              arguments.has_background = true;
            });
}

void addViewOptions(CLI::App& app, FrameOptions& options) {
  addParsed(app, "--size", "Pixels (512x512)", "WxH", parsePictureSize,
            [&options](PictureSize size) { options.size = size; });
  addParsed(app, "--step", "Distance between slices in voxels of the finest spacing (1)", "VOXELS",
            positive, [&options](double step) { options.step_vox = step; });
  addParsed(app, "--projection", "How depth shows (ortho)", "ortho|perspective", projectionOf,
            [&options](Projection projection) { options.camera.projection = projection; });
  app.add_option("--azimuth", options.camera.azimuth_deg, "Turns the camera about +y")
      ->capture_default_str()
      ->type_name("DEGREES");
  app.add_option("--elevation", options.camera.elevation_deg, "Lifts the camera")
      ->capture_default_str()
      ->type_name("DEGREES");
  addParsed(app, "--zoom", "1 fits the volume's bounding sphere (1)", "FACTOR", positive,
            [&options](double zoom) { options.camera.zoom = zoom; });
  addParsed(app, "--fov", "Vertical field of view of a perspective camera (30)", "DEGREES",
            positive, [&options](double fov) { options.camera.field_of_view_deg = fov; });
  const auto look_at = [&options]() -> Camera::LookAt& {
    if (!options.camera.look_at) options.camera.look_at = Camera::LookAt{};
    return *options.camera.look_at;
  };
  CLI::Option* eye =
      addParsed(app, "--eye", "Camera position in the world", "X,Y,Z", numbers(3),
                [look_at](const std::vector<double>& n) { look_at().eye = asVec3d(n); });
  CLI::Option* target =
      addParsed(app, "--target", "World position looked at", "X,Y,Z", numbers(3),
                [look_at](const std::vector<double>& n) { look_at().target = asVec3d(n); });
  CLI::Option* up =
      addParsed(app, "--up", "Up direction (0,1,0)", "X,Y,Z", numbers(3),
                [look_at](const std::vector<double>& n) { look_at().up = asVec3d(n); });
  eye->needs(target);
  target->needs(eye);
  up->needs(eye);
  addParsed(app, "--mode", "How samples along a ray combine (composite)",
            "composite|mip|minip|average", modeOf, [&options](Mode mode) { options.mode = mode; });
  addParsed(app, "--crop",
            "Shows what lies between these voxel planes, the upper ones not included",
            "X0,Y0,Z0,X1,Y1,Z1", cropBox, [&options](const std::vector<double>& n) {
              options.crop = Box3{asVec3i(n), asVec3i({n[3], n[4], n[5]})};
            });
  addParsed(app, "--clip", "Shows world positions with a x + b y + c z <= d; up to 6 times",
            "A,B,C,D", numbers(4),
            [&options](const std::vector<double>& n) {
              if (options.clip_planes.size() == kMostClipPlanes)
                throw CLI::ValidationError("--clip", "at most 6 planes");
              options.clip_planes.push_back({asVec3d(n), n[3]});
            })
      ->trigger_on_parse();
  addParsed(
      app, "--algorithm", "What is loaded and drawn of each block (merged)",
      "conventional|clipped|trimmed|merged",
      [](const std::string& word) { return parseAlgorithm(word); },
      [&options](Algorithm algorithm) { options.algorithm = algorithm; });
  addParsed(
      app, "--merge", "Order of the merge operations (paper)", "paper|first-fit",
      [](const std::string& word) { return parseMergeOrder(word); },
      [&options](MergeOrder order) { options.merge_order = order; });
  addParsed(app, "--partition",
            "What is drawn of a block (blocks): its object box, or the visible ones of its growing "
            "boxes, "
            "which are made once for a volume and kept with its index",
            "blocks|boxes", parsePartition,
            [&options](Partition partition) { options.partition = partition; });
  addParsed(
      app, "--occlusion",
      "Leaves out what is hidden (off): map asks the opacity map and leaves out nothing, cull "
      "leaves out hidden boxes, clip the hidden parts of boxes too",
      "off|map|cull|clip", parseOcclusion,
      [&options](Occlusion occlusion) { options.occlusion = occlusion; });
  addParsed(app, "--opacity-threshold",
            "Opaque: rays end there and hide what is behind; 1 changes no picture (1, with "
            "--occlusion 0.95)",
            "above 0, up to 1", positiveShare,
            [&options](double threshold) { options.opacity_threshold = threshold; });
  app.add_option("--time-limit", options.time_limit_s,
                 "A frame leaves out what is not read by then, and says so (waits for all)")
      ->check(CLI::NonNegativeNumber)
      ->type_name("SECONDS");
}

void addResourceOptions(CLI::App& app, ResourceArguments& arguments) {
  addParsed(app, "--memory", "Budget of blocks, chunks and software textures (half the machine's)",
            "BYTES", parseBytes, [&arguments](uint64_t bytes) { arguments.memory_bytes = bytes; });
  app.add_option("--threads", arguments.threads, "Worker threads, 0 one a core")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024))
      ->type_name("N");
  addParsed(
      app, "--gl", "How to reach OpenGL (auto)", "auto|osmesa|egl",
      [](const std::string& word) { return parseGlChoice(word); },
      [&arguments](GlChoice choice) { arguments.gl = choice; });
  addParsed(
      app, "--page", "Texture page in voxels (the 64 KiB page of the voxel type)", "AxBxC",
      [](const std::string& word) { return parsePageSize(word); },
      [&arguments](Vec3i page) { arguments.page_vox = page; });
  addParsed(app, "--pages", "Pages of the texture cache, a power of two (what memory allows)", "N",
            powerOfTwo, [&arguments](int64_t pages) { arguments.pages = pages; });
  addParsed(app, "--block", "Voxels a side of a volume block, 4 to 1024 (the page's longest side)",
            "2^d", blockSize, [&arguments](int64_t block) { arguments.block = block; });
  addParsed(
      app, "--policy", "Replacement policy of the texture cache (lru)",
      "lru|fifo|clock|random|srrip|2q|arc|s3-fifo|sieve",
      [](const std::string& word) -> std::optional<PolicyKind> {
        const auto kind = parsePolicy(word);
        for (const PolicyKind online : onlinePolicies())
          if (kind == online) return kind;
        return std::nullopt;
      },
      [&arguments](PolicyKind kind) { arguments.policy = kind; });
  app.add_option("--seed", arguments.seed, "Of the random policy")->capture_default_str();
}

}  // namespace sluice
