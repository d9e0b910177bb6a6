// Checks of a view's numbers: whether they can be drawn at all, and whether they fit a volume. A
// saved view is checked before anything is drawn with it, and the window checks every change that
// the user makes. Pure functions.
//
// The folder: the parts of the window that know neither windows nor drawing, as pure functions and
// plain values. Here, what holds of any view; editing/ changes a view, files/ keeps views and
// settings and lists folders, and screen/ works on the window's events and pixels.
#pragma once

#include <sluice/volume.h>

#include <optional>
#include <string>

#include "src/options/option_table.h"
#include "src/options/view_state.h"
#include "src/view/state/view_path.h"

namespace sluice {

// A number that cannot be drawn, in the words of a saved view.
struct ViewFault {
  std::string field;  // JSON pointer in the saved view: "/camera/zoom"
  std::string expected, found;
};

// The first number of an option that its kind does not take. nullopt: there is none. `field`: the
// option's place.
std::optional<ViewFault> faultOf(const OptionKind& kind, const OptionValue& value,
                                 const std::string& field = {});
// The first number that is wrong whatever the volume is: not finite, beyond the limits of the
// options of the same names, a camera without a direction. nullopt: there is none.
std::optional<ViewFault> faultOf(const ViewState& state);
// The first number that does not fit this volume: a time step, a crop box or a cross hair that lies
// outside. nullopt: there is none.
std::optional<ViewFault> faultOf(const ViewState& state, const VolumeInfo& volume);

// Throws Error, starting with `where`, for the first number of the view or of its key frames that
// does not fit the volume.
void requireFits(const ViewState& state, const std::optional<ViewPath>& path,
                 const VolumeInfo& volume, const std::string& where);

// "/path/keys/2": the place of the key frame `index` in a saved view.
std::string keyPlace(size_t index);

}  // namespace sluice
