# OpenVDB, pictures as slices, sequences of files, the choice of a reader, and the pictures that we write.
find_package(PNG REQUIRED)
find_package(TIFF REQUIRED)
find_package(OpenEXR 3.1 CONFIG REQUIRED)
find_package(TBB CONFIG REQUIRED)
find_path(OPENVDB_INCLUDE_DIR openvdb/openvdb.h)
find_library(OPENVDB_LIBRARY openvdb)
if(NOT OPENVDB_INCLUDE_DIR OR NOT OPENVDB_LIBRARY)
  message(FATAL_ERROR "OpenVDB is missing: install libopenvdb-dev (tools/setup.sh does)")
endif()
add_library(sluice_openvdb INTERFACE)
target_include_directories(sluice_openvdb SYSTEM INTERFACE ${OPENVDB_INCLUDE_DIR})
target_link_libraries(sluice_openvdb INTERFACE ${OPENVDB_LIBRARY} TBB::tbb OpenEXR::OpenEXR)

# Opened by vdb_source.cpp when it is wanted: see vdb_module.h.
add_library(sluice_openvdb_module MODULE vdb_module.cpp)
set_target_properties(sluice_openvdb_module PROPERTIES
  OUTPUT_NAME sluice_openvdb PREFIX "" LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})
target_link_libraries(sluice_openvdb_module PRIVATE sluice_base sluice_openvdb)
install(TARGETS sluice_openvdb_module LIBRARY DESTINATION lib/sluice)
add_dependencies(sluice_io sluice_openvdb_module)
set_source_files_properties(vdb_source.cpp PROPERTIES
  COMPILE_DEFINITIONS SLUICE_OPENVDB_MODULE="sluice_openvdb.so")

target_sources(sluice_io PRIVATE
  exr_file.cpp
  file_list.cpp
  open_volume.cpp
  picture.cpp
  png_file.cpp
  png_slice.cpp
  sequence.cpp
  slice_picture.cpp
  slice_stack.cpp
  tiff_slice.cpp
  vdb_check.cpp
  vdb_header.cpp
  vdb_reader.cpp
  vdb_source.cpp)
target_link_libraries(sluice_io PRIVATE PNG::PNG TIFF::TIFF OpenEXR::OpenEXR)
