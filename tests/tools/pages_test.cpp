// Pages of reports: their building blocks, and the files that the program writes.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "io/pictures/png_file.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/program.h"
#include "tools/pages/block_map.h"
#include "tools/pages/compare_page.h"
#include "tools/pages/html_page.h"
#include "tools/pages/run_page.h"

namespace sluice {
namespace {

using nlohmann::json;

std::string uriOf(std::string_view text) {
  return dataUri("x/y", std::as_bytes(std::span(text)));
}

// RFC 4648, section 10.
TEST(HtmlPage, writesBytesInBase64) {
  EXPECT_EQ(uriOf(""), "data:x/y;base64,");
  EXPECT_EQ(uriOf("f"), "data:x/y;base64,Zg==");
  EXPECT_EQ(uriOf("fo"), "data:x/y;base64,Zm8=");
  EXPECT_EQ(uriOf("foo"), "data:x/y;base64,Zm9v");
  EXPECT_EQ(uriOf("foob"), "data:x/y;base64,Zm9vYg==");
  EXPECT_EQ(uriOf("fooba"), "data:x/y;base64,Zm9vYmE=");
  EXPECT_EQ(uriOf("foobar"), "data:x/y;base64,Zm9vYmFy");
}

double widthOf(const std::string& svg, const std::string& css) {
  const size_t bar = svg.find("<rect class='" + css + "'");
  EXPECT_NE(bar, std::string::npos) << css;
  const size_t at = svg.find("width='", bar) + 7;
  return std::stod(svg.substr(at));
}

TEST(HtmlPage, barsAreAsLongAsTheirValues) {
  const std::vector<Bar> bars{{"a", "3", {{1, 0, ""}, {2, 1, ""}}}, {"b", "6", {{6, 2, "<hint>"}}}};
  const std::string svg = barsSvg(bars);
  EXPECT_NEAR(widthOf(svg, "h1"), 2 * widthOf(svg, "h0"), 0.02);
  EXPECT_NEAR(widthOf(svg, "h2"), 6 * widthOf(svg, "h0"), 0.06);
  EXPECT_NE(svg.find("&lt;hint&gt;"), std::string::npos);
  EXPECT_EQ(barsSvg(std::vector<Bar>{{"none", "0", {{0, 0, ""}}}}).find("nan"), std::string::npos);
}

std::array<int, 4> pixelAt(const Rgba8Picture& picture, int x, int y) {
  std::array<int, 4> color{};
  for (size_t c = 0; c < 4; ++c)
    color[c] = picture.rgba[4 * static_cast<size_t>(y * picture.width + x) + c];
  return color;
}

// Two layers of 3 x 2 blocks of 24 pixels, 2 pixels apart.
TEST(BlockMap, paintsEachBlockInItsLayerWithYUpwards) {
  VisibleBlocks blocks;
  blocks.blocks.resize(2);
  blocks.blocks[0].name.block = 2;  // (2, 0, 0)
  blocks.blocks[0].kind = BlockClass::kBlack;
  blocks.blocks[1].name.block = 6 + 3;  // (0, 1, 1)
  blocks.blocks[1].kind = BlockClass::kGrey;
  const auto map = blockMap({3, 2, 2}, blocks);
  ASSERT_TRUE(map);
  ASSERT_EQ(map->picture.width, 2 * 72 + 2);
  ASSERT_EQ(map->picture.height, 48);
  const auto white = pixelAt(map->picture, 1, 1);
  const auto black_color = pixelAt(map->picture, 71, 47), grey_color = pixelAt(map->picture, 74, 0);
  EXPECT_NE(black_color, white);
  EXPECT_NE(grey_color, white);
  EXPECT_NE(grey_color, black_color);
  EXPECT_EQ(pixelAt(map->picture, 72, 10)[3], 0);  // between the layers
  int painted = 0;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < map->picture.width; ++x)
      painted += pixelAt(map->picture, x, y) == black_color;
  EXPECT_EQ(painted, 24 * 24);
}

TEST(BlockMap, leavesOutLayersOfGridsThatDoNotFit) {
  const auto map = blockMap({400, 400, 400}, {});
  ASSERT_TRUE(map);
  EXPECT_LE(map->picture.width, 1000);
  EXPECT_LE(map->picture.height, 1000);
  EXPECT_NE(map->caption.find("every 100th layer"), std::string::npos) << map->caption;
  EXPECT_FALSE(blockMap({2000, 2, 2}, {}));
}

json benchReport(double seconds, double fps) {
  return {{"command", "bench occlusion"},
          {"options", {{"size", "512x512"}, {"volume", json::array({"a b.raw"})}}},
          {"frame_seconds", {{"median", seconds}}},
          {"rows", {{{"volume", "/data/<b>.raw"}, {"fps", {{"ess", fps}}}}}}};
}

TEST(RunPage, escapesWhatItShowsAndLoadsNothing) {
  const std::string page = runPage(benchReport(0.5, 7), {});
  EXPECT_TRUE(page.starts_with("<!DOCTYPE html>"));
  EXPECT_EQ(page.find("<b>.raw"), std::string::npos);
  EXPECT_NE(page.find("&lt;b&gt;.raw"), std::string::npos);
  EXPECT_NE(page.find("fps.ess"), std::string::npos);
  for (const char* outside : {"http:", "https:", "href=", "@import", "url(", "<script"})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  EXPECT_EQ(commandLineOf(benchReport(1, 1)), "sluice bench occlusion 'a b.raw' --size 512x512");
}

TEST(ComparePage, putsEachNumberAgainstTheFirstRuns) {
  json second = benchReport(0.25, 14);
  second["options"]["size"] = "400x400";
  second["more"] = 3;
  const std::vector<NamedReport> runs{{"one.json", benchReport(0.5, 7)}, {"two.json", second}};
  const std::vector<ComparedNumber> numbers = compared(runs);
  const auto ratioOf = [&numbers](const std::string& name) -> std::string {
    for (const ComparedNumber& number : numbers)
      if (number.name == name) return ratioText(number, 1);
    return "not there";
  };
  EXPECT_EQ(ratioOf("frame_seconds.median"), "x 0.5");
  EXPECT_EQ(ratioOf("rows.<b>.raw.fps.ess"), "x 2");
  EXPECT_EQ(ratioOf("more"), "");  // the first run lacks it
  const std::string page = comparePage(runs);
  EXPECT_NE(page.find("<td>size</td><td>512x512</td><td>400x400</td>"), std::string::npos);
  EXPECT_NE(page.find("&lt;b&gt;.raw.fps.ess: longer is faster"), std::string::npos);
}

TEST(Pages, areWrittenWhereTheNameOfAReportSaysSo) {
  const Program program;
  const std::string render =
      std::string("render ") + kSmall + " --threshold 60 -o p.png --size 40x40 -q ";
  ASSERT_EQ(program.run(render + "--report r.HTML").status, 0);
  const std::string text = readFile(program.folder / "r.HTML");
  EXPECT_TRUE(text.starts_with("<!DOCTYPE html>"));
  // The very picture that was written.
  const std::string png = readFile(program.folder / "p.png");
  EXPECT_NE(text.find(dataUri("image/png", std::as_bytes(std::span(png)))), std::string::npos);
  for (const char* part :
       {"Options and results", "Time by stage", "The four levels", "Blocks by class"})
    EXPECT_NE(text.find(part), std::string::npos) << part;
  ASSERT_EQ(program.run(render + "--report r.json").status, 0);
  EXPECT_EQ(json::parse(readFile(program.folder / "r.json"))["command"], "render");
  // Somebody's notes are not replaced.
  std::ofstream(program.folder / "notes.html") << "notes";
  EXPECT_EQ(program.run(render + "--report notes.html").status, 1);
  EXPECT_EQ(readFile(program.folder / "notes.html"), "notes");
}

TEST(Pages, ofPlansAndSimulations) {
  const Program program;
  ASSERT_EQ(
      program.run(std::string("plan ") + kSmall + " --threshold 60 -q --report p.html").status, 0);
  EXPECT_NE(readFile(program.folder / "p.html").find("Blocks by class"), std::string::npos);
  ASSERT_EQ(program
                .run(std::string("simulate ") + kSmall +
                     " --threshold 60 -q --report s.html --html t.html")
                .status,
            0);
  EXPECT_EQ(readFile(program.folder / "s.html"), readFile(program.folder / "t.html"));
  ASSERT_EQ(
      program.run(std::string("simulate ") + kSmall + " --threshold 60 -q --report s.json").status,
      0);
  EXPECT_EQ(json::parse(readFile(program.folder / "s.json"))["command"], "simulate");
}

}  // namespace
}  // namespace sluice
