// The interface between the program and its module for annotations.
//
// Cairo brings X11's libraries and the fonts' along. So all that draws with it is a library apart,
// sluice_annotate.so, opened with the first annotated picture (src/base/files/program_module.h says
// where from).
#pragma once

#include "src/annotate/annotate.h"

namespace sluice {

// The one function of the module: drawAnnotations() into `out`. Throws Error. Any thread.
using DrawAnnotations = void(const Picture& picture, const Annotations& annotations, int first_row,
                             Picture& out);
inline constexpr const char* kDrawAnnotations = "sluiceDrawAnnotations";

// The module exports this before anything is called: the version of sluice and of this interface.
inline constexpr const char* kAnnotateVersion = "sluiceAnnotateVersion";
inline constexpr const char* kAnnotateModuleVersion = SLUICE_VERSION " annotate module 2";

}  // namespace sluice
