// For builds with a sanitizer: faults of other libraries are suppressed, so that our own are
// reported. OSMesa keeps its screen and one framebuffer description a context at exit. OpenVDB
// loses the tree that it was reading when a damaged file makes it throw. TBB, OpenVDB and the
// exceptions of the C++ library synchronise in ways that ThreadSanitizer, which did not compile
// them, cannot see. Options in LSAN_OPTIONS and TSAN_OPTIONS go on top.
#pragma once

namespace sluice {

// Does nothing. A program that has error.cpp, which calls this, has the lists linked in.
void linkSanitizerOptions();

}  // namespace sluice
