#include "io/pictures/exr_file.h"

#include <OpenEXR/ImfArray.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <exception>
#include <span>
#include <string_view>

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

// What OpenEXR writes to. OpenEXR swallows what fails while it ends a file, where it fills in its
// table of lines: the first failure is kept here, to be thrown when it is through.
class ExrStream : public Imf::OStream {
 public:
  ExrStream(AtomicFile& file, const std::string& name, const StopToken& stop)
      : Imf::OStream(name.c_str()), file_(file), stop_(stop) {}

  void write(const char bytes[], int count) override {
    if (failure_ == nullptr) try {
        stop_.throwIfStopped();
        file_.writeAt(at_, std::as_bytes(std::span(bytes, static_cast<size_t>(count))));
      } catch (...) {
        failure_ = std::current_exception();
      }
    if (failure_ != nullptr) std::rethrow_exception(failure_);
    at_ += static_cast<uint64_t>(count);
  }
  uint64_t tellp() override { return at_; }
  void seekp(uint64_t to) override { at_ = to; }

  // Throws what write() threw first.
  void throwFailure() const {
    if (failure_ != nullptr) std::rethrow_exception(failure_);
  }

 private:
  AtomicFile& file_;
  const StopToken stop_;
  uint64_t at_ = 0;
  std::exception_ptr failure_;
};

bool isOfThePicture(std::string_view channel) {
  return channel == "Z" ||
         std::find(kChannels.begin(), kChannels.end(), channel) != kChannels.end();
}

template <class Attribute, class Values>
void insertAll(Imf::Header& header, const std::filesystem::path& path, const Values& values) {
  for (const auto& [name, value] : values) {
    constexpr size_t kMaxName = 255;
    if (name.empty() || name.size() > kMaxName || header.find(name) != header.end())
      fail("{}: \"{}\" cannot name an attribute of an EXR file", path.string(), name);
    header.insert(name, Attribute(value));
  }
}

// A matrix attribute out of 16 floats.
struct MatrixAttribute : Imf::M44fAttribute {
  explicit MatrixAttribute(const std::array<float, 16>& m)
      : Imf::M44fAttribute({m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10],
                            m[11], m[12], m[13], m[14], m[15]}) {}
};

Imf::Header makeHeader(const std::filesystem::path& path, const ExrContents& contents) {
  Imf::Header header(contents.picture.width, contents.picture.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  header.screenWindowWidth() = contents.screen_window_width;
  Imf::addChromaticities(header, Imf::Chromaticities());  // Rec. 709's
  insertAll<Imf::StringAttribute>(header, path, contents.attributes);
  insertAll<MatrixAttribute>(header, path, contents.matrices);
  return header;
}

}  // namespace

void writeExr(const std::filesystem::path& path, const ExrContents& contents,
              ExrPrecision precision, const StopToken& stop) {
  const Picture& picture = contents.picture;
  const size_t pixels = static_cast<size_t>(picture.width) * static_cast<size_t>(picture.height);
  SLUICE_CHECK(picture.width > 0 && picture.height > 0);
  SLUICE_CHECK_EQ(picture.rgba.size(), kPixelFloats * pixels);
  SLUICE_CHECK(picture.depth.empty() || picture.depth.size() == pixels);
  AtomicFile file(path);
  ExrStream stream(file, path.string(), stop);
  try {
    Imf::Header header = makeHeader(path, contents);
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
    const auto add = [&](const std::string& name, const std::vector<float>& values) {
      header.channels().insert(name, Imf::Channel(Imf::FLOAT));
      buffer.insert(name, floatSlice(const_cast<float*>(values.data()), window, 1, 0));
    };
    if (!picture.depth.empty()) add("Z", picture.depth);
    for (const auto& [name, values] : contents.channels) {
      SLUICE_CHECK_EQ(values.size(), pixels);
      if (name.empty() || isOfThePicture(name))
        fail("{}: \"{}\" cannot name a further channel", path.string(), name);
      add(name, values);
    }
    Imf::OutputFile output(stream, header);
    output.setFrameBuffer(buffer);
    output.writePixels(picture.height);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    stream.throwFailure();
    fail("{}: cannot be written: {}", path.string(), e.what());
  }
  stream.throwFailure();
  stop.throwIfStopped();
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
    for (auto it = header.channels().begin(); it != header.channels().end(); ++it)
      if (!isOfThePicture(it.name())) result.channels.push_back({it.name(), {}});
    for (ExrChannel& channel : result.channels) {
      channel.values.resize(static_cast<size_t>(width * height));
      buffer.insert(channel.name, floatSlice(channel.values.data(), window, 1, 0));
    }
    input.setFrameBuffer(buffer);
    input.readPixels(window.min.y, window.max.y);
    for (auto it = header.begin(); it != header.end(); ++it) {
      if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute()))
        result.attributes.emplace_back(it.name(), text->value());
      if (const auto* matrix = dynamic_cast<const Imf::M44fAttribute*>(&it.attribute())) {
        result.matrices.emplace_back(it.name(), std::array<float, 16>{});
        std::copy_n(matrix->value().getValue(), 16, result.matrices.back().second.begin());
      }
    }
    result.screen_window_width = header.screenWindowWidth();
    return result;
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    fail("{}: no readable EXR: {}", path.string(), e.what());
  }
}

}  // namespace sluice
