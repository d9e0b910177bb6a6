// The channels of an OME-Zarr image: the member "omero" of its attributes. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "src/base/sources/volume_channels.h"

namespace sluice {

class JsonField;

// The channels' names, printable; an empty one has none. None at all: the member lists no channels.
std::vector<std::string> omeroNames(const JsonField& omero);
// Their looks, as many; empty: the member gives no colour and no window.
std::vector<StoredLook> omeroLooks(const JsonField& omero);
// The looks that are passed over since they contradict themselves, in a few words each.
std::vector<std::string> omeroFaults(const JsonField& omero);

}  // namespace sluice
