#include "io/files/xml_scanner.h"

#include <expat.h>

#include <exception>
#include <memory>
#include <type_traits>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr size_t kPieceBytes = 64 << 10;
// The parser holds a tag until it has all of it.
constexpr uint64_t kMostTagBytes = 1 << 20;
constexpr int kDeepest = 64;

struct Scan {
  XML_Parser parser = nullptr;
  const XmlHandlers* handlers = nullptr;
  int depth = 0;
  bool has_doctype = false, is_too_deep = false, is_stopped = false;
  std::exception_ptr failure;

  // Exceptions do not pass through the library.
  template <class Call>
  void guarded(const Call& call) {
    try {
      call();
    } catch (...) {
      failure = std::current_exception();
      XML_StopParser(parser, XML_FALSE);
    }
  }
};

void beginTag(void* user, const XML_Char* name, const XML_Char** attributes) {
  Scan& scan = *static_cast<Scan*>(user);
  if (++scan.depth > kDeepest) {
    scan.is_too_deep = true;
    XML_StopParser(scan.parser, XML_FALSE);
    return;
  }
  if (!scan.handlers->begin) return;
  scan.guarded([&] {
    XmlTag tag;
    tag.name = name;
    for (; *attributes != nullptr; attributes += 2)
      tag.attributes.emplace_back(attributes[0], attributes[1]);
    tag.content_at = static_cast<uint64_t>(XML_GetCurrentByteIndex(scan.parser)) +
                     static_cast<uint64_t>(XML_GetCurrentByteCount(scan.parser));
    if (scan.handlers->begin(tag)) return;
    scan.is_stopped = true;
    XML_StopParser(scan.parser, XML_FALSE);
  });
}

void endTag(void* user, const XML_Char* name) {
  Scan& scan = *static_cast<Scan*>(user);
  --scan.depth;
  if (scan.handlers->end)
    scan.guarded([&] {
      scan.handlers->end(name, static_cast<uint64_t>(XML_GetCurrentByteIndex(scan.parser)));
    });
}

void someText(void* user, const XML_Char* text, int length) {
  Scan& scan = *static_cast<Scan*>(user);
  if (scan.handlers->text)
    scan.guarded([&] { scan.handlers->text({text, static_cast<size_t>(length)}); });
}

void beginDoctype(void* user, const XML_Char*, const XML_Char*, const XML_Char*, int) {
  Scan& scan = *static_cast<Scan*>(user);
  scan.has_doctype = true;
  XML_StopParser(scan.parser, XML_FALSE);
}

}  // namespace

std::optional<std::string_view> XmlTag::find(std::string_view attribute) const {
  for (const auto& [name_of, value] : attributes)
    if (name_of == attribute) return value;
  return std::nullopt;
}

void scanXml(const ByteInput& input, const std::string& path, const XmlHandlers& handlers) {
  Scan scan;
  scan.handlers = &handlers;
  const std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)> parser(
      XML_ParserCreate(nullptr), &XML_ParserFree);
  if (!parser) failMemory("{}: not enough memory to read it", path);
  scan.parser = parser.get();
  XML_SetUserData(parser.get(), &scan);
  XML_SetElementHandler(parser.get(), beginTag, endTag);
  XML_SetCharacterDataHandler(parser.get(), someText);
  // Entities of a document type may expand to gigabytes or name other files.
  XML_SetStartDoctypeDeclHandler(parser.get(), beginDoctype);
  for (uint64_t offset = 0;;) {
    void* const room = XML_GetBuffer(parser.get(), kPieceBytes);
    if (room == nullptr) failMemory("{}: not enough memory to read it", path);
    const size_t got = input(offset, {static_cast<std::byte*>(room), kPieceBytes});
    offset += got;
    const bool is_last = got < kPieceBytes;
    const XML_Status status = XML_ParseBuffer(parser.get(), static_cast<int>(got), is_last);
    if (scan.failure) std::rethrow_exception(scan.failure);
    if (scan.is_stopped) return;
    if (scan.has_doctype)
      fail("{}: expected XML without a document type declaration, found one", path);
    if (scan.is_too_deep)
      fail("{}: expected at most {} elements inside each other", path, kDeepest);
    if (status != XML_STATUS_OK)
      fail("{}: expected XML, found {} in line {}", path,
           XML_ErrorString(XML_GetErrorCode(parser.get())), XML_GetCurrentLineNumber(parser.get()));
    if (is_last) return;
    // The parser keeps a tag that has begun, so that one without an end would take the whole file
    // into memory.
    const XML_Index begun = XML_GetCurrentByteIndex(parser.get());
    if (begun < 0 || offset - static_cast<uint64_t>(begun) > kMostTagBytes + kPieceBytes)
      fail("{}: expected tags of at most {} bytes, found a longer one", path, kMostTagBytes);
  }
}

}  // namespace sluice
