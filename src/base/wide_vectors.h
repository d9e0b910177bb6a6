// Code for the vectors of 32 bytes that most x86 processors have and that a program for all of them
// may not take for granted.
//
// Any thread.
#pragma once

namespace sluice {

#if defined(__x86_64__)
// Whether the processor has them.
inline bool hasWideVectors() {
  static const bool has = __builtin_cpu_supports("avx2") != 0;
  return has;
}

namespace internal {

// Everything that is called in it is compiled into it as far as its source is seen.
template <class Call>
[[gnu::target("avx2"), gnu::flatten]] void runWide(const Call& call) {
  call();
}

}  // namespace internal

// Calls `call`, compiled for wide vectors if the processor has them; the results are the same.
template <class Call>
void inWideVectors(const Call& call) {
  if (hasWideVectors())
    internal::runWide(call);
  else
    call();
}
#else
template <class Call>
void inWideVectors(const Call& call) {
  call();
}
#endif

}  // namespace sluice
