#include "io/exr_file.h"

#include <OpenEXR/ImfArray.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <array>
#include <cstddef>

#include "src/base/atomic_file.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr std::array<const char*, 4> kChannels{"R", "G", "B", "A"};
constexpr size_t kPixelFloats = 4;

// OpenEXR's files are addressed from a pixel (0, 0) that need not be theirs.
Imf::Slice floatSlice(float* pixels, const Imath::Box2i& window, size_t stride_floats,
                      double fill) {
  const auto width = static_cast<size_t>(window.max.x) - static_cast<size_t>(window.min.x) + 1;
  return Imf::Slice::Make(Imf::FLOAT, pixels, window, stride_floats * sizeof(float),
                          stride_floats * sizeof(float) * width, 1, 1, fill);
}

Imf::Header makeHeader(const std::filesystem::path& path, const Picture& picture,
                       const ExrAttributes& attributes) {
  Imf::Header header(picture.width, picture.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const auto& [name, text] : attributes) {
    constexpr size_t kMaxName = 255;
    if (name.empty() || name.size() > kMaxName || header.find(name) != header.end())
      fail("{}: \"{}\" cannot name an attribute of an EXR file", path.string(), name);
    header.insert(name, Imf::StringAttribute(text));
  }
  return header;
}

}  // namespace

void writeExr(const std::filesystem::path& path, const Picture& picture,
              const ExrAttributes& attributes, ExrPrecision precision) {
  const size_t pixels = static_cast<size_t>(picture.width) * static_cast<size_t>(picture.height);
  SLUICE_CHECK(picture.width > 0 && picture.height > 0);
  SLUICE_CHECK_EQ(picture.rgba.size(), kPixelFloats * pixels);
  SLUICE_CHECK(picture.depth.empty() || picture.depth.size() == pixels);
  AtomicFile file(path);
  try {
    Imf::Header header = makeHeader(path, picture, attributes);
    const Imath::Box2i window = header.dataWindow();
    Imf::FrameBuffer buffer;
    // OpenEXR writes halves only out of halves.
    std::vector<Imath::half> halves;
    // It takes the pixels by a pointer to non-const, and only reads them.
    auto* const rgba = const_cast<float*>(picture.rgba.data());
    if (precision == ExrPrecision::kHalf) halves.assign(picture.rgba.begin(), picture.rgba.end());
    for (size_t c = 0; c < kChannels.size(); ++c) {
      const bool is_half = precision == ExrPrecision::kHalf;
      header.channels().insert(kChannels[c], Imf::Channel(is_half ? Imf::HALF : Imf::FLOAT));
      const size_t stride = kPixelFloats * sizeof(Imath::half);
      buffer.insert(kChannels[c],
                    is_half ? Imf::Slice::Make(Imf::HALF, halves.data() + c, window, stride,
                                               stride * static_cast<size_t>(picture.width))
                            : floatSlice(rgba + c, window, kPixelFloats, 0));
    }
    if (!picture.depth.empty()) {
      header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
      buffer.insert("Z", floatSlice(const_cast<float*>(picture.depth.data()), window, 1, 0));
    }
    Imf::OutputFile output(file.temporaryPath().c_str(), header);
    output.setFrameBuffer(buffer);
    output.writePixels(picture.height);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    fail("{}: cannot be written: {}", path.string(), e.what());
  }
  file.commit();
}

ExrContents readExr(const std::filesystem::path& path) {
  constexpr int64_t kMaxPixels = int64_t{1} << 28;
  try {
    Imf::InputFile input(path.c_str());
    const Imf::Header& header = input.header();
    const Imath::Box2i window = header.dataWindow();
    const int64_t width = int64_t{window.max.x} - window.min.x + 1;
    const int64_t height = int64_t{window.max.y} - window.min.y + 1;
    if (width < 1 || height < 1 || width > kMaxPixels / height)
      fail("{}: EXR of {} x {} pixels, expected 1 to {} in all", path.string(), width, height,
           kMaxPixels);
    ExrContents result;
    Picture& picture = result.picture;
    picture.width = static_cast<int>(width);
    picture.height = static_cast<int>(height);
    picture.rgba.resize(kPixelFloats * static_cast<size_t>(width * height));
    Imf::FrameBuffer buffer;
    for (size_t c = 0; c < kChannels.size(); ++c)
      buffer.insert(kChannels[c],
                    floatSlice(picture.rgba.data() + c, window, kPixelFloats, c == 3 ? 1 : 0));
    if (header.channels().findChannel("Z") != nullptr) {
      picture.depth.resize(static_cast<size_t>(width * height));
      buffer.insert("Z", floatSlice(picture.depth.data(), window, 1, 0));
    }
    input.setFrameBuffer(buffer);
    input.readPixels(window.min.y, window.max.y);
    for (auto it = header.begin(); it != header.end(); ++it) {
      if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute()))
        result.attributes.emplace_back(it.name(), text->value());
    }
    return result;
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    fail("{}: no readable EXR: {}", path.string(), e.what());
  }
}

}  // namespace sluice
