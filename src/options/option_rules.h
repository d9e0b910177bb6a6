// Tells which options of a picture go together, on the command line, as keywords of the Python
// package, in the library and in saved views. Names are those of the command line. Pure functions.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "src/options/view_state.h"

namespace sluice {

struct OptionPair {
  std::string_view one, other;
};

// A picture takes one of the two.
std::span<const OptionPair> optionsApart();

// The first takes effect only with the second.
std::span<const OptionPair> optionNeeds();

// The message of the first value that has no effect beside the view's other values, such as
// surfaces in a mode that shows one value a pixel; nullopt: there is none. The message names
// options of the command line, see renamed().
std::optional<std::string> conflictIn(const ViewState& state);
// The view without such values. The window keeps them for when the user switches back, and draws
// and saves views without them.
ViewState withoutConflicts(ViewState state);
// Sets the value of an option that such a message may begin with to what asks for nothing.
void clearOption(std::string_view option, ViewState& state);
// The picture and the look of a view without such values, as a Renderer takes them.
PictureOptions pictureOf(const ViewState& state, int width, int height);
LookOptions lookOf(const ViewState& state);

}  // namespace sluice
