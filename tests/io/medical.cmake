find_package(ZLIB REQUIRED)
sluice_test(io_medical
  SOURCES
    file_set_test.cpp
    file_test.cpp
    meta_image_test.cpp
    nifti_test.cpp
    nrrd_test.cpp
    raw_name_test.cpp
    raw_source_test.cpp
    raw_test.cpp
    real_headers_test.cpp
    spool_test.cpp
    volume_files.cpp
  DEPENDS sluice_io ZLIB::ZLIB)
