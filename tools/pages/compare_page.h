// Compares several runs side by side: the numbers of their JSON reports, each against the first
// run's.
#pragma once

#include <nlohmann/json.hpp>

#include <span>
#include <string>
#include <vector>

namespace sluice {

struct NamedReport {
  std::string name;  // the file's
  nlohmann::json report;
};

// A number that some of the runs report, by its name in the JSON with dots; rows of lists by their
// labels. Leaves out the fields that tell how a run was made (options, volume, look, GL).
struct ComparedNumber {
  std::string name;
  std::vector<nlohmann::json> values;  // one per run; null: that run lacks it
};
std::vector<ComparedNumber> compared(std::span<const NamedReport> runs);

// The ratio of a run's number to the first run's; none if either is missing or the first is 0.
std::string ratioText(const ComparedNumber& number, size_t run);

// The page: options that differ, speeds as bars, and all numbers. Pure functions.
std::string comparePage(std::span<const NamedReport> runs);

}  // namespace sluice
