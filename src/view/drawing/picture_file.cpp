#include "src/view/drawing/picture_file.h"

#include <filesystem>

#include "src/base/error.h"
#include "src/base/values/letter_case.h"
#include "src/options/option_rules.h"

namespace sluice {
void requirePictureName(const std::string& path) {
  const std::string end = lowercase(std::filesystem::path(path).extension().string());
  if (end != ".png" && end != ".exr") failRequest("{}: pictures are written as .png or .exr", path);
}

void drawToFile(Renderer& renderer, const std::string& path, const ViewState& state, int width,
                int height, const ProgressFunction& progress, const std::stop_token& stop) {
  renderer.drawToFile(path, pictureOf(state, width, height), state.background, progress, stop);
}

void placeKeys(ViewPath& path, Renderer& renderer, const ProgressFunction& progress,
               const std::stop_token& stop) {
  constexpr int kWidth = 800, kHeight = 600;  // any: eye and target are given
  for (ViewKey& key : path.keys)
    if (!key.state.view.up) {
      // The renderer may have another look than the key, which its light need not fit.
      PictureOptions picture = pictureOf(key.state, kWidth, kHeight);
      picture.lighting = {};
      picture.jitter.reset();
      key.state.view = renderer.placed(picture, progress, stop);
    }
}

}  // namespace sluice
