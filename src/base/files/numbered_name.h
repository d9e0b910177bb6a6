// The names of files that are written in numbers: frames of a turntable, steps of a series. Pure
// functions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace sluice {

// File number `number` of the name that a user gave. "####" or "%04d" in it (one of them) takes the
// number, in at least as many digits. A name without either gets "_007" before its extension if
// `numbered`, and is the file itself otherwise. Throws Error when a pattern is not understood.
std::filesystem::path numberedName(const std::string& name, int64_t number, bool numbered);

}  // namespace sluice
