// For builds with a sanitizer: what other people's libraries do is not reported, so that what we do
// is. OSMesa keeps its screen and one framebuffer description a context at exit; OpenVDB loses the
// tree that it was reading when a damaged file makes it throw; TBB, OpenVDB and the exceptions of
// the C++ library synchronise where ThreadSanitizer, which did not compile them, cannot see it.
// Options in LSAN_OPTIONS and TSAN_OPTIONS go on top.
#pragma once

namespace sluice {

// Does nothing: a program that has error.cpp, where this is called, has the lists linked in.
void linkSanitizerOptions();

}  // namespace sluice
