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
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "src/base/error.h"
#include "src/base/files/atomic_file.h"

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

// The stream that OpenEXR writes to. OpenEXR swallows failures while it ends a file and fills in
// its table of lines, so the first failure is kept here and thrown after it has returned.
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

  // Throws the first failure of write().
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

Imf::Header makeHeader(const std::filesystem::path& path, const ExrContents& contents, int height) {
  Imf::Header header(contents.picture.width, height);
  header.compression() = Imf::ZIP_COMPRESSION;
  header.screenWindowWidth() = contents.screen_window_width;
  Imf::addChromaticities(header, Imf::Chromaticities());  // Rec. 709's
  insertAll<Imf::StringAttribute>(header, path, contents.attributes);
  insertAll<MatrixAttribute>(header, path, contents.matrices);
  return header;
}

// The memory from which OpenEXR takes some rows of a file of `header`, from row `first_row` on.
class RowsOfFile {
 public:
  RowsOfFile(const ExrContents& rows, const Imf::Header& header, int first_row,
             ExrPrecision precision)
      : width_(static_cast<size_t>(rows.picture.width)), first_row_(first_row) {
    const Picture& picture = rows.picture;
    const size_t pixels = width_ * static_cast<size_t>(picture.height);
    SLUICE_CHECK_EQ(picture.rgba.size(), kPixelFloats * pixels);
    SLUICE_CHECK(picture.depth.empty() || picture.depth.size() == pixels);
    if (precision == ExrPrecision::kHalf) halves_.assign(picture.rgba.begin(), picture.rgba.end());
    for (size_t c = 0; c < kChannels.size(); ++c)
      if (precision == ExrPrecision::kHalf)
        add(kChannels[c], Imf::HALF, halves_.data() + c, kPixelFloats);
      else
        add(kChannels[c], Imf::FLOAT, picture.rgba.data() + c, kPixelFloats);
    if (!picture.depth.empty()) add("Z", Imf::FLOAT, picture.depth.data(), 1);
    for (const auto& [name, values] : rows.channels) {
      SLUICE_CHECK_EQ(values.size(), pixels);
      add(name, Imf::FLOAT, values.data(), 1);
    }
    for (auto it = header.channels().begin(); it != header.channels().end(); ++it)
      SLUICE_CHECK(buffer_.findSlice(it.name()) != nullptr);
  }
  const Imf::FrameBuffer& buffer() const { return buffer_; }

 private:
  // OpenEXR addresses rows from row 0 on, which need not be there, by a pointer to non-const, and
  // only reads them.
  template <class T>
  void add(const std::string& name, Imf::PixelType type, const T* first, size_t stride) {
    const size_t x_stride = stride * sizeof(T), y_stride = x_stride * width_;
    // NOLINTNEXTLINE(performance-no-int-to-ptr): a pointer may not be moved out of its array
    auto* const row_0 = reinterpret_cast<char*>(reinterpret_cast<uintptr_t>(first) -
                                                static_cast<size_t>(first_row_) * y_stride);
    buffer_.insert(name, Imf::Slice(type, row_0, x_stride, y_stride));
  }

  const size_t width_;
  const int first_row_;
  std::vector<Imath::half> halves_;  // OpenEXR writes halves only out of halves
  Imf::FrameBuffer buffer_;
};

void addChannels(Imf::Header& header, const std::filesystem::path& path,
                 const ExrContents& contents, ExrPrecision precision) {
  for (const char* channel : kChannels)
    header.channels().insert(
        channel, Imf::Channel(precision == ExrPrecision::kHalf ? Imf::HALF : Imf::FLOAT));
  if (!contents.picture.depth.empty()) header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
  for (const ExrChannel& channel : contents.channels) {
    if (channel.name.empty() || isOfThePicture(channel.name))
      fail("{}: \"{}\" cannot name a further channel", path.string(), channel.name);
    header.channels().insert(channel.name, Imf::Channel(Imf::FLOAT));
  }
}

}  // namespace

struct ExrFile::Impl {
  const std::filesystem::path path;
  const ExrPrecision precision;
  const int width, height;
  const StopToken stop;
  AtomicFile file;
  ExrStream stream;
  std::optional<Imf::OutputFile> output;  // writes to `stream` until it is destroyed
  int rows_done = 0;

  Impl(const std::filesystem::path& path_of_file, ExrPrecision precision_of_colors, int width_px,
       int height_px, const StopToken& stop_token)
      : path(path_of_file),
        precision(precision_of_colors),
        width(width_px),
        height(height_px),
        stop(stop_token),
        file(path),
        stream(file, path.string(), stop) {}

  // Calls body() and throws OpenEXR's exceptions as an Error of ours.
  template <class Body>
  void writing(const Body& body) {
    try {
      body();
    } catch (const Error&) {
      throw;
    } catch (const std::exception& e) {
      // The stream's own failure (a full disk) tells more than OpenEXR's words about it.
      stream.throwFailure();
      failSystem("{}: cannot be written: {}", path.string(), e.what());
    }
    stream.throwFailure();
    stop.throwIfStopped();
  }
};

ExrFile::ExrFile(const std::filesystem::path& path, const ExrContents& first, int height,
                 ExrPrecision precision, const StopToken& stop)
    : impl_(std::make_unique<Impl>(path, precision, first.picture.width, height, stop)) {
  SLUICE_CHECK(impl_->width > 0 && height > 0);
  impl_->writing([&] {
    Imf::Header header = makeHeader(path, first, height);
    addChannels(header, path, first, precision);
    impl_->output.emplace(impl_->stream, header);
  });
}

ExrFile::~ExrFile() = default;

void ExrFile::add(const ExrContents& rows) {
  SLUICE_CHECK_EQ(rows.picture.width, impl_->width);
  SLUICE_CHECK_LE(rows.picture.height, impl_->height - impl_->rows_done);
  impl_->writing([&] {
    const RowsOfFile added(rows, impl_->output->header(), impl_->rows_done, impl_->precision);
    impl_->output->setFrameBuffer(added.buffer());
    impl_->output->writePixels(rows.picture.height);
  });
  impl_->rows_done += rows.picture.height;
}

void ExrFile::commit() {
  SLUICE_CHECK_EQ(impl_->rows_done, impl_->height);
  impl_->writing([&] { impl_->output.reset(); });
  impl_->file.commit();
}

void writeExr(const std::filesystem::path& path, const ExrContents& contents,
              ExrPrecision precision, const StopToken& stop) {
  ExrFile file(path, contents, contents.picture.height, precision, stop);
  file.add(contents);
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
    // A data window is read from the file; its product must not overflow before memory is taken.
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
                    // Files without a channel A are opaque.
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
