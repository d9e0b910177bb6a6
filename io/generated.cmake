# Synthetic volumes, the writer of volumes, and the store of min-max indices.
target_sources(sluice_io PRIVATE
  synth_source.cpp synth_fields.cpp synth_phantom.cpp synth_noise.cpp synth_flow.cpp
  raw_writer.cpp index_file.cpp)
# The same voxels on every machine: no multiply-add in one rounding.
set_source_files_properties(synth_source.cpp synth_fields.cpp synth_phantom.cpp synth_noise.cpp
  synth_flow.cpp PROPERTIES COMPILE_OPTIONS -ffp-contract=off)
# Checksums at memory speed; the header alone is used.
find_path(XXHASH_INCLUDE_DIR xxhash.h)
if(NOT XXHASH_INCLUDE_DIR)
  message(FATAL_ERROR "xxhash.h not found: install libxxhash-dev (tools/setup.sh does)")
endif()
target_include_directories(sluice_io PRIVATE ${XXHASH_INCLUDE_DIR})
