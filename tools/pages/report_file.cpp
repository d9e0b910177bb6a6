#include "tools/pages/report_file.h"

#include <algorithm>

#include "io/files/file.h"
#include "io/pictures/png_file.h"
#include "src/base/files/atomic_file.h"
#include "src/base/values/letter_case.h"
#include "tools/outputs/picture_output.h"
#include "tools/pages/block_map.h"

namespace sluice {

bool isPage(const std::filesystem::path& file) {
  const std::string end = lowercase(file.extension().string());
  return end == ".html" || end == ".htm";
}

FileKind reportKind(const std::filesystem::path& file) {
  return isPage(file) ? FileKind::kPage : FileKind::kReport;
}

void addBlocks(PagePictures& pictures, Vec3i grid, const VisibleBlocks& blocks) {
  const std::optional<BlockMap> map = blockMap(grid, blocks);
  if (!map) return;
  pictures.blocks_png = encodedPng(map->picture);
  pictures.blocks_caption = map->caption;
}

void addPicture(PagePictures& pictures, const std::filesystem::path& written,
                const Picture& drawn) {
  if (pictureKind(written) != PictureKind::kPng) {
    pictures.picture_png = encodedPng(toRgba8(drawn));
    return;
  }
  File file(written);
  pictures.picture_png.resize(file.sizeBytes());
  file.readAt(0, pictures.picture_png);
}

void writeReport(const std::string& file, const nlohmann::json& report,
                 const PagePictures& pictures) {
  nlohmann::json marked = report;
  marked["sluice"] = "report";  // by which the next run knows the file (FileKind)
  AtomicFile out(file);
  out.write(isPage(file)
                ? runPage(report, pictures)
                : marked.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  out.commit();
}

}  // namespace sluice
