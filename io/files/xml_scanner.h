// XML read front to back: the elements of a document in order, however long it is.
//
// Nothing of the document is kept but one tag at a time, so that files with voxels between their
// tags can be scanned. A document type declaration is an Error: without one there are no entities
// that grow or name other files. One thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sluice {

// An opening tag.
struct XmlTag {
  std::string_view name;
  std::vector<std::pair<std::string_view, std::string_view>> attributes;
  uint64_t content_at = 0;  // offset of the first byte after the tag
  // nullopt: no such attribute.
  std::optional<std::string_view> find(std::string_view attribute) const;
};

// The views are valid during the call. Any may be empty.
struct XmlHandlers {
  // Returns whether to go on.
  std::function<bool(const XmlTag& tag)> begin;
  // `at`: the offset of the closing tag.
  std::function<void(std::string_view name, uint64_t at)> end;
  // A piece of text between tags.
  std::function<void(std::string_view text)> text;
};

// Reads up to as many bytes from an offset on; fewer at the end.
using ByteInput = std::function<size_t(uint64_t offset, std::span<std::byte> out)>;

// Throws Error, which starts with `path`: no XML up to where `begin` stopped, or to the end; tags
// that nest too deeply or are too long; and what the handlers throw.
void scanXml(const ByteInput& input, const std::string& path, const XmlHandlers& handlers);

}  // namespace sluice
