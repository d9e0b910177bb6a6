// Whether values are those of a CT in Hounsfield units: air at -1000, water at 0, bone from some
// 200 on.
//
// Pure functions of the counts.
#pragma once

#include "src/base/sources/volume_source.h"
#include "src/base/values/value_counts.h"

namespace sluice {

// From this value on there is bone.
inline constexpr double kBone = 200;

// The counts without the padding around a CT's field of view: a value or two far below air.
ValueCounts withoutPadding(ValueCounts counts);
// Whether air and tissue lie at a CT's values, and nothing at values that a CT does not have.
// Values that end below bone must be mostly air and tissue, with less between them, as those of no
// field are. `values`: without padding.
bool looksLikeHounsfield(const ValueCounts& values);
// Whether there is enough bone to show it alone. `values`: without padding.
bool hasBone(const ValueCounts& values);

}  // namespace sluice
