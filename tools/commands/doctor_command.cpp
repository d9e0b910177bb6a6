// sluice doctor: the devices that work on this machine, on one page to paste into a report.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "src/base/threads/clock.h"
#include "src/base/threads/threads.h"
#include "src/base/values/bytes.h"
#include "src/cpu/simd_target.h"
#include "tools/command_line/console.h"
#include "tools/commands/commands.h"
#include "tools/options/shared_options.h"
#if SLUICE_HAS_GL
#include "src/gl/contexts/probe.h"
#endif

namespace sluice {
namespace {

// A build without OpenGL has no probe, and the page then tells that no OpenGL works.
#if !SLUICE_HAS_GL
struct GlProbe {
  std::string backend, device;
  bool works = false, is_software = false;
  std::string renderer, version;
  int max_3d_texture_size = 0;
  std::string reason;
};
std::vector<GlProbe> probeGl() {
  return {};
}
#endif

// The choice of --device auto on this machine, and its reason.
struct Chosen {
  std::string device, reason;
};
Chosen chosenOf(const std::vector<GlProbe>& probes) {
  for (const GlProbe& probe : probes)
    // --device auto tries EGL alone, which draws without a window.
    if (probe.works && !probe.is_software && probe.backend == "egl")
      return {"gl", "a GPU's driver works: " + probe.renderer};
  if (std::any_of(probes.begin(), probes.end(), [](const GlProbe& each) { return each.works; }))
    return {"cpu", "OpenGL works only in software, which is slower"};
  return {"cpu", "no OpenGL works"};
}

nlohmann::json asJson(const std::vector<GlProbe>& probes) {
  nlohmann::json report;
  report["version"] = SLUICE_VERSION;
  report["memory_bytes"] = availableMemoryBytes();
  report["cores"] = processorCount();
  const Chosen chosen = chosenOf(probes);
  report["device"] = {{"auto", chosen.device}, {"reason", chosen.reason}};
  report["simd"] = nlohmann::json::array();
  for (const SimdTarget target : simdTargets()) report["simd"].push_back(name(target));
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
  say("sluice {}\n", SLUICE_VERSION);
  say("memory {}, {} cores\n", formatBytes(availableMemoryBytes()), processorCount());
  for (const GlProbe& probe : probes) {
    const std::string where = probe.device.empty() ? "" : " (" + probe.device + ")";
    if (probe.works) {
      say("{}{}: works, {}, OpenGL {}, 3D textures up to {} a side\n", probe.backend, where,
          probe.renderer, probe.version, probe.max_3d_texture_size);
    } else {
      say("{}{}: does not work: {}\n", probe.backend, where, probe.reason);
    }
  }
  std::string targets;
  for (const SimdTarget target : simdTargets())
    targets = fmt::format("{}{}{}", name(target), targets.empty() ? "" : ", ", targets);
  say("cpu: works, SIMD {}\n", targets);
  const Chosen chosen = chosenOf(probes);
  say("--device auto is {} here: {}\n", chosen.device, chosen.reason);
}

}  // namespace

Command addDoctor(CLI::App& program) {
  auto json = std::make_shared<bool>(false);
  CLI::App* app =
      program.add_subcommand("doctor",
                             "Prints which devices work on this machine, and why others do not\n\n"
                             "  sluice doctor");
  addJsonOption(OptionGroup(*app, kOutputHeading), *json);
  return [json] {
    const std::vector<GlProbe> probes = probeGl();
    if (*json) {
      sayJson(asJson(probes));
    } else {
      print(probes);
    }
    return 0;
  };
}

}  // namespace sluice
