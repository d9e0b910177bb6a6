sluice_test(io_images
  SOURCES exr_file_test.cpp file_list_test.cpp open_volume_test.cpp png_file_test.cpp sequence_test.cpp
          slice_stack_test.cpp vdb_source_test.cpp vdb_writer.cpp
  DEPENDS sluice_io sluice_test_support sluice_openvdb)
target_compile_definitions(test_io_images PRIVATE SLUICE_TEST_DIR="${CMAKE_CURRENT_LIST_DIR}")
