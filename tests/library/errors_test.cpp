// Errors of the library: their kinds, and the names of options in their lines.
#include "src/library/option_fields.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <regex>
#include <set>
#include <sstream>
#include <utility>

#include "src/base/field_names.h"
#include "src/options/option_table.h"
#include "tests/library/library_support.h"
#include "tests/support/temp_folder.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::Not;

namespace fs = std::filesystem;

TEST(FieldNames, standForOptionsInALine) {
  EXPECT_EQ(inFields("--memory 64M is too small; give --memory 96M or fewer --pages"),
            "memory_bytes 64M is too small; give memory_bytes 96M or fewer pipeline.pages");
  EXPECT_EQ(inFields("a.raw: dimensions unknown; give --dims X,Y,Z (or --type)"),
            "a.raw: dimensions unknown; give dims X,Y,Z (or type)");
  EXPECT_EQ(inFields("leave out --level, --pixel-error and --max-bytes, or make all visible"),
            "leave out level, pixel_error and max_bytes, or make all visible");
  EXPECT_EQ(inFields("out--memory.raw: damaged"), "out--memory.raw: damaged");
  EXPECT_EQ(inFields("an --unheard-of option"), "an --unheard-of option");
}

TEST(FieldNames, leaveTheProgramItsOptions) {
  const Error error("give more --memory", Error::Kind::kMemory);
  const FieldError in_fields(error, inFields(error.what()));
  EXPECT_STREQ(in_fields.what(), "give more memory_bytes");
  EXPECT_EQ(in_fields.kind(), Error::Kind::kMemory);
  EXPECT_EQ(lineInOptions(in_fields), "give more --memory");
  EXPECT_EQ(lineInOptions(error), "give more --memory");
}

// Options that the library's parts name in messages. Those of commands, of help, of the window and
// of packing are left out, since no call of the library reaches them.
std::set<std::string> optionsInMessages() {
  const fs::path root = SLUICE_SOURCE_DIR;
  const std::set<fs::path> others = {root / "src/options", root / "src/view", root / "src/annotate",
                                     root / "io/zarr/packing", root / "io/meshes"};
  const std::regex option(R"([ "(](--[a-z][a-z-]*[a-z]))");
  std::set<std::string> found;
  for (const char* part : {"src", "io"})
    for (auto at = fs::recursive_directory_iterator(root / part); at != fs::end(at); ++at) {
      if (at->is_directory() && others.contains(at->path())) at.disable_recursion_pending();
      if (at->path().extension() != ".cpp" && at->path().extension() != ".h") continue;
      std::istringstream lines(readFile(at->path()));
      for (std::string line; std::getline(lines, line);) {
        const std::string code = line.substr(0, line.find("//"));
        if (code.find('"') == std::string::npos) continue;
        for (std::sregex_iterator match(code.begin(), code.end(), option), end; match != end;
             ++match)
          found.insert((*match)[1]);
      }
    }
  return found;
}

TEST(FieldNames, areKnownForEachOptionInAMessage) {
  // Ranks, culling over a series and written files are the program's alone.
  const std::set<std::string> programs = {"--basis", "--culling", "--downsample",
                                          "--force", "--mpi",     "--raw"};
  const std::set<std::string> options = optionsInMessages();
  EXPECT_GT(options.size(), 30U);
  for (const std::string& option : options) {
    if (programs.contains(option)) continue;
    EXPECT_NE(inFields(option), option);
  }
}

TEST(FieldNames, areMembersOfTheHeaders) {
  std::string headers;
  for (const auto& file : fs::directory_iterator(fs::path(SLUICE_SOURCE_DIR) / "include/sluice"))
    headers += readFile(file.path());
  std::set<std::string> options = optionsInMessages();
  for (const OptionEntry& entry : optionTable())
    for (const std::string_view name : optionNames(entry)) options.emplace(name);
  for (const VolumeEntry& entry : volumeTable())
    for (const std::string_view name : optionNames(entry)) options.emplace(name);
  for (const std::string& option : options) {
    const std::string field = inFields(option);
    if (field == option || field == "width and height") continue;
    std::istringstream parts(field);
    for (std::string part; std::getline(parts, part, '.');)
      EXPECT_TRUE(std::regex_search(headers, std::regex("[ >]" + part + "( = |;| \\{|, |\\{)")))
          << field;
  }
}

TEST(Error, tellsWhatHasToChange) {
  using Kind = Error::Kind;
  const TempFolder folder;
  std::ofstream(folder / "short_8x8x8_uint8.raw") << "voxels";
  std::ofstream(folder / "damaged.nrrd") << "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 4\n";
  std::ofstream(folder / "unknown.raw") << "voxels";
  const auto opened = [&](const std::string& name, const VolumeOptions& options = {}) {
    const Volume volume((folder / name).string(), options);
  };
  const Volume shells(kShells);
  const std::vector<std::pair<Kind, std::function<void()>>> calls = {
      {Kind::kInput, [&] { opened("missing.nrrd"); }},
      {Kind::kInput, [&] { opened("damaged.nrrd"); }},
      {Kind::kRequest, [&] { opened("unknown.raw"); }},
      {Kind::kRequest, [&] { opened("short_8x8x8_uint8.raw"); }},
      {Kind::kRequest, [&] { opened("unknown.raw", {.grid = "density"}); }},
      {Kind::kRequest, [&] { const Volume volume(kShells, {.time = 4}); }},
      {Kind::kRequest, [&] { const Volume volume(kShells, {.channel = 3}); }},
      {Kind::kRequest, [&] { Renderer(shells, {.surfaces = {{.value = 90}}, .labels = true}); }},
      {Kind::kRequest, [&] { Renderer(shells, {.map = "pinkish"}); }},
      {Kind::kRequest, [&] { Renderer(shells).draw({.level = 3}); }},
      {Kind::kRequest, [&] { Renderer(shells).draw({.step_vox = 1e-6}); }},
      {Kind::kInput, [&] { Renderer(shells, {.transfer_file = folder / "missing.json"}); }},
      {Kind::kMemory, [&] { const Volume volume(kShells, {.memory_bytes = 10}); }},
      {Kind::kMemory, [&] { const Renderer renderer(shells, {}, {.memory_bytes = 10}); }},
      {Kind::kInput,
       [&] { Renderer(shells).draw(kSmall).writePng(folder / "no/such/folder.png"); }},
      {Kind::kSystem, [&] { Renderer(shells).draw(kSmall).writePng("/dev/full"); }},
  };
  for (size_t i = 0; i < calls.size(); ++i) try {
      calls[i].second();
      ADD_FAILURE() << "call " << i << " throws nothing";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), calls[i].first) << error.what();
      EXPECT_THAT(error.what(), Not(HasSubstr("--")));
    }
}

}  // namespace
}  // namespace sluice
