// sluice doctor: what works on this machine, on one page to paste into a report.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <memory>
#include <thread>

#include "src/base/bytes.h"
#include "src/base/clock.h"
#include "src/gl/probe.h"
#include "tools/commands.h"

namespace sluice {
namespace {

nlohmann::json asJson(const std::vector<GlProbe>& probes) {
  nlohmann::json report;
  report["version"] = SLUICE_VERSION;
  report["memory_bytes"] = availableMemoryBytes();
  report["cores"] = std::thread::hardware_concurrency();
  report["gl"] = nlohmann::json::array();
  for (const GlProbe& probe : probes)
    report["gl"].push_back({{"backend", probe.backend},
                            {"device", probe.device},
                            {"works", probe.works},
                            {"software", probe.is_software},
                            {"renderer", probe.renderer},
                            {"version", probe.version},
                            {"reason", probe.reason},
                            {"max_3d_texture_size", probe.max_3d_texture_size}});
  return report;
}

void print(const std::vector<GlProbe>& probes) {
  fmt::print("sluice {}\n", SLUICE_VERSION);
  fmt::print("memory {}, {} cores\n", formatBytes(availableMemoryBytes()),
             std::thread::hardware_concurrency());
  bool any = false;
  for (const GlProbe& probe : probes) {
    any = any || probe.works;
    const std::string where = probe.device.empty() ? "" : " (" + probe.device + ")";
    if (probe.works) {
      fmt::print("{}{}: works, {}, OpenGL {}, 3D textures up to {} a side\n", probe.backend, where,
                 probe.renderer, probe.version, probe.max_3d_texture_size);
    } else {
      fmt::print("{}{}: does not work: {}\n", probe.backend, where, probe.reason);
    }
  }
  if (!any) fmt::print("nothing can draw here; apt-get install libosmesa6\n");
}

}  // namespace

Command addDoctor(CLI::App& program) {
  auto json = std::make_shared<bool>(false);
  CLI::App* app = program.add_subcommand(
      "doctor", "What works on this machine and why the rest does not\n\n  sluice doctor");
  app->add_flag("--json", *json, "One JSON object");
  return [json] {
    const std::vector<GlProbe> probes = probeGl();
    if (*json) {
      fmt::print("{}\n", asJson(probes).dump(2));
    } else {
      print(probes);
    }
    return 0;
  };
}

}  // namespace sluice
