sluice_test(io_generated
  SOURCES synth_source_test.cpp raw_writer_test.cpp index_file_test.cpp
  DEPENDS sluice_io sluice_test_support)
