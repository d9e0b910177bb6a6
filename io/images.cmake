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
target_link_libraries(sluice_io PRIVATE sluice_openvdb PNG::PNG TIFF::TIFF OpenEXR::OpenEXR)
