#include "tools/bench/culling_print.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "src/base/values/bytes.h"
#include "tools/command_line/console.h"

namespace sluice {

using nlohmann::json;

void printCulling(const json& report) {
  // Rows lack the ways that were not asked for.
  const auto numberOf = [](const json& of, const char* name) {
    return of.contains(name) ? fmt::format("{:.6g}", of[name].get<double>()) : std::string("-");
  };
  say("{:>5} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8} {:>9} {:>9} {:>10} {:>10} {:>9}\n", "step",
      "not empty", "optimum", "POF", "linear", "OPOF", "TOC", "OPOF ms", "TOC ms", "OPOF px",
      "TOC px", "coherent");
  for (const json& row : report["rows"]) {
    const json& seconds = row["estimate_seconds"];
    say("{:>5} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8} {:>9.2f} {:>9.2f} {:>10} {:>10} {:>9}\n",
        row["time"].get<int64_t>(), row["blocks_nonempty"].get<int64_t>(),
        numberOf(row["visible"], "optimum"), numberOf(row["visible"], "pof"),
        numberOf(row["visible"], "linear_opof"), numberOf(row["visible"], "opof"),
        numberOf(row["visible"], "toc"), 1e3 * seconds["opof"].get<double>(),
        1e3 * seconds["toc"].get<double>(), row["pixels_checked"]["opof"].get<int64_t>(),
        row["pixels_checked"]["toc"].get<int64_t>(), numberOf(row, "coherent_share"));
  }
  const json& tree = report["tree"];
  say("tree: {} nodes, {}, made in {:.3f} s\n", tree["nodes"].get<int64_t>(),
      formatBytes(tree["bytes"].get<uint64_t>()), tree["seconds"].get<double>());
  say("\n{:>8} {:>9} {:>8} {:>8} {:>8} {:>8}\n", "azimuth", "not empty", "optimum", "POF", "linear",
      "OPOF");
  for (const json& row : report["views"])
    say("{:>8.0f} {:>9} {:>8} {:>8} {:>8} {:>8}\n", row["azimuth"].get<double>(),
        row["blocks_nonempty"].get<int64_t>(), numberOf(row["visible"], "optimum"),
        numberOf(row["visible"], "pof"), numberOf(row["visible"], "linear_opof"),
        numberOf(row["visible"], "opof"));
  say("\n{:>6} {:>12} {:>12} {:>12} {:>13} {:>16} {:>12}\n", "ranks", "fewest", "mean", "most",
      "most to mean", "of a single step", "dealt once");
  for (const json& row : report["ranks"]) {
    const auto blocks = row["blocks"].get<std::vector<int64_t>>();
    const auto [least, most] = std::minmax_element(blocks.begin(), blocks.end());
    const auto sum = std::accumulate(blocks.begin(), blocks.end(), int64_t{0});
    say("{:>6} {:>12} {:>12.1f} {:>12} {:>13.3f} {:>16.3f} {:>12.3f}\n", row["ranks"].get<int>(),
        *least, static_cast<double>(sum) / static_cast<double>(blocks.size()), *most,
        row["most_to_mean"].get<double>(), row["most_to_mean_of_worst_step"].get<double>(),
        row["most_to_mean_dealt_once"].get<double>());
  }
  if (report.contains("fusion")) {
    say("\n{:>10} {:>9} {:>9} {:>9} {:>10} {:>10} {:>9} {:>9}\n", "difference", "made s", "fused s",
        "spans", "bytes", "unshared", "coherent", "visible");
    for (const json& row : report["fusion"])
      say("{:>10g} {:>9.3f} {:>9.3f} {:>9} {:>10} {:>10} {:>9.4f} {:>9}\n",
          row["difference"].get<double>(), row["precompute_seconds"].get<double>(),
          row["fusion_seconds"].get<double>(), row["spans"].get<int64_t>(),
          formatBytes(row["bytes"].get<uint64_t>()),
          formatBytes(row["bytes_unshared"].get<uint64_t>()), row["coherent_share"].get<double>(),
          row["visible_blocks"].get<int64_t>());
  }
  // The whole series is drawn only if the bench was asked to.
  if (!report.contains("series_seconds")) return;
  say("\n");
  for (const char* name : {"none", "opof", "toc"})
    say("series {:<5} {:>8.3f} s, read {}\n", name, report["series_seconds"][name].get<double>(),
        formatBytes(report["series_read_bytes"][name].get<uint64_t>()));
}

}  // namespace sluice
