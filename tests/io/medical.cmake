sluice_test(io_medical
  SOURCES
    file_test.cpp
    raw_name_test.cpp
    raw_source_test.cpp
    raw_test.cpp
    volume_files.cpp
  DEPENDS sluice_io)
