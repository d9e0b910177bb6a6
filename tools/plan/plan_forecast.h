// The forecast of a picture's memory as the plan command prints it.
#pragma once

#include <nlohmann/json.hpp>

#include "src/library/drawing/picture_cost.h"

namespace sluice {

// Adds the cost of another channel of the same picture, which has its own share of the memory. The
// least memory is left to the caller: a sum would be too little for channels that differ.
void add(Forecast& sum, const Forecast& more);

// `read`, `most_read` and `memory` of plan's JSON.
nlohmann::json readJson(const Forecast& forecast);
nlohmann::json mostReadJson(const Forecast& forecast);
nlohmann::json memoryJson(const Forecast& forecast);
void printForecast(const Forecast& forecast);

}  // namespace sluice
