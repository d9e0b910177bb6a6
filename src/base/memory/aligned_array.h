// AlignedArray: an array for bytes that are read from files, at the begin of a line of the caches.
//
// Allocators place large arrays 16 bytes behind the begin of a page. AMD's Zen 3 copies from a page
// of the file cache to such a place at a fifth of the speed of any other (2.2 instead of 11 GB/s):
// its `rep movsb` is slow if the destination lies 1 to 31 bytes behind the source, modulo a page.
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>

namespace sluice {

inline constexpr std::align_val_t kArrayAlignment{64};

struct FreeAligned {
  void operator()(void* array) const { ::operator delete(array, kArrayAlignment); }
};

template <class T>
using AlignedArray = std::unique_ptr<T[], FreeAligned>;

// Its elements are not set to anything.
template <class T>
AlignedArray<T> alignedForOverwrite(size_t count) {
  static_assert(std::is_trivially_default_constructible_v<T> &&
                std::is_trivially_destructible_v<T>);
  return AlignedArray<T>(static_cast<T*>(::operator new(count * sizeof(T), kArrayAlignment)));
}

}  // namespace sluice
