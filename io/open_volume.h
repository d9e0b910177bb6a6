// The one way in: from a user's name on the command line to a VolumeSource.
//
// The file's first bytes decide which reader opens it, or its extension if they do not tell. A name
// is a file (NRRD, MetaImage, NIfTI, VTK, OpenVDB, PNG, TIFF, raw), a folder of slices, an OME-Zarr
// image, a Zarr array, an N5 group or its address on the web, a pattern ('slice-*.png',
// 'step_%03d.raw'), several of these, or a "synth:KIND,..." volume.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/open_options.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// Opens one name. Throws Error in one line: what is missing, damaged or not understood, and what
// was expected.
std::unique_ptr<VolumeSource> openVolume(const std::string& input, const OpenOptions& options = {});

// Several names, or one. Patterns are expanded in place. More than one file are the slices of one
// volume if they are pictures of one page, or raw files each of which has the bytes of a slice of
// `dims`. Otherwise they are the time steps of one volume, OpenVDB files in the box around all of
// theirs. They are taken in the order given, except for names that a shell has sorted as text:
// these are put in the order of their numbers (a note of the layout tells so, and which number is
// missing). Requires: inputs not empty.
std::unique_ptr<VolumeSource> openVolume(const std::vector<std::string>& inputs,
                                         const OpenOptions& options = {});

// The first file that is missing within a series of one file a step; if none is, the file that
// would be step `time` if the series went on that far. nullopt: no such series, or nothing is
// missing. Throws Error for a step that cannot be opened.
std::optional<std::string> missingStep(VolumeSource& source, int64_t time);
// The number in the name of each step's file in a series of one file a step; ascending. Empty: no
// such series. Throws Error for a step that cannot be opened.
std::vector<int64_t> numbersOfSteps(VolumeSource& source);

}  // namespace sluice
