// A run as a page: its JSON report, and pictures of what numbers alone do not show.
#pragma once

#include <nlohmann/json.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace sluice {

struct PagePictures {
  std::vector<std::byte> picture_png;  // the picture that was drawn; empty: none
  std::vector<std::byte> blocks_png;   // see block_map.h; empty: none
  std::string blocks_caption;
};

// The page for a report of `render`, `plan`, `simulate` or a bench: options and results, the time
// by stage, the four levels' bytes, blocks by class, rows of benches, and the whole JSON. A section
// is left out if the report lacks its fields. A pure function; all text is escaped.
std::string runPage(const nlohmann::json& report, const PagePictures& pictures);

// A number as people read it, by the end of its name: bytes, seconds, others with four digits.
std::string readable(const std::string& name, const nlohmann::json& value);

// `sluice render bonsai.nii.gz --threshold 40 ...`, from the report's `options`; defaults in it are
// included.
std::string commandLineOf(const nlohmann::json& report);

}  // namespace sluice
