// A run as a page: its JSON report, and what numbers alone do not show.
#pragma once

#include <nlohmann/json.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace sluice {

struct PagePictures {
  std::vector<std::byte> picture_png;  // what was drawn; empty: none
  std::vector<std::byte> blocks_png;   // see block_map.h; empty: none
  std::string blocks_caption;
};

// Of a report of `render`, `plan`, `simulate` or a bench: what was asked and what followed from it,
// the time by stage, the four levels' bytes, blocks by class, rows of benches, and the JSON whole.
// What the report lacks has no section. A pure function; all text is escaped.
std::string runPage(const nlohmann::json& report, const PagePictures& pictures);

// A number as people read it, by the end of its name: bytes, seconds, others with four digits.
std::string readable(const std::string& name, const nlohmann::json& value);

// `sluice render bonsai.nii.gz --threshold 40 ...`, as the report's `options` have it; what stands
// there but is a default is said too.
std::string commandLineOf(const nlohmann::json& report);

}  // namespace sluice
