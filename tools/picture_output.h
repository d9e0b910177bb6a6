// How `render` writes a picture: as PNG, with annotations where asked for, or as EXR with what a
// compositing program needs to know.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "src/render/frame_options.h"
#include "tools/scene.h"

namespace sluice {

// Channels of an EXR beside the picture's colour and alpha.
struct Aovs {
  bool depth = false;
  bool opacity = false;  // of the volume alone, also over a background
};
// "depth,opacity", "none".
std::optional<Aovs> parseAovs(std::string_view list);

enum class PictureKind { kPng, kExr };
// By the name's extension in any case; nullopt: neither.
std::optional<PictureKind> pictureKind(const std::filesystem::path& path);

struct PictureOutput {
  std::optional<std::array<float, 3>> background;
  bool annotate = false;  // PNG
  Aovs aovs;              // EXR
};

// Over its background and with its annotations, as PNG files and films show it.
Picture shownPicture(const Picture& picture, const PictureOutput& output,
                     const FrameOptions& options, const Scene& scene);
// `options` are the frame's. Throws Error, and Interrupted.
void writePicture(const std::filesystem::path& path, const Picture& picture,
                  const PictureOutput& output, const FrameOptions& options, const Scene& scene);

}  // namespace sluice
