// Error: bad input or a bad environment, one line for a person. CHECK: a mistake of ours.
//
// Error is the one that users of the library catch, so its header is theirs; the program catches it
// once, in main. Other libraries' exceptions are translated where the library is used (io/,
// src/gl/). Expected outcomes (a miss, not resident) are return values.
#pragma once

#include <fmt/format.h>
#include <sluice/error.h>

#include <string>

namespace sluice {

// Throws Error with a line made from a fmt format string. Start it with the path.
template <class... Args>
[[noreturn]] void failAs(Error::Kind kind, fmt::format_string<Args...> format, Args&&... args) {
  throw Error(fmt::format(format, std::forward<Args>(args)...), kind);
}
template <class... Args>
[[noreturn]] void fail(fmt::format_string<Args...> format, Args&&... args) {
  failAs(Error::Kind::kInput, format, std::forward<Args>(args)...);
}
template <class... Args>
[[noreturn]] void failRequest(fmt::format_string<Args...> format, Args&&... args) {
  failAs(Error::Kind::kRequest, format, std::forward<Args>(args)...);
}
template <class... Args>
[[noreturn]] void failMemory(fmt::format_string<Args...> format, Args&&... args) {
  failAs(Error::Kind::kMemory, format, std::forward<Args>(args)...);
}
template <class... Args>
[[noreturn]] void failSystem(fmt::format_string<Args...> format, Args&&... args) {
  failAs(Error::Kind::kSystem, format, std::forward<Args>(args)...);
}

// Error with strerror(error_number) at the end: "<what>: <reason>". Its kind is kInput if a name
// leads to no file that may be used, and kSystem otherwise.
[[noreturn]] void failErrno(const std::string& what, int error_number);
// The kind of a failed call of the system.
Error::Kind kindOf(int error_number);

namespace internal {
[[noreturn]] void checkFailed(const char* file, int line, const char* condition,
                              const std::string& values);
template <class A, class B>
std::string describe(const A& a, const B& b) {
  if constexpr (fmt::is_formattable<A>::value && fmt::is_formattable<B>::value) {
    return fmt::format("{} against {}", a, b);
  } else {
    return "values that do not print";
  }
}
}  // namespace internal
}  // namespace sluice

// Abort with file, line and both values: an invariant of ours does not hold.
#define SLUICE_CHECK(condition)                                                            \
  do {                                                                                     \
    if (!(condition)) ::sluice::internal::checkFailed(__FILE__, __LINE__, #condition, ""); \
  } while (false)
#define SLUICE_CHECK_OP(a, op, b)                                                        \
  do {                                                                                   \
    const auto& check_a_ = (a);                                                          \
    const auto& check_b_ = (b);                                                          \
    if (!(check_a_ op check_b_))                                                         \
      ::sluice::internal::checkFailed(__FILE__, __LINE__, #a " " #op " " #b,             \
                                      ::sluice::internal::describe(check_a_, check_b_)); \
  } while (false)
#define SLUICE_CHECK_EQ(a, b) SLUICE_CHECK_OP(a, ==, b)
#define SLUICE_CHECK_LE(a, b) SLUICE_CHECK_OP(a, <=, b)
#define SLUICE_CHECK_LT(a, b) SLUICE_CHECK_OP(a, <, b)
