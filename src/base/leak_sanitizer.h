// For builds with AddressSanitizer: what other people's libraries leave allocated is not reported,
// so that a leak of ours is. OSMesa keeps its screen and one framebuffer description a context;
// OpenVDB loses the tree that it was reading when a damaged file makes it throw. Options in
// LSAN_OPTIONS go on top.
#pragma once

namespace sluice {

// Does nothing: who calls it has the list linked in. Called where such a library is first used.
void linkLeakSuppressions();

}  // namespace sluice
