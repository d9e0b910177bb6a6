# The transfer functions' part of the layer.
find_package(nlohmann_json REQUIRED)
set(TRANSFER_SOURCES
  automatic_transfer.cpp color_maps.cpp histogram.cpp histogram_analysis.cpp transfer_function.cpp transfer_makers.cpp)
