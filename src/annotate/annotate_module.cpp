#include "src/annotate/annotate_module.h"

#include "src/annotate/annotation_drawing.h"

extern "C" const char* sluiceAnnotateVersion();
extern "C" void sluiceDrawAnnotations(const sluice::Picture& picture,
                                      const sluice::Annotations& annotations, int first_row,
                                      sluice::Picture& out);

extern "C" const char* sluiceAnnotateVersion() {
  return sluice::kAnnotateModuleVersion;
}

extern "C" void sluiceDrawAnnotations(const sluice::Picture& picture,
                                      const sluice::Annotations& annotations, int first_row,
                                      sluice::Picture& out) {
  out = sluice::drawAnnotations(picture, annotations, first_row);
}
