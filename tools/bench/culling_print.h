// The report of `sluice bench culling` for people: a table for each figure of Gao 2004.
#pragma once

#include <nlohmann/json.hpp>

namespace sluice {

void printCulling(const nlohmann::json& report);

}  // namespace sluice
