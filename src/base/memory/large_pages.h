// Memory in large pages, for the few vectors of many megabytes that a command fills once: the
// kernel hands out 2 MiB at a time instead of 4 KiB, which costs less than filling them does. It is
// a hint: nothing changes if the kernel has no such pages. Any thread.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace sluice {

// Asks for large pages under `memory`, wherever a whole one fits inside: no more memory is taken
// than is used.
void preferLargePages(std::span<std::byte> memory);

// values.reserve(count), in large pages.
template <class T>
void reserveLarge(std::vector<T>& values, size_t count) {
  values.reserve(count);
  preferLargePages({reinterpret_cast<std::byte*>(values.data()), values.capacity() * sizeof(T)});
}

}  // namespace sluice
