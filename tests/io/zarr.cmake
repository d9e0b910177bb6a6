sluice_test(io_zarr
  SOURCES zarr_chunk_cache_test.cpp zarr_header_test.cpp zarr_source_test.cpp zarr_writer_test.cpp
  DEPENDS sluice_io sluice_test_support)
target_compile_definitions(test_io_zarr PRIVATE SLUICE_TEST_DIR="${CMAKE_CURRENT_LIST_DIR}")
