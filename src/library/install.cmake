# The library for other programs: every layer that it needs in one archive, the public headers, and
# the CMake package `sluice`. Included last, when all layers are known.
include(CMakePackageConfigHelpers)

# Where a library that is linked to comes from, in the words of find_dependency() and in those of
# pkg-config. Headers alone need no line: nothing of them shows in the public headers.
set(package_of_fmt::fmt "fmt")
set(package_of_Threads::Threads "Threads")
set(package_of_ZLIB::ZLIB "ZLIB")
set(package_of_PNG::PNG "PNG")
set(package_of_TIFF::TIFF "TIFF")
set(package_of_OpenEXR::OpenEXR "OpenEXR 3.1 CONFIG")
set(package_of_TBB::tbb "TBB CONFIG")
set(pc_of_fmt::fmt fmt)
set(pc_of_ZLIB::ZLIB zlib)
set(pc_of_PNG::PNG libpng)
set(pc_of_TIFF::TIFF libtiff-4)
set(pc_of_OpenEXR::OpenEXR OpenEXR)
set(pc_of_TBB::tbb tbb)
set(pc_of_PkgConfig::HWY libhwy)
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
target_include_directories(sluice_installed INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)

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

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/sluice)
configure_package_config_file(src/library/sluice-config.cmake.in ${CMAKE_BINARY_DIR}/package/sluice-config.cmake
  INSTALL_DESTINATION ${package_folder} PATH_VARS SLUICE_MODULE_DIR)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/package/sluice-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/package/sluice-config.cmake
              ${CMAKE_BINARY_DIR}/package/sluice-config-version.cmake src/library/module_folders.cpp
        DESTINATION ${package_folder} COMPONENT libsluice-dev)
install(TARGETS sluice_installed EXPORT sluice ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libsluice-dev)
install(EXPORT sluice NAMESPACE sluice:: FILE sluice-targets.cmake DESTINATION ${package_folder}
        COMPONENT libsluice-dev)
install(DIRECTORY include/sluice DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT libsluice-dev
        FILES_MATCHING PATTERN "*.h")

# pkg-config's file, which may be moved with its prefix. The archive needs what it is linked to in
# every program, so nothing is private.
set(SLUICE_PC_PACKAGES)
set(SLUICE_PC_LIBRARIES)
foreach(item ${others})
  if(DEFINED pc_of_${item})
    list(APPEND SLUICE_PC_PACKAGES ${pc_of_${item}})
  elseif(item STREQUAL Threads::Threads)
    string(APPEND SLUICE_PC_LIBRARIES " -pthread")
  elseif(item MATCHES "::")
    message(FATAL_ERROR "${item} is linked to the library: name its pkg-config file in src/library/install.cmake")
  else()
    string(REGEX REPLACE "^.*/lib([^/]+)\\.(so|a)$" "\\1" name ${item})
    string(APPEND SLUICE_PC_LIBRARIES " -l${name}")
  endif()
endforeach()
list(JOIN SLUICE_PC_PACKAGES ", " SLUICE_PC_PACKAGES)
file(RELATIVE_PATH SLUICE_PREFIX_FROM_PC ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(src/library/sluice.pc.in ${CMAKE_BINARY_DIR}/package/sluice.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/package/sluice.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT libsluice-dev)
