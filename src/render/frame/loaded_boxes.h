// The steps that frames of one volume and of several channels share: chunks made resident, their
// boxes, and the counts of a plan.
#pragma once

#include <functional>

#include "src/render/blocks/visible_blocks.h"
#include "src/render/frame/frame_plan.h"
#include "src/render/frame/frame_report.h"
#include "src/render/session/read_ahead.h"
#include "src/render/session/residency.h"

namespace sluice {

// The box of a block of the plan. Its chunk is not set.
BoxDraw boxDraw(const TexturePlan& textures, const TextureBlock& block);

// Makes the chunks of a step resident and adds the work to `report`. `may_lack`: chunks whose
// texels were not there in time are left out; otherwise they are read now. `request` is told each
// chunk before it is asked for. Throws as Residency::makeResident() and ReadAhead::takeOne() do.
void loadChunks(const ReadAhead::Taken& taken, const FramePlan& plan, ReadAhead& ahead,
                Residency& residency, bool may_lack, FrameReport& report,
                const std::function<void(ChunkPosition, ChunkName)>& request = {});

// The report of a frame of which no block shows anything.
FrameReport reportWithoutBlocks(const VisibleBlocks& visible, double step_vox);

// Sets the counts of blocks, of the plan and of reading.
void addCounts(const VisibleBlocks& visible, const FramePlan& plan, const ReadTally& tally,
               FrameReport& report);

}  // namespace sluice
