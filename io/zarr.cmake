# Zarr stores: OME-Zarr images and plain arrays, read and packed.
find_package(nlohmann_json REQUIRED)
find_path(BLOSC_INCLUDE_DIR blosc.h)
find_library(BLOSC_LIBRARY blosc)
if(NOT BLOSC_INCLUDE_DIR OR NOT BLOSC_LIBRARY)
  message(FATAL_ERROR "Blosc is missing: install libblosc-dev (tools/setup.sh does)")
endif()
find_path(ZSTD_INCLUDE_DIR zstd.h)
find_library(ZSTD_LIBRARY zstd)
if(NOT ZSTD_INCLUDE_DIR OR NOT ZSTD_LIBRARY)
  message(FATAL_ERROR "zstd is missing: install libzstd-dev (tools/setup.sh does)")
endif()

target_sources(sluice_io PRIVATE
  zarr_array.cpp
  zarr_checksums.cpp
  zarr_chunk_cache.cpp
  zarr_chunk_files.cpp
  zarr_codec.cpp
  zarr_image.cpp
  zarr_pack_folder.cpp
  zarr_source.cpp
  zarr_text.cpp
  zarr_writer.cpp)
target_include_directories(sluice_io PRIVATE ${BLOSC_INCLUDE_DIR} ${ZSTD_INCLUDE_DIR})
target_link_libraries(sluice_io PRIVATE ${BLOSC_LIBRARY} ${ZSTD_LIBRARY})
