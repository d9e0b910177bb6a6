#include "src/annotate/annotate.h"

#include <algorithm>

#include "src/annotate/annotate_module.h"
#include "src/annotate/parts.h"
#include "src/base/error.h"
#include "src/base/files/program_module.h"

namespace sluice {

double emOf(PictureSize size) {
  constexpr double kLettersAPicture = 34, kLeastEm = 8;
  return std::max(kLeastEm, std::min(size.width, size.height) / kLettersAPicture);
}

Room annotationRoom(PictureSize size) {
  const double em = emOf(size);
  return {.right = (kColorBarEms + kFreeEms) * em / size.width,
          .bottom = (kScaleBarEms + kFreeEms) * em / size.height};
}

Picture annotated(const Picture& picture, const Annotations& annotations, int first_row) {
  Picture drawn;
  try {
    openModule({"sluice_annotate.so", "sluice's module for --annotate; install libcairo2",
                kAnnotateVersion, kAnnotateModuleVersion})
        .get<DrawAnnotations*>(kDrawAnnotations)(picture, annotations, first_row, drawn);
  } catch (const Error& error) {
    failAs(error.kind(), "no annotations: {}", error.what());
  }
  return drawn;
}

}  // namespace sluice
