// Keywords of functions as C++ values.
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <concepts>
#include <optional>
#include <string>
#include <type_traits>

namespace sluice::python {

namespace py = pybind11;

template <class T>
inline constexpr bool kIsArray = false;
template <class T>
inline constexpr bool kIsArray<std::array<T, 3>> = true;

// What values of a keyword that becomes a T are, for people.
template <class T>
constexpr const char* kindOf() {
  if constexpr (std::same_as<T, bool>)
    return "True or False";
  else if constexpr (std::same_as<T, std::string>)
    return "text";
  else if constexpr (kIsArray<T>)
    return std::integral<typename T::value_type> ? "three whole numbers" : "three numbers";
  else if constexpr (std::unsigned_integral<T>)
    return "a whole number from 0";
  else if constexpr (std::integral<T>)
    return "a whole number";
  else
    return "a number";
}

template <class T>
void castKeyword(const char* keyword, const py::handle& value, T& held) {
  try {
    held = value.cast<T>();
  } catch (const py::cast_error&) {
    throw py::type_error(std::string(keyword) + ": expected " + kindOf<T>() + ", found " +
                         py::repr(value).cast<std::string>());
  }
}
template <class T>
void castKeyword(const char* keyword, const py::handle& value, std::optional<T>& held) {
  castKeyword(keyword, value, held.emplace());
}

// Leaves `held` as it is for a keyword that is missing or None. Throws TypeError, which names the
// keyword.
template <class T>
void takeKeyword(const py::dict& keywords, const char* keyword, T& held) {
  if (keywords.contains(keyword) && !keywords[keyword].is_none())
    castKeyword(keyword, keywords[keyword], held);
}

}  // namespace sluice::python
