# The transfer functions' part of the layer.
find_package(nlohmann_json REQUIRED)
set(TRANSFER_SOURCES
  automatic_transfer.cpp color_maps.cpp color_spaces.cpp histogram_analysis.cpp
  paraview_map.cpp transfer_file.cpp transfer_function.cpp transfer_makers.cpp)
