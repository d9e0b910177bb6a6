#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "cache/model/page_geometry.h"
#include "tools/command_line/console.h"
#include "tools/options/shared_options.h"

namespace sluice {
namespace {

std::optional<int64_t> powerOfTwo(const std::string& word, int64_t least, int64_t most) {
  const auto number = parseIn<int64_t>(word, {least, most});
  if (!number || !std::has_single_bit(static_cast<uint64_t>(*number))) return std::nullopt;
  return number;
}

}  // namespace

std::optional<Vec3i> parsePageOption(const std::string& word) {
  const auto page = parsePageSize(word);
  // Without --block, the longest side of a page is that of a block.
  if (!page || std::max({page->x, page->y, page->z}) > kMostBlock) return std::nullopt;
  return page;
}

void addThreadsOption(const OptionGroup& group, int& threads) {
  group.number("-j,--threads", "N", threads, {0, kMostThreads}, "Worker threads; 0: one per core");
}

void addDeviceOptions(const OptionGroup& group, DeviceArguments& arguments) {
  group.choice(
      "--device",
      Words<DeviceChoice>{
          {"auto", DeviceChoice::kAuto}, {"gl", DeviceChoice::kGl}, {"cpu", DeviceChoice::kCpu}},
      arguments.device,
      "Device that draws: auto uses GL on a GPU or if --gl is given, else the CPU");
  group.rare().choice("--gl",
                      wordsOf<GlChoice>(kGlChoices, [](GlChoice each) { return name(each); }),
                      arguments.gl, "Library for OpenGL contexts");
}

void addSimdOption(const OptionGroup& group, DeviceArguments& arguments) {
  group.rare().choice("--simd",
                      wordsOf<SimdTarget>(kSimdTargets, [](SimdTarget each) { return name(each); }),
                      arguments.simd, "Best instruction set that the CPU device may use");
}

void addMemoryOption(const OptionGroup& group, MachineOptions& machine) {
  group.bytes("--memory", machine.memory_bytes,
              "Budget for blocks, chunks and software textures (half of the machine's memory)");
}

void addQuietOption(const OptionGroup& group, bool& quiet) {
  group.flag("-q,--quiet", quiet, "Prints errors only: no summary, warnings or progress");
}

void addReportOption(const OptionGroup& group, std::string& file) {
  group.text("--report", "FILE", file,
             "Writes a report of the run as JSON, or as a page if the name ends in .html");
}

void addForceOption(const OptionGroup& group, bool& force) {
  group.flag("--force", force, "Replaces existing files, whatever their contents");
}

void addIndexDirOption(const OptionGroup& group, std::string& folder) {
  group.rare().text(
      "--index-dir", "DIR", folder,
      "Folder for the indices of volumes ($SLUICE_INDEX_DIR, or the user's cache folder)");
}

void addJsonOption(const OptionGroup& group, bool& json, const std::string& help) {
  group.flag("--json", json, help);
}

namespace {

// The size of blocks: a page gives it, if no block does.
void addBlockOptions(const OptionGroup& group, ResourceArguments& arguments) {
  group.rare().parsed(
      "--page", "AxBxC", kPageSizes, parsePageOption,
      [&arguments](Vec3i page) { arguments.page_vox = page; },
      "Size of a texture page in voxels (the size that takes 64 KiB)");
  group.rare().parsed(
      "--block", "2^d", fmt::format("a power of two from {} to {}", kLeastBlock, kMostBlock),
      [](const std::string& word) { return powerOfTwo(word, kLeastBlock, kMostBlock); },
      [&arguments](int64_t block) { arguments.block = block; },
      "Voxels per side of a volume block, 4 to 1024 (the longest side of a texture page)");
}

}  // namespace

void addReadingOptions(CLI::App& app, ResourceArguments& arguments) {
  const OptionGroup group(app, kMachineHeading);
  addMemoryOption(group, arguments);
  addThreadsOption(group, arguments.threads);
  addBlockOptions(group, arguments);
  addIndexDirOption(group, arguments.index_dir);
}

void addResourceOptions(CLI::App& app, ResourceArguments& arguments) {
  addReadingOptions(app, arguments);
  const OptionGroup group(app, kMachineHeading);
  addDeviceOptions(group, arguments.device);
  addSimdOption(group, arguments.device);
  group.rare().parsed(
      "--pages", "N", fmt::format("a power of two from 1 to {}", kMostCachePages),
      [](const std::string& word) { return powerOfTwo(word, 1, kMostCachePages); },
      [&arguments](int64_t pages) { arguments.pages = pages; },
      "Pages of the texture cache, a power of two (as many as memory allows)");
  const Words<PolicyKind> policies =
      wordsOf<PolicyKind>(onlinePolicies(), [](PolicyKind kind) { return name(kind); });
  group.rare().choice("--policy", policies, arguments.policy,
                      "Replacement policy of the texture cache: " + listed(namesOf(policies)));
  group.rare().number("--seed", "N", arguments.seed, {}, "Seed of the random policy");
}

void takeIdleOptions(CLI::App& app) {
  // A scratch parser lists the options of drawing commands, so that no second list goes stale.
  CLI::App drawing;
  drawing.set_help_flag();
  ResourceArguments resources;
  FrameOptions frame;
  addResourceOptions(drawing, resources);
  const auto asked = std::make_shared<ViewState>();
  addFrameOptions(drawing, asked, frame);
  addTimeLimit(drawing, asked, frame);
  for (const CLI::Option* option : drawing.get_options()) {
    const std::string name = option->get_name();
    if (app.get_option_no_throw(name) != nullptr) continue;
    const auto warn = [&app, name](const std::string&) {
      const CLI::Option* const quiet = app.get_option_no_throw("--quiet");
      if (quiet == nullptr || quiet->count() == 0)
        printWarning(fmt::format("{} changes nothing here", name));
    };
    // CLI11 hides options of an empty group: they are taken, but not offered.
    app.add_option_function<std::string>(name, warn)->group("");
  }
}

}  // namespace sluice
