# Headers followed by voxels: raw, NRRD, MetaImage, NIfTI.
find_package(ZLIB REQUIRED)
target_sources(sluice_io PRIVATE
  byte_store.cpp
  described_volume.cpp
  file.cpp
  file_set.cpp
  header_fields.cpp
  inflater.cpp
  meta_image.cpp
  meta_image_header.cpp
  nifti.cpp
  nifti_header.cpp
  nrrd.cpp
  nrrd_header.cpp
  raw.cpp
  raw_name.cpp
  raw_source.cpp
  spool.cpp
  swap_bytes.cpp
  text_voxels.cpp
  volume_description.cpp)
target_link_libraries(sluice_io PRIVATE ZLIB::ZLIB)
