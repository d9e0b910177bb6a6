#include "tools/pages/run_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "src/base/files/shell_word.h"
#include "src/base/values/bytes.h"
#include "tools/pages/html_page.h"
#include "tools/pages/rows_section.h"

namespace sluice {
namespace {

using nlohmann::json;

constexpr size_t kMostFrames = 40;  // frames whose stages are drawn, a bar each
constexpr std::array<const char*, 9> kStages = {"classify", "plan", "read",  "decode", "copy",
                                                "upload",   "draw", "boxes", "write"};
constexpr std::array<const char*, 3> kLevels = {"volume_buffer", "texture_buffer", "texture_cache"};
constexpr std::array<std::array<const char*, 2>, 3> kClasses = {
    {{"white", "white: nothing in it shows"},
     {"grey", "grey: trimmed to the visible part"},
     {"black", "black: all of it is drawn"}}};
constexpr std::array<int, 3> kClassHues = {6, 8, 0};

// Reports of older versions lack members that newer ones have.
double numberAt(const json& object, const char* name) {
  const auto at = object.find(name);
  return at != object.end() && at->is_number() ? at->get<double>() : 0;
}

std::string textAt(const json& object, const char* pointer) {
  const json::json_pointer at(pointer);
  if (!object.contains(at)) return "";
  const json& value = object[at];
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::string titleOf(const json& report) {
  const std::string name = textAt(report, "/volume/name");
  const std::string command = "sluice " + report.value("command", std::string("report"));
  return name.empty() ? command : command + ": " + name;
}

std::string pictureSection(const json& report, const PagePictures& pictures) {
  if (pictures.picture_png.empty()) return "";
  return fmt::format(
      "<figure><img src='{}' alt='the picture'><figcaption>{}</figcaption></figure>\n",
      dataUri("image/png", pictures.picture_png), escapeHtml(textAt(report, "/output")));
}

// Whether the user set the option; otherwise its value follows from `rule`, which is shown with it.
std::string because(const json& report, const char* option, std::string_view rule) {
  const std::string given = textAt(report, (std::string("/options/") + option).c_str());
  if (!given.empty() && given != "auto") return fmt::format(" (--{} {})", option, given);
  return fmt::format(" ({})", rule);
}

std::string chosenSection(const json& report) {
  std::vector<std::array<std::string, 2>> facts;
  const auto add = [&facts](const char* fact, const std::string& value) {
    if (!value.empty()) facts.push_back({fact, value});
  };
  add("asked, with defaults", commandLineOf(report));
  add("look", textAt(report, "/look/options"));
  if (report.contains("gl"))
    add("device", textAt(report, "/device") + " " + textAt(report, "/gl/renderer") +
                      because(report, "device", "GL if a GPU's driver works, else the CPU device"));
  if (report.contains("/volume/dims"_json_pointer))
    add("volume",
        fmt::format("{} of {}, {} time step(s)", textAt(report, "/volume/dims"),
                    textAt(report, "/volume/voxel_type"), textAt(report, "/volume/time_steps")));
  if (report.contains("/volume/blocks/size"_json_pointer))
    add("blocks", textAt(report, "/volume/blocks/count") + " of " +
                      textAt(report, "/volume/blocks/size") + " voxels a side" +
                      because(report, "block", "the longest side of a page"));
  if (report.contains("/levels/texture_cache/page"_json_pointer))
    add("pages", textAt(report, "/levels/texture_cache/pages") + " of " +
                     textAt(report, "/levels/texture_cache/page") + " voxels" +
                     because(report, "pages", "a power of two that --memory allows"));
  if (report.contains("memory_bytes"))
    add("memory", formatBytes(report["memory_bytes"].get<uint64_t>()) +
                      because(report, "memory", "half of the machine's memory"));
  if (report.contains("peak_anonymous_bytes"))
    add("most memory used", formatBytes(report["peak_anonymous_bytes"].get<uint64_t>()));
  return facts.empty() ? "" : "<h2>Options and results</h2>\n" + htmlFacts(facts);
}

std::string stagesSection(const json& report) {
  if (!report.contains("frames") || report["frames"].empty()) return "";
  const json& frames = report["frames"];
  std::vector<Bar> bars;
  for (size_t i = 0; i < std::min(frames.size(), kMostFrames); ++i) {
    Bar bar{frames[i].contains("time") ? fmt::format("time {}", textAt(frames[i], "/time"))
                                       : fmt::format("frame {}", i),
            fmt::format("{:.4g} s", numberAt(frames[i], "seconds")),
            {}};
    for (size_t s = 0; s < kStages.size(); ++s) {
      const double seconds = numberAt(frames[i].value("stages", json::object()), kStages[s]);
      bar.parts.push_back({std::max(seconds, 0.0), static_cast<int>(s),
                           fmt::format("{}: {:.4g} s", kStages[s], seconds)});
    }
    bars.push_back(std::move(bar));
  }
  std::string out = "<h2>Time by stage</h2>\n" + barsSvg(bars) + "<p>";
  for (size_t s = 0; s < kStages.size(); ++s) out += htmlKey(static_cast<int>(s), kStages[s]);
  out +=
      "</p>\n"
      "<p>Reading, decoding and copying are summed over threads that work ahead of the drawing. "
      "The parts may therefore be longer than the frame, whose seconds stand at the end.</p>\n";
  if (frames.size() > kMostFrames)
    out += fmt::format("<p>The first {} of {} frames.</p>\n", kMostFrames, frames.size());
  return out;
}

std::string levelsSection(const json& report) {
  if (!report.contains("levels")) return "";
  const json& levels = report["levels"];
  std::vector<HtmlRow> rows;
  std::vector<Bar> asked;
  if (levels.contains("disk"))
    rows.push_back({"1 disk", "",
                    readable("read_bytes", levels["disk"].value("read_bytes", json())), "", "", "",
                    ""});
  for (size_t i = 0; i < kLevels.size(); ++i) {
    if (!levels.contains(kLevels[i])) continue;
    const json& level = levels[kLevels[i]];
    const auto bytes = [&level](const char* name) {
      return readable(name, level.value(name, json(0)));
    };
    std::string label = fmt::format("{} {}", i + 2, kLevels[i]);
    std::replace(label.begin(), label.end(), '_', ' ');
    const double hits = numberAt(level, "hits"), misses = numberAt(level, "misses");
    rows.push_back({label, bytes("budget_bytes"), bytes("current_bytes"), bytes("peak_bytes"),
                    fmt::format("{:.0f}", hits), fmt::format("{:.0f}", misses),
                    fmt::format("{:.0f}", numberAt(level, "evictions"))});
    asked.push_back({label,
                     fmt::format("{:.0f} requests", hits + misses),
                     {{hits, 2, fmt::format("{:.0f} hits", hits)},
                      {misses, 4, fmt::format("{:.0f} misses", misses)}}});
  }
  return "<h2>The four levels</h2>\n" +
         htmlTable({"level", "budget", "now (disk: read)", "most", "hits", "misses", "evictions"},
                   rows) +
         barsSvg(asked) + "<p>" + htmlKey(2, "hits") + htmlKey(4, "misses") + "</p>\n";
}

std::string blocksSection(const json& report, const PagePictures& pictures) {
  if (!report.contains("blocks") || !report["blocks"].contains("white")) return "";
  Bar bar{"blocks", "", {}};
  std::string keys;
  double sum = 0;
  for (size_t i = 0; i < kClasses.size(); ++i) {
    const double count = numberAt(report["blocks"], kClasses[i][0]);
    sum += count;
    bar.parts.push_back({count, kClassHues[i], fmt::format("{:.0f} {}", count, kClasses[i][0])});
    keys += htmlKey(kClassHues[i], fmt::format("{:.0f} {}", count, kClasses[i][1]));
  }
  bar.end = fmt::format("{:.0f}", sum);
  std::string out =
      "<h2>Blocks by class</h2>\n" + barsSvg(std::array{bar}) + "<p>" + keys + "</p>\n";
  if (!pictures.blocks_png.empty())
    out += fmt::format(
        "<figure><img src='{}' alt='blocks by class' "
        "style='image-rendering:pixelated'><figcaption>{}"
        "</figcaption></figure>\n",
        dataUri("image/png", pictures.blocks_png), escapeHtml(pictures.blocks_caption));
  return out;
}

std::string wholeSection(const json& report) {
  return "<details><summary>All of it as JSON</summary><pre>" + [&report] {
    std::string text;
    // Bytes that are no UTF-8 come from names of files; they must not break the page.
    for (const char c : report.dump(2, ' ', false, json::error_handler_t::replace))
      text += c == '\n' ? std::string("\n") : escapeHtml({&c, 1});
    return text;
  }() + "</pre></details>\n";
}

}  // namespace

std::string readable(const std::string& name, const json& value) {
  if (!value.is_number()) return value.is_string() ? value.get<std::string>() : value.dump();
  if (name.ends_with("bytes") && value.is_number_integer())
    return formatBytes(value.get<uint64_t>());
  if (value.is_number_integer()) return value.dump();
  return fmt::format("{:.4g}{}", value.get<double>(), name.ends_with("seconds") ? " s" : "");
}

std::string commandLineOf(const json& report) {
  if (!report.contains("options")) return "";
  std::string line = "sluice " + report.value("command", std::string());
  const auto add = [&line](const json& value) {
    line += ' ';
    line += shellWord(value.is_string() ? value.get<std::string>() : value.dump());
  };
  for (const auto& [name, value] : report["options"].items())
    if (name == "volume")
      for (const json& file : value.is_array() ? value : json::array({value})) add(file);
  for (const auto& [name, value] : report["options"].items()) {
    // A flag that was not given has no word in the command.
    if (name == "volume" || value == false) continue;
    line += " --" + name;
    if (value.is_array())
      for (const json& part : value) add(part);
    else if (value != true)
      add(value);
  }
  return line;
}

std::string runPage(const json& report, const PagePictures& pictures) {
  return htmlPage(titleOf(report), "",
                  pictureSection(report, pictures) + chosenSection(report) + stagesSection(report) +
                      rowsSection(report) + blocksSection(report, pictures) +
                      levelsSection(report) + wholeSection(report));
}

}  // namespace sluice
