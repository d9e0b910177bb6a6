# The library for other programs: every layer that it needs in one archive, the public headers, and
# the CMake package `sluice`. Included last, when all layers are known.
include(CMakePackageConfigHelpers)

# Where a library that is linked to comes from, in the words of find_dependency(). Headers alone
# need no line: nothing of them shows in the public headers.
set(package_of_fmt::fmt "fmt")
set(package_of_Threads::Threads "Threads")
set(package_of_ZLIB::ZLIB "ZLIB")
set(package_of_PNG::PNG "PNG")
set(package_of_TIFF::TIFF "TIFF")
set(package_of_OpenEXR::OpenEXR "OpenEXR 3.1 CONFIG")
set(package_of_TBB::tbb "TBB CONFIG")
set(plain_name_of_PkgConfig::HWY hwy)  # no CMake package: by name, as those that are linked by their path
set(header_libraries nlohmann_json::nlohmann_json sluice_options)

# All that sluice_library is linked to: layers of ours, and others.
set(waiting sluice_library)
set(layers)
set(others)
while(waiting)
  list(POP_FRONT waiting item)
  if(item IN_LIST header_libraries OR item IN_LIST layers OR item IN_LIST others)
    continue()
  elseif(item MATCHES "^sluice_" AND TARGET ${item})
    list(APPEND layers ${item})
    get_target_property(linked ${item} LINK_LIBRARIES)
    list(APPEND waiting ${linked})
  else()
    list(APPEND others ${item})
  endif()
endwhile()

set(objects)
foreach(layer ${layers})
  list(APPEND objects $<TARGET_OBJECTS:${layer}>)
endforeach()
add_library(sluice_installed STATIC ${objects})
set_target_properties(sluice_installed PROPERTIES
  OUTPUT_NAME sluice EXPORT_NAME sluice LINKER_LANGUAGE CXX)
target_compile_features(sluice_installed INTERFACE cxx_std_20)
target_include_directories(sluice_installed INTERFACE $<INSTALL_INTERFACE:include>)

# What has no package of its own is looked for by name.
set(SLUICE_DEPENDENCIES)
set(SLUICE_PLAIN_LIBRARIES)
foreach(item ${others})
  if(DEFINED package_of_${item})
    string(APPEND SLUICE_DEPENDENCIES "find_dependency(${package_of_${item}})\n")
    separate_arguments(package UNIX_COMMAND "${package_of_${item}}")
    find_package(${package} REQUIRED)  # the folders that did so kept it to themselves
  elseif(DEFINED plain_name_of_${item} OR item MATCHES "/lib([^/]+)\\.(so|a)$")
    set(name ${CMAKE_MATCH_1})
    if(DEFINED plain_name_of_${item})
      set(name ${plain_name_of_${item}})
      find_library(SLUICE_LIBRARY_${name} ${name} REQUIRED)
      set(item ${SLUICE_LIBRARY_${name}})
    endif()
    list(APPEND SLUICE_PLAIN_LIBRARIES ${name})
    add_library(sluice::${name} UNKNOWN IMPORTED)
    set_target_properties(sluice::${name} PROPERTIES IMPORTED_LOCATION ${item})
    set(item sluice::${name})
  elseif(item MATCHES "::")
    message(FATAL_ERROR "${item} is linked to the library: name its package in src/library/install.cmake")
  endif()
  target_link_libraries(sluice_installed PRIVATE ${item})
endforeach()

set(package_folder lib/cmake/sluice)
configure_package_config_file(src/library/sluice-config.cmake.in ${CMAKE_BINARY_DIR}/package/sluice-config.cmake
  INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/package/sluice-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/package/sluice-config.cmake
              ${CMAKE_BINARY_DIR}/package/sluice-config-version.cmake DESTINATION ${package_folder})
install(FILES src/library/module_folder.cpp DESTINATION ${package_folder})
install(TARGETS sluice_installed EXPORT sluice ARCHIVE DESTINATION lib)
install(EXPORT sluice NAMESPACE sluice:: FILE sluice-targets.cmake DESTINATION ${package_folder})
install(DIRECTORY include/sluice DESTINATION include FILES_MATCHING PATTERN "*.h")
