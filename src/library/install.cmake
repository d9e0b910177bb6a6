# The library for other programs: every layer that it needs in one archive and in one shared library, the
# public headers, and the CMake package `sluice`. Included last, when all layers are known.
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

# The same as a shared library, which exports the functions of the public headers alone. Before version 1
# each minor version may change them, so its name has both numbers. It finds the modules from its own place.
add_library(sluice_shared SHARED ${objects} src/library/module_folders.cpp)
file(RELATIVE_PATH modules_from_library ${CMAKE_INSTALL_FULL_LIBDIR} ${SLUICE_FULL_MODULE_DIR})
set_source_files_properties(src/library/module_folders.cpp PROPERTIES
  COMPILE_DEFINITIONS SLUICE_MODULE_FOLDERS=".:${modules_from_library}")
set_target_properties(sluice_shared PROPERTIES
  OUTPUT_NAME sluice EXPORT_NAME shared LINKER_LANGUAGE CXX VERSION ${PROJECT_VERSION}
  SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}
  LINK_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/exported_symbols.map)
target_link_options(sluice_shared PRIVATE
  -Wl,--version-script,${CMAKE_CURRENT_LIST_DIR}/exported_symbols.map -Wl,--no-undefined)
foreach(target sluice_installed sluice_shared)
  target_compile_features(${target} INTERFACE cxx_std_20)
  target_include_directories(${target} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
endforeach()

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
  target_link_libraries(sluice_shared PRIVATE ${item})
endforeach()

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/sluice)
configure_package_config_file(src/library/sluice-config.cmake.in ${CMAKE_BINARY_DIR}/package/sluice-config.cmake
  INSTALL_DESTINATION ${package_folder} PATH_VARS SLUICE_MODULE_DIR)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/package/sluice-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/package/sluice-config.cmake
              ${CMAKE_BINARY_DIR}/package/sluice-config-version.cmake src/library/module_folders.cpp
        DESTINATION ${package_folder} COMPONENT libsluice-dev)
set(shared_package libsluice${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
install(TARGETS sluice_installed sluice_shared EXPORT sluice
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libsluice-dev
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${shared_package} NAMELINK_COMPONENT libsluice-dev)
install(EXPORT sluice NAMESPACE sluice:: FILE sluice-targets.cmake DESTINATION ${package_folder}
        COMPONENT libsluice-dev)
install(DIRECTORY include/sluice DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT libsluice-dev
        FILES_MATCHING PATTERN "*.h")

# pkg-config's files, which may be moved with their prefix. The archive needs what it is linked to in every
# program that takes it, so nothing of the second one is private.
set(pc_packages)
set(pc_libraries)
foreach(item ${others})
  if(DEFINED pc_of_${item})
    list(APPEND pc_packages ${pc_of_${item}})
  elseif(item STREQUAL Threads::Threads)
    string(APPEND pc_libraries " -pthread")
  elseif(item MATCHES "::")
    message(FATAL_ERROR "${item} is linked to the library: name its pkg-config file in src/library/install.cmake")
  else()
    string(REGEX REPLACE "^.*/lib([^/]+)\\.(so|a)$" "\\1" name ${item})
    string(APPEND pc_libraries " -l${name}")
  endif()
endforeach()
list(JOIN pc_packages ", " pc_packages)
file(RELATIVE_PATH SLUICE_PREFIX_FROM_PC ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
# sluice_pkg_config(NAME LIBRARIES PACKAGES)
function(sluice_pkg_config name libraries packages)
  set(SLUICE_PC_NAME ${name})
  set(SLUICE_PC_LIBRARIES "${libraries}")
  set(SLUICE_PC_PACKAGES "${packages}")
  configure_file(src/library/sluice.pc.in ${CMAKE_BINARY_DIR}/package/${name}.pc @ONLY)
  install(FILES ${CMAKE_BINARY_DIR}/package/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
          COMPONENT libsluice-dev)
endfunction()
sluice_pkg_config(sluice "-lsluice" "")
sluice_pkg_config(sluice-static "-l:libsluice.a${pc_libraries}" "${pc_packages}")
