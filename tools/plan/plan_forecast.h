// The forecast of a picture's memory as the plan command prints it.
#pragma once

#include <nlohmann/json.hpp>

#include "src/library/drawing/cost/picture_cost.h"

namespace sluice {

// `read`, `most_read` and `memory` of plan's JSON.
nlohmann::json readJson(const Forecast& forecast);
nlohmann::json mostReadJson(const Forecast& forecast);
nlohmann::json memoryJson(const Forecast& forecast);
void printForecast(const Forecast& forecast);

}  // namespace sluice
