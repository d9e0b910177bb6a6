#include "src/library/option_fields.h"

#include <algorithm>
#include <array>

#include "src/base/field_names.h"
#include "src/options/option_table.h"

namespace sluice {
namespace {

struct Field {
  std::string_view option, name;
};

// Options that are not in the table of options: of the machine and of the pipeline.
constexpr std::array kFields = std::to_array<Field>({
    {"--algorithm", "pipeline.algorithm"},
    {"--block", "block"},
    {"--cache", "web.cache_bytes"},
    {"--cache-dir", "web.cache_folder"},
    {"--device", "device"},
    {"--gl", "pipeline.gl"},
    {"--index-dir", "index_folder"},
    {"--levels", "levels"},
    {"--memory", "memory_bytes"},
    {"--merge", "pipeline.merge"},
    {"--occlusion", "pipeline.occlusion"},
    {"--page", "page"},
    {"--pages", "pipeline.pages"},
    {"--partition", "pipeline.partition"},
    {"--policy", "pipeline.policy"},
    {"--seed", "pipeline.seed"},
    {"--simd", "pipeline.simd"},
    {"--size", "width and height"},
    {"--this-step", "whole_series"},
    {"--threads", "threads"},
});

// The field of the entry that has the option; empty: none has.
std::string fieldIn(const auto& table, std::string_view option) {
  for (const auto& entry : table) {
    const std::vector<std::string_view> names = optionNames(entry);
    if (std::ranges::find(names, option) != names.end()) return entry.field;
  }
  return "";
}

std::string fieldOf(std::string_view option) {
  for (std::string field : {fieldIn(optionTable(), option), fieldIn(volumeTable(), option)})
    if (!field.empty()) return field;
  const auto* field = std::ranges::find(kFields, option, &Field::option);
  return std::string(field == kFields.end() ? option : field->name);
}

}  // namespace

std::string inFields(std::string_view line) {
  return renamed(line, fieldOf);
}

}  // namespace sluice
