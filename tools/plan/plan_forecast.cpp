#include "tools/plan/plan_forecast.h"

#include "src/base/values/bytes.h"
#include "tools/command_line/console.h"

namespace sluice {

nlohmann::json readJson(const Forecast& forecast) {
  return {{"blocks", forecast.blocks}, {"voxel_bytes", forecast.voxel_bytes}};
}

nlohmann::json mostReadJson(const Forecast& forecast) {
  return {{"blocks", forecast.most_blocks}, {"voxel_bytes", forecast.most_voxel_bytes}};
}

nlohmann::json memoryJson(const Forecast& forecast) {
  return {{"budget_bytes", forecast.budget_bytes},
          {"least_bytes", forecast.least_bytes},
          {"buffer_bytes", forecast.buffer_bytes},
          {"index_bytes", forecast.index_bytes},
          {"picture_bytes", forecast.picture_bytes},
          {"program_bytes", forecast.program_bytes},
          {"peak_bytes", forecast.peakBytes()},
          {"machine_bytes", forecast.machine_bytes},
          {"fits", forecast.fits()}};
}

void printForecast(const Forecast& forecast) {
  say("reads {} block{}, {} of voxels; {} of memory at most: {} of --memory {}, {} beside it\n",
      forecast.blocks, forecast.blocks == 1 ? "" : "s", formatBytes(forecast.voxel_bytes),
      formatBytes(forecast.peakBytes()), formatBytes(forecast.buffer_bytes),
      formatBytes(forecast.budget_bytes),
      formatBytes(forecast.peakBytes() - forecast.buffer_bytes));
  if (forecast.most_blocks > forecast.blocks)
    say("reads blocks up to {} times in all, {} of voxels, since --memory does not hold them all\n",
        forecast.most_blocks, formatBytes(forecast.most_voxel_bytes));
  if (!forecast.fits_budget) {
    say("does not fit --memory: {} is the least that works, or fewer --pages\n",
        formatBytes(forecast.least_bytes));
  } else {
    say("{} this machine, which has {}\n", forecast.fits() ? "fits" : "does not fit",
        formatBytes(forecast.machine_bytes));
  }
}

}  // namespace sluice
