// Saved views that must be refused: each number of a view with each kind of wrong value, one at a
// time, in a view that is right otherwise.
#pragma once

#include <string>
#include <vector>

namespace sluice {

struct WrongState {
  std::string field;  // JSON pointer to the wrong field, as in the message, or to its parent
  std::string json;   // the file
};

// The volume that a right view of this table is of: 24 x 20 x 16 voxels, one time step.
inline constexpr const char* kStateVolume = "synth:shells,dims=24x20x16";

// A view that is right, with every field that wrongStates() spoils, except those that it does not
// have beside others. It names no volume.
std::string rightState();
// Returns at least 200 states.
std::vector<WrongState> wrongStates();

}  // namespace sluice
