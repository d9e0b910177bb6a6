#include "io/dicom/dicom_module.h"

#include <dlfcn.h>
#include <gdcmFragment.h>
#include <gdcmJPEG2000Codec.h>
#include <gdcmJPEGCodec.h>
#include <gdcmJPEGLSCodec.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>

#include <cstring>
#include <exception>
#include <mutex>

namespace sluice {
namespace {

// A frame as GDCM takes it.
gdcm::DataElement elementOf(std::span<const std::byte> code) {
  gdcm::Fragment fragment;
  fragment.SetByteValue(reinterpret_cast<const char*>(code.data()),
                        static_cast<uint32_t>(code.size()));
  const gdcm::SmartPointer<gdcm::SequenceOfFragments> fragments = new gdcm::SequenceOfFragments;
  fragments->AddFragment(fragment);
  gdcm::DataElement element(gdcm::Tag(0x7fe0, 0x0010), 0, gdcm::VR::OB);
  element.SetValue(*fragments);
  return element;
}

// Decodes by a codec itself: GDCM's class for images starts another program if one fails.
template <class Codec>
bool decode(const DicomPixelForm& form, std::span<const std::byte> code,
            std::span<std::byte> pixels) {
  Codec codec;
  const unsigned dims[3] = {static_cast<unsigned>(form.columns), static_cast<unsigned>(form.rows),
                            1};
  codec.SetNumberOfDimensions(2);
  codec.SetDimensions(dims);
  codec.SetPlanarConfiguration(0);
  codec.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  codec.SetPixelFormat(gdcm::PixelFormat(1, static_cast<uint16_t>(form.bits_allocated),
                                         static_cast<uint16_t>(form.bits_stored),
                                         static_cast<uint16_t>(form.high_bit), form.is_signed));
  gdcm::DataElement decoded;
  if (!codec.Decode(elementOf(code), decoded)) return false;
  const gdcm::ByteValue* const bytes = decoded.GetByteValue();
  // Padded to an even number.
  if (bytes == nullptr || bytes->GetLength() < pixels.size() ||
      bytes->GetLength() > pixels.size() + 1)
    return false;
  std::memcpy(pixels.data(), bytes->GetPointer(), pixels.size());
  return true;
}

// GDCM prints to standard error what sluice says itself.
void muteTraces() {
  static std::once_flag once;
  std::call_once(once, [] {
    gdcm::Trace::DebugOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
  });
}

// The front of libjpeg's table of error handlers (jpeg_error_mgr in its jpeglib.h).
struct JpegErrors {
  void (*exit)(void* codec);
  void (*emit)(void* codec, int level);
  void (*print)(void* codec);
};

// Fills the table as the library's own function of that name does, but for printing.
void* setJpegErrors(const char* name, void* errors) {
  const auto set = reinterpret_cast<void* (*)(void*)>(dlsym(RTLD_NEXT, name));
  set(errors);
  static_cast<JpegErrors*>(errors)->print = [](void* /*codec*/) {};
  return errors;
}

void printNothing(const char* /*message*/, void* /*data*/) {}

}  // namespace
}  // namespace sluice

// The three libjpegs within GDCM print each fault of a stream to standard error. GDCM finds these
// before the libraries' own, because a module's functions come before those of its libraries.
extern "C" void* gdcmjpeg8_jpeg_std_error(void* errors) {
  return sluice::setJpegErrors("gdcmjpeg8_jpeg_std_error", errors);
}
extern "C" void* gdcmjpeg12_jpeg_std_error(void* errors) {
  return sluice::setJpegErrors("gdcmjpeg12_jpeg_std_error", errors);
}
extern "C" void* gdcmjpeg16_jpeg_std_error(void* errors) {
  return sluice::setJpegErrors("gdcmjpeg16_jpeg_std_error", errors);
}

// As GDCM has OpenJPEG print its messages.
extern "C" int opj_set_error_handler(void* codec, void (*)(const char*, void*), void* data) {
  using Set = int (*)(void*, void (*)(const char*, void*), void*);
  return reinterpret_cast<Set>(dlsym(RTLD_NEXT, "opj_set_error_handler"))(
      codec, sluice::printNothing, data);
}

extern "C" const char* sluiceDicomVersion() {
  return sluice::kDicomModuleVersion;
}

extern "C" bool sluiceDecodeDicomFrame(sluice::DicomCoding coding,
                                       const sluice::DicomPixelForm& form,
                                       std::span<const std::byte> code,
                                       std::span<std::byte> pixels) {
  using namespace sluice;
  muteTraces();
  try {
    switch (coding) {
      case DicomCoding::kJpeg:
        return decode<gdcm::JPEGCodec>(form, code, pixels);
      case DicomCoding::kJpegLs:
        return decode<gdcm::JPEGLSCodec>(form, code, pixels);
      case DicomCoding::kJpeg2000:
        return decode<gdcm::JPEG2000Codec>(form, code, pixels);
      default:
        return false;
    }
  } catch (const std::exception&) {
    return false;
  }
}
