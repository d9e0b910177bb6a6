// The first refusal of a small --memory names a budget that draws, whatever the options ask for,
// with the volume's index and without it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cctype>
#include <ostream>
#include <string>
#include <vector>

#include "tests/tools/program.h"

namespace sluice::first_refusal_test {
namespace {

// The budget that a refusal names: the one to draw with if it names another to look at the volume.
std::string namedMemory(const std::string& output) {
  const std::string before = "give --memory ", behind = " to draw it";
  size_t at = output.find(before);
  if (at == std::string::npos) return "";
  at += before.size();
  if (const size_t end = output.find(behind); end != std::string::npos)
    at = output.rfind(' ', end - 1) + 1;
  size_t end = at;
  while (end < output.size() && std::isalnum(static_cast<unsigned char>(output[end])) != 0) ++end;
  return output.substr(at, end - at);
}

struct RefusedVolume {
  const char* name;
  const char* makes;  // lines of sh; %s is the program
  const char* words;
  bool has_levels = false, is_one = true;
};

void PrintTo(const RefusedVolume& volume, std::ostream* to) {
  *to << volume.name;
}

class FirstRefusal : public testing::TestWithParam<RefusedVolume> {
 protected:
  void expectDrawn(const std::string& options, bool has_index) const {
    SCOPED_TRACE(fmt::format("{}{}", options, has_index ? ", with an index" : ""));
    const std::string line =
        fmt::format("render {} {} -o a.png --force -q --device cpu ", GetParam().words, options);
    const auto run = [&](const std::string& more) {
      if (!has_index) program_.inFolder("rm -rf index");
      return program_.run(line + "--index-dir index " + more);
    };
    if (has_index) {
      ASSERT_EQ(run("").status, 0);
    }
    const CommandResult refused = run("--memory 64K");
    ASSERT_EQ(refused.status, 1) << refused.output;
    const std::string named = namedMemory(refused.output);
    ASSERT_NE(named, "") << refused.output;
    const CommandResult drawn = run("--memory " + named);
    EXPECT_EQ(drawn.status, 0) << refused.output << drawn.output;
  }

  const Program program_;
};

TEST_P(FirstRefusal, namesABudgetThatDraws) {
  const RefusedVolume& volume = GetParam();
  std::string makes = volume.makes;
  for (size_t at = makes.find("%s"); at != std::string::npos; at = makes.find("%s"))
    makes.replace(at, 2, SLUICE_PROGRAM);
  const CommandResult made = program_.inFolder(makes);
  ASSERT_EQ(made.status, 0) << made.output;
  std::vector<std::string> all = {"-s 90",
                                  "-s 400x300 --verify",
                                  "-s 90x80 --verify --block 8",
                                  "-s 90x80 --verify --block 128",
                                  "-s 400x300 --progressive",
                                  "-s 90x80 --time-limit 9s",
                                  "-s 400x300 --occlusion clip",
                                  "-s 90x80 --shade --shadows --verify"};
  if (volume.is_one) {
    for (const char* more : {"-s 300x400 --debug-view --occlusion cull", "-s 90 --iso 60:0.5",
                             "-s 90 --partition boxes --verify", "-s 90 --pages 512 --verify"})
      all.emplace_back(more);
  }
  if (volume.has_levels) all.emplace_back("-s 90 --level 0 --verify");
  for (const std::string& options : all)
    for (const bool has_index : {false, true}) expectDrawn(options, has_index);
}

constexpr const char* kPhantom = "%s synth phantom --dims 90,80,70 -q -o one.nrrd";
INSTANTIATE_TEST_SUITE_P(
    Volumes, FirstRefusal,
    testing::Values(
        RefusedVolume{"plain", kPhantom, "one.nrrd"},
        RefusedVolume{"levels",
                      "%s synth phantom --dims 90,80,70 -q -o one.nrrd; "
                      "%s pack one.nrrd -q -o levels.zarr --levels auto --chunk 32 --index-dir mk",
                      "levels.zarr", true},
        RefusedVolume{"labels",
                      "%s synth parts --dims 90,80,70 -q -o one.nrrd; %s pack one.nrrd -q -o "
                      "modes.zarr --levels auto --downsample mode --chunk 32 --index-dir mk",
                      "modes.zarr", true},
        RefusedVolume{"over",
                      "%s synth phantom --dims 90,80,70 -q -o one.nrrd; "
                      "%s pack one.nrrd -q -o levels.zarr --levels auto --chunk 32 --index-dir mk",
                      "one.nrrd --over levels.zarr", false, false},
        RefusedVolume{"series",
                      "%s synth mixing --dims 50,40,40 --steps 3 -q -o mix_%02d.nrrd; "
                      "%s pack mix_%02d.nrrd -q -o series.zarr --levels auto --index-dir mk",
                      "series.zarr --time 1", true}),
    [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace sluice::first_refusal_test
