// The opacity functions of a source's whole series, made as the program makes them.
#pragma once

#include <memory>
#include <vector>

#include "src/index/series_pass.h"

namespace sluice {

struct TestSeries {
  std::shared_ptr<const SeriesOpacity> opacity;
  std::vector<StepBlocks> steps;
  SeriesPassReport report;
};

// `transfer` over the values of `ranges`, which belong to one step.
inline TestSeries makeTestSeries(VolumeSource& source, const BlockLayout& layout,
                                 const OpacityTable& table, SeriesPassOptions options = {},
                                 int threads = 2, uint64_t memory_bytes = UINT64_MAX) {
  TestSeries series;
  WorkerPool pool(threads);
  const ExtinctionTable extinction(table);
  ProgressMeter progress;
  for (int64_t time = 0; time < source.layout().time_steps; ++time)
    series.steps.emplace_back(buildSliceRanges(source, time, layout, {pool, progress}), extinction);
  series.opacity = std::make_shared<const SeriesOpacity>(
      makeSeriesOpacity(source, layout, series.steps, extinction, options,
                        {pool, progress, memory_bytes}, &series.report));
  return series;
}

}  // namespace sluice
