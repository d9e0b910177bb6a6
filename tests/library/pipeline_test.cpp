// The pipeline's options: the same picture by each way, and the requests of the program's own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <set>

#include "cache/trace/trace.h"
#include "src/library/option_fields.h"
#include "tests/library/library_support.h"

namespace sluice {
namespace {

using testing::HasSubstr;

constexpr const char* kVolume = "synth:shells,dims=70x64x60";
const PictureOptions kPicture{.width = 120, .height = 100, .opacity_threshold = 1.0};

// One page short of what the picture takes, so that the policy matters.
constexpr int64_t kPages = 8;

struct Way {
  VolumeOptions volume = {};
  PipelineOptions pipeline = {};
  std::string arguments;
};

VolumeOptions smallBlocks() {
  return {.block = 16, .page = {{16, 16, 8}}};
}

std::vector<Way> ways() {
  std::vector<Way> ways{{.arguments = ""}};
  ways.push_back({.volume = smallBlocks(), .arguments = "--block 16 --page 16x16x8"});
  const auto add = [&](PipelineOptions pipeline, const std::string& arguments) {
    pipeline.pages = kPages;
    ways.push_back({smallBlocks(), pipeline, "--block 16 --page 16x16x8 --pages 8 " + arguments});
  };
  for (const char* algorithm : {"conventional", "clipped", "trimmed", "merged"})
    add({.algorithm = algorithm}, std::string("--algorithm ") + algorithm);
  add({.merge = "first-fit"}, "--merge first-fit");
  add({.partition = "boxes"}, "--partition boxes");
  for (const char* occlusion : {"map", "cull", "clip"})
    add({.occlusion = occlusion}, std::string("--occlusion ") + occlusion);
  for (const char* policy : {"random", "arc", "sieve"})
    add({.policy = policy, .seed = 7}, std::string("--seed 7 --policy ") + policy);
  add({.simd = "plain"}, "--simd plain");
  return ways;
}

TEST(Pipeline, waysHaveThePictureAndTheRequestsOfTheProgram) {
  const TempFolder folder;
  std::vector<uint8_t> first;
  std::set<std::string> traces;
  for (const Way& way : ways()) {
    SCOPED_TRACE(way.arguments);
    const Volume volume(kVolume, way.volume);
    std::vector<uint8_t> drawn;
    {
      Renderer renderer(
          volume, {.threshold = 90},
          {.device = RendererOptions::Device::kCpu, .threads = 1, .pipeline = way.pipeline});
      renderer.recordTo((folder / "library.trace").string());
      drawn = renderer.draw(kPicture).toRgba8();
    }
    if (first.empty()) first = drawn;
    EXPECT_GT(visiblePixels(drawn), 500U);
    EXPECT_LE(largestDifference(drawn, first), 1);
    const Rgba8Picture expected = programPicture(
        folder, std::string(kVolume) +
                    " --size 120x100 --threshold 90 --opacity-threshold 1 --device cpu -j 1"
                    " --trace program.trace " +
                    way.arguments);
    EXPECT_EQ(largestDifference(drawn, expected.rgba), 0);
    const std::string trace = readFile(folder / "library.trace");
    EXPECT_EQ(trace, readFile(folder / "program.trace"));
    traces.insert(trace);
  }
  EXPECT_GE(traces.size(), 6U) << "the options change nothing";
}

// Light that looks around shares out the memory anew, and of two volumes it ends their blending.
TEST(Pipeline, aTraceGoesOnWhenTheMemoryIsSharedOutAnew) {
  const TempFolder folder;
  for (const VolumeOptions& opened :
       {smallBlocks(), VolumeOptions{.over = "synth:parts,dims=70x64x60"}}) {
    const Volume volume(kVolume, opened);
    PictureOptions shadowed = kPicture;
    shadowed.lighting.shadows = 0.5;
    std::vector<uint64_t> requests;
    {
      Renderer renderer(volume, {.threshold = 90}, {.device = RendererOptions::Device::kCpu});
      renderer.recordTo((folder / "t.txt").string());
      for (const PictureOptions& picture : {kPicture, shadowed, shadowed}) {
        renderer.draw(picture);
        requests.push_back(renderer.report().texture_cache.requests);
      }
    }
    ASSERT_GT(requests[0], 0U);
    ASSERT_GT(requests[1], 0U);
    uint64_t recorded = 0;
    std::map<uint32_t, std::set<uint64_t>> chunks;  // of each frame
    const std::vector<std::string> names = opened.over.empty()
                                               ? std::vector<std::string>{"t.txt"}
                                               : std::vector<std::string>{"t_0.txt", "t_over.txt"};
    for (const std::string& name : names) {
      const Trace trace = readAll(*openTrace(folder / name));
      recorded += trace.records.size();
      chunks.clear();
      for (const TraceRecord& record : trace.records) chunks[record.frame].insert(record.chunk);
      ASSERT_EQ(chunks.size(), 3U) << name;
      EXPECT_EQ(chunks.rbegin()->first, 2U);
      // Nothing is resident after the memory was shared out, so the simulator must miss too.
      std::set<uint64_t> again = chunks[0];
      again.merge(std::set<uint64_t>(chunks[1]));
      EXPECT_EQ(again.size(), chunks[0].size() + chunks[1].size());
      EXPECT_EQ(chunks[2], chunks[1]);
    }
    // The counters of the first session end with it.
    EXPECT_EQ(recorded, requests[0] + requests[2]);
  }
}

// A ray that ends early leaves out what is behind it.
TEST(Pipeline, anOpacityThresholdHides) {
  const Volume volume(kVolume);
  const LookOptions opaque{.threshold = 90, .opacity = 1.0};
  Renderer renderer(volume, opaque, {.device = RendererOptions::Device::kCpu});
  PictureOptions early = kPicture;
  early.opacity_threshold = 0.2;
  const std::vector<uint8_t> all = renderer.draw(kPicture).toRgba8();
  EXPECT_GT(largestDifference(renderer.draw(early).toRgba8(), all), 8);
}

TEST(Pipeline, whatCannotBeIsNamed) {
  const Volume volume(kVolume);
  const auto why = [](const std::function<void()>& call) {
    try {
      call();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), Error::Kind::kRequest) << error.what();
      return std::string(error.what());
    }
    return std::string();
  };
  const auto drawnBy = [&](const PipelineOptions& pipeline, const LookOptions& look = {},
                           const PictureOptions& picture = kSmall) {
    return why([&] { Renderer(volume, look, {.pipeline = pipeline}).draw(picture); });
  };
  EXPECT_EQ(drawnBy({.algorithm = "V"}),
            "pipeline.algorithm \"V\": expected one of conventional, clipped, trimmed, merged");
  EXPECT_THAT(drawnBy({.merge = "last"}), HasSubstr("paper, first-fit"));
  EXPECT_THAT(drawnBy({.partition = "all"}), HasSubstr("blocks, boxes"));
  EXPECT_THAT(drawnBy({.occlusion = "on"}), HasSubstr("off, map, cull, clip"));
  EXPECT_THAT(drawnBy({.policy = "belady"}), HasSubstr("lru, fifo"));
  EXPECT_THAT(drawnBy({.simd = "neon"}), HasSubstr("plain, sse4"));
  EXPECT_THAT(drawnBy({.gl = "glx"}), HasSubstr("osmesa, egl"));
  EXPECT_EQ(drawnBy({.pages = 6}), "pipeline.pages 6: must be a power of two from 1 to 2147483648");
  EXPECT_THAT(drawnBy({.occlusion = "cull"}, {.mode = LookOptions::Mode::kMaximum}),
              HasSubstr("only composite pictures"));
  EXPECT_THAT(drawnBy({.partition = "boxes"}, {}, {.level = 1}), HasSubstr("finest level alone"));
  for (const double opacity : {0.0, -1.0, 1.5, kNan})
    EXPECT_THAT(drawnBy({}, {}, {.opacity_threshold = opacity}), HasSubstr("above 0, up to 1"));
  for (const int64_t block : {0, 2, 24, 2048})
    EXPECT_THAT(why([&] { const Volume none(kVolume, {.block = block}); }),
                HasSubstr("must be a power of two from 4 to 1024"));
  EXPECT_THAT(why([&] {
                const Volume none(kVolume, {.page = {{16, 0, 8}}});
              }),
              HasSubstr("page 0: must be a power of two"));
}

// Each option of `sluice render` has a field, unless it is about files that the program writes, the
// commands' own steps through a film, or how they print.
TEST(Pipeline, eachOptionOfRenderHasAField) {
  const std::set<std::string> programs = {
      "--help",   "--help-all",    "--output",     "--annotate",   "--aov",
      "--trace",  "--report",      "--verify",     "--force",      "--debug-view",
      "--json",   "--progressive", "--frames",     "--path",       "--rate",
      "--state",  "--culling",     "--difference", "--directions", "--part",
      "--detail", "--basis",       "--continue",   "--quiet",      "--background"};
  const CommandResult help = runCommand(SLUICE_PROGRAM " render --help-all");
  std::set<std::string> options;
  for (size_t at = 0; (at = help.output.find("--", at)) != std::string::npos;) {
    const size_t end = help.output.find_first_not_of("abcdefghijklmnopqrstuvwxyz-", at);
    options.insert(help.output.substr(at, end - at));
    at = end;
  }
  EXPECT_GT(options.size(), 70U);
  for (const std::string& option : options) {
    if (option == "--" || programs.contains(option)) continue;
    EXPECT_NE(inFields(option), option);
  }
}

}  // namespace
}  // namespace sluice
