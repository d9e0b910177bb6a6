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

// Options that are not in the table of options: of a volume, of the machine and of the pipeline.
constexpr std::array kFields = std::to_array<Field>({
    {"--algorithm", "pipeline.algorithm"},
    {"--block", "block"},
    {"--cache", "web.cache_bytes"},
    {"--cache-dir", "web.cache_folder"},
    {"--channel", "channel"},
    {"--device", "device"},
    {"--dims", "dims"},
    {"--endian", "big_endian"},
    {"--gl", "pipeline.gl"},
    {"--grid", "grid"},
    {"--index-dir", "index_folder"},
    {"--levels", "levels"},
    {"--memory", "memory_bytes"},
    {"--merge", "pipeline.merge"},
    {"--occlusion", "pipeline.occlusion"},
    {"--over", "over"},
    {"--page", "page"},
    {"--pages", "pipeline.pages"},
    {"--partition", "pipeline.partition"},
    {"--policy", "pipeline.policy"},
    {"--seed", "pipeline.seed"},
    {"--simd", "pipeline.simd"},
    {"--size", "width and height"},
    {"--skip", "skip_bytes"},
    {"--spacing", "spacing"},
    {"--this-step", "whole_series"},
    {"--threads", "threads"},
    {"--time-steps", "time_steps"},
    {"--type", "type"},
});

std::string fieldOf(std::string_view option) {
  for (const OptionEntry& entry : optionTable()) {
    const std::vector<std::string_view> names = optionNames(entry);
    if (!entry.field.empty() && std::ranges::find(names, option) != names.end()) return entry.field;
  }
  const auto* field = std::ranges::find(kFields, option, &Field::option);
  return std::string(field == kFields.end() ? option : field->name);
}

}  // namespace

std::string inFields(std::string_view line) {
  return renamed(line, fieldOf);
}

}  // namespace sluice
