// Draws annotations. Part of the module (annotate_module.h); the program calls annotated().
#pragma once

#include "src/annotate/annotate.h"

namespace sluice {

// The function behind annotated(), with its requirements and errors.
Picture drawAnnotations(const Picture& picture, const Annotations& annotations, int first_row = 0);

}  // namespace sluice
