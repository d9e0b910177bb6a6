// The arguments of `render` before anything is drawn: its frames, the files that it reads and
// writes, and the options that do not go together. Functions of the arguments; nothing is written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/command_line/outputs.h"
#include "tools/options/render_arguments.h"
#include "tools/outputs/picture_output.h"
#include "tools/scene/open_scene.h"
#include "tools/scene/ranks.h"

namespace sluice {

// The numbers of the frames that are still to be drawn; with ranks, those of the first rank, which
// writes them. `team`: null for a single process.
std::vector<int64_t> framesToDraw(const RenderArguments& arguments, Team* team);

// Whether an earlier run has left this picture. A picture appears whole or not at all, but a power
// cut or a copy may leave a part of one. Throws Error for a picture of another size, which is none
// of this series.
bool isDrawn(const RenderArguments& arguments, const std::filesystem::path& picture);
// The comparison of a run's options with those of an earlier run.
enum class Comparison { kNone, kByReport };
// Prints, unless quiet, that so many of the pictures stay as an earlier run has drawn them, and
// what would tell the options of that run.
void sayKept(const RenderArguments& arguments, int64_t kept, int64_t count, Comparison comparison);

// Whether the pictures of one frame that gets better are files of their own.
bool numbersPictures(const RenderArguments& arguments);
// All files that the command writes; `scene`: with the traces of its channels, which are known once
// it is open.
Outputs renderOutputs(const RenderArguments& arguments, const Scene* scene = nullptr);
PictureOutput pictureOutput(const RenderArguments& arguments);

// Names the picture after its volume if the user has named none, and annotates it then: nobody
// asked for the bare picture. Throws a usage error if a picture seems to be named without -o.
void nameOutput(RenderArguments& arguments);
// Throws Error, or a usage error, for options that do not go together.
void checkOutput(const RenderArguments& arguments);
// Reads the file of --path. Throws Error, which names it, if fields of its keys or options that the
// user gave have no effect beside its eyes.
void readPath(RenderArguments& arguments, const std::set<std::string>& given);
// Throws Error if the series lacks the last step asked for, in any channel that is shown.
void checkLastStep(const RenderArguments& arguments);
// The cut to draw from. Throws Error if levels are asked for with --culling.
std::optional<CutOptions> cutOf(const RenderArguments& arguments, Team* team);

// Whether a signal leaves a report of the pictures that were there by then: --continue draws the
// others and reports all.
bool reportsParts(const RenderArguments& arguments);
// Whether the scene's frames are rows of pictures that get better: a volume of one level has no
// coarser picture to begin with.
bool isRefined(const RenderArguments& arguments, const Scene& scene);
// Throws Error for options that a picture of several channels cannot have.
void requireOneChannel(const RenderArguments& arguments, const Scene& scene);
// Whether pictures may be drawn in strips: options that look at the whole picture need it whole.
Strips stripsOf(const RenderArguments& arguments, Team* team);
// Throws a usage error if options that look at one picture are given for a row that gets better.
void requireOnePicture(const RenderArguments& arguments, const Scene& scene);

}  // namespace sluice
