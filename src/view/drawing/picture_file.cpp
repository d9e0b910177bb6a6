#include "src/view/drawing/picture_file.h"

#include <cctype>
#include <filesystem>

#include "src/base/error.h"
#include "src/options/option_rules.h"

namespace sluice {
namespace {

std::string endOf(const std::string& path) {
  std::string end = std::filesystem::path(path).extension().string();
  for (char& letter : end)
    letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  return end;
}

}  // namespace

void requirePictureName(const std::string& path) {
  const std::string end = endOf(path);
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
