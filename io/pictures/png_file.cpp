#include "io/pictures/png_file.h"

#include <png.h>

#include <cstring>
#include <exception>
#include <functional>
#include <span>
#include <utility>

#include "io/files/file.h"
#include "src/base/error.h"
#include "src/base/files/atomic_file.h"
#include "src/base/files/file_kind.h"

namespace sluice {
namespace {

// The state for libpng's callbacks while it writes. It leaves by longjmp, which runs no
// destructors, so nothing that needs one stands between setjmp and the jump.
struct Writer {
  std::function<void(std::span<const std::byte>)> sink;
  png_structp png = nullptr;
  png_infop info = nullptr;
  char message[200] = "";
  std::exception_ptr thrown;          // by the sink, kept while libpng's frames are left
  std::string mark = softwareMark();  // outlives the jump
  png_text software{};
  StopToken stop;

  Writer(decltype(sink) to, StopToken stop_token)
      : sink(std::move(to)), stop(std::move(stop_token)) {
    software.compression = PNG_TEXT_COMPRESSION_NONE;
    software.key = const_cast<char*>("Software");  // libpng only reads it
    software.text = mark.data();
    software.text_length = mark.size();
  }
  ~Writer() { png_destroy_write_struct(&png, &info); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  void keepMessage(const char* text) {
    if (message[0] == '\0') std::strncpy(message, text, sizeof message - 1);
  }
  static void onError(png_structp p, png_const_charp text) {
    static_cast<Writer*>(png_get_error_ptr(p))->keepMessage(text);
    png_longjmp(p, 1);
  }
  static void onWarning(png_structp, png_const_charp) {}
  static void onWrite(png_structp p, png_bytep from, size_t bytes) {
    if (!static_cast<Writer*>(png_get_io_ptr(p))->write(from, bytes)) png_error(p, "write failed");
  }
  static void onFlush(png_structp) {}
  bool write(png_bytep from, size_t bytes) noexcept {
    try {
      sink({reinterpret_cast<const std::byte*>(from), bytes});
      return true;
    } catch (...) {
      thrown = std::current_exception();
      return false;
    }
  }

  bool begin(int width, int height) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_set_write_fn(png, this, onWrite, onFlush);
    png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 8,
                 PNG_COLOR_TYPE_RGBA, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_text(png, info, &software, 1);
    png_write_info(png, info);
    return true;
  }
  bool addRows(const Rgba8Picture& rows) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    const size_t row_bytes = size_t{4} * static_cast<size_t>(rows.width);
    for (size_t y = 0; y < static_cast<size_t>(rows.height); ++y) {
      if (stop.isStopRequested()) return false;
      png_write_row(png, rows.rgba.data() + y * row_bytes);
    }
    return true;
  }
  bool end() {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_write_end(png, nullptr);
    return true;
  }
};

// A PNG in the making; `name` is what messages call it.
class Encoder {
 public:
  Encoder(int width, int height, std::string name, decltype(Writer::sink) sink,
          const StopToken& stop = {})
      : name_(std::move(name)), writer_(std::move(sink), stop) {
    SLUICE_CHECK(width > 0 && height > 0);
    // ~Writer() frees both structs, also if this constructor throws: members are complete by then.
    writer_.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &writer_, Writer::onError,
                                          Writer::onWarning);
    writer_.info = writer_.png == nullptr ? nullptr : png_create_info_struct(writer_.png);
    if (writer_.info == nullptr) failSystem("{}: libpng cannot be used (version or memory)", name_);
    require(writer_.begin(width, height));
  }
  void addRows(const Rgba8Picture& rows) {
    SLUICE_CHECK_EQ(rows.rgba.size(),
                    size_t{4} * static_cast<size_t>(rows.width) * static_cast<size_t>(rows.height));
    require(writer_.addRows(rows));
  }
  void end() { require(writer_.end()); }

 private:
  void require(bool is_written) const {
    writer_.stop.throwIfStopped();
    // The sink's own error first: it says why, libpng only that a write failed.
    if (writer_.thrown) std::rethrow_exception(writer_.thrown);
    if (!is_written) failSystem("{}: cannot be written: {}", name_, writer_.message);
  }

  const std::string name_;
  Writer writer_;
};

}  // namespace

std::vector<std::byte> encodedPng(const Rgba8Picture& picture) {
  std::vector<std::byte> bytes;
  Encoder encoder(picture.width, picture.height, "a PNG picture",
                  [&bytes](std::span<const std::byte> more) {
                    bytes.insert(bytes.end(), more.begin(), more.end());
                  });
  encoder.addRows(picture);
  encoder.end();
  return bytes;
}

struct PngFile::Impl {
  AtomicFile file;
  int width, rows_left;
  Encoder encoder;

  Impl(const std::filesystem::path& path, int width_px, int height_px, const StopToken& stop)
      : file(path),
        width(width_px),
        rows_left(height_px),
        encoder(
            width_px, height_px, path.string(),
            [this](std::span<const std::byte> more) { file.write(more); }, stop) {}
};

PngFile::PngFile(const std::filesystem::path& path, int width, int height, const StopToken& stop)
    : impl_(std::make_unique<Impl>(path, width, height, stop)) {}

PngFile::~PngFile() = default;

void PngFile::add(const Rgba8Picture& rows) {
  SLUICE_CHECK_EQ(rows.width, impl_->width);
  SLUICE_CHECK_LE(rows.height, impl_->rows_left);
  impl_->encoder.addRows(rows);
  impl_->rows_left -= rows.height;
}

void PngFile::commit() {
  SLUICE_CHECK_EQ(impl_->rows_left, 0);
  impl_->encoder.end();
  impl_->file.commit();
}

void writePng(const std::filesystem::path& path, const Rgba8Picture& picture,
              const StopToken& stop) {
  PngFile file(path, picture.width, picture.height, stop);
  file.add(picture);
  file.commit();
}

void writePng(const std::filesystem::path& path, const Picture& picture, const StopToken& stop) {
  writePng(path, toRgba8(picture), stop);
}

Rgba8Picture readPng(const std::filesystem::path& path) {
  constexpr uint64_t kMaxPixels = uint64_t{1} << 28;
  File file(path);
  std::vector<std::byte> stored(file.sizeBytes());
  file.readAt(0, stored);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&image, stored.data(), stored.size()) == 0)
    fail("{}: no readable PNG: {}", path.string(), image.message);
  // The header alone is read so far: a few bytes may claim a picture of any size.
  if (uint64_t{image.width} * image.height > kMaxPixels) {
    png_image_free(&image);
    fail("{}: PNG of {} x {} pixels, expected at most {}", path.string(), image.width, image.height,
         kMaxPixels);
  }
  image.format = PNG_FORMAT_RGBA;
  Rgba8Picture picture{static_cast<int>(image.width), static_cast<int>(image.height), {}};
  picture.rgba.resize(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, picture.rgba.data(), 0, nullptr) == 0)
    fail("{}: damaged PNG: {}", path.string(), image.message);
  return picture;
}

}  // namespace sluice
