// File names, and other words that are not ours, as people see them and paste them into a shell. A
// name may hold anything but a zero byte: a newline, or the escape sequences of a terminal. Pure
// functions.
#pragma once

#include <string>
#include <string_view>

namespace sluice {

// The word as a shell reads it back: itself; in single quotes if it must be; or, if it holds
// characters that should not reach a terminal, as $'...' with escapes (bash, zsh, ksh).
std::string shellWord(std::string_view word);

// A name on a line of output: itself, or shellWord() if it holds characters that should not reach a
// terminal.
std::string shownName(std::string_view name);

// Text that is safe for a terminal: control characters (but those in `kept`), bytes that are no
// UTF-8 and marks that turn the direction of writing become escapes such as \n or \x1b.
std::string withoutControls(std::string_view text, std::string_view kept = "");

}  // namespace sluice
