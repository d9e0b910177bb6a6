# The Debian packages that tools/package.sh makes: one for each component of the installation. Included
# last if SLUICE_PACKAGES is on, which configures for the prefix /usr.
set(SLUICE_PACKAGER "" CACHE STRING "Who makes the packages: \"NAME <ADDRESS>\"")
set(packages sluice ${shared_package} libsluice-dev)
if(TARGET sluice_window)
  list(APPEND packages sluice-window)
endif()
if(TARGET sluice_openmpi_module OR TARGET sluice_mpich_module)
  list(APPEND packages sluice-mpi)
endif()
if(TARGET sluice_python)
  list(APPEND packages python3-sluice)
endif()

set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME sluice)
set(CPACK_PACKAGE_CONTACT "${SLUICE_PACKAGER}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_COMPONENTS_ALL ${packages})
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_PROJECT_CONFIG_FILE ${CMAKE_CURRENT_LIST_DIR}/cpack_options.cmake)
set(CPACK_SLUICE_SHLIBDEPS ${CMAKE_CURRENT_LIST_DIR}/shlibdeps.sh)

# sluice_package(NAME SUMMARY TEXT): the first line of its description, and the lines after it.
function(sluice_package name summary text)
  string(TOUPPER ${name} key)
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_COMPONENT_${key}_DESCRIPTION "${summary}\n${text}" PARENT_SCOPE)
endfunction()

set(same "(= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
sluice_package(sluice "renderer of volumes that are larger than memory"
"Sluice draws scalar volumes (CT, microscopy, simulation) that need not fit
into memory. It reads only the blocks that a transfer function makes visible,
within a hard memory budget, and needs neither a GPU nor a display. It reads
NRRD, MetaImage, NIfTI, DICOM, HDF5, OpenVDB, OME-Zarr, N5, VTK, TIFF and raw
files, and stores on the web.")
set(CPACK_DEBIAN_SLUICE_PACKAGE_RECOMMENDS "libcairo2, fonts-dejavu-core")
set(CPACK_DEBIAN_SLUICE_PACKAGE_SUGGESTS
    "sluice-window, sluice-mpi, python3-sluice, libosmesa6, libegl1, ffmpeg")
sluice_package(sluice-window "window of the volume renderer sluice"
"Sluice draws scalar volumes that are larger than memory. This package has the
window that \"sluice view\" opens: the volume, its slices, and a transfer
function to edit over the histogram.")
set(CPACK_DEBIAN_SLUICE-WINDOW_PACKAGE_DEPENDS "sluice ${same}")
sluice_package(sluice-mpi "pictures by several ranks for the volume renderer sluice"
"Sluice draws scalar volumes that are larger than memory. This package has the
modules for Open MPI and MPICH, with which \"mpirun sluice render\" shares a
picture among processes and computers.")
set(CPACK_DEBIAN_SLUICE-MPI_PACKAGE_DEPENDS "sluice ${same}")
sluice_package(python3-sluice "volume renderer for Python and NumPy"
"Sluice draws scalar volumes that are larger than memory. This package draws
files and arrays of NumPy, zarr and xarray from Python.")
set(CPACK_DEBIAN_PYTHON3-SLUICE_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON3-SLUICE_PACKAGE_CONTROL_EXTRA
    "${CMAKE_CURRENT_LIST_DIR}/python3-sluice/postinst;${CMAKE_CURRENT_LIST_DIR}/python3-sluice/prerm")
if(TARGET sluice_python)
  set(Python_EXECUTABLE ${SLUICE_PYTHON3})
  find_package(Python COMPONENTS Interpreter REQUIRED)
  math(EXPR next_minor "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON3-SLUICE_PACKAGE_DEPENDS "sluice ${same}, python3-numpy, python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}~), python3 (<< ${Python_VERSION_MAJOR}.${next_minor})")
endif()
# Its modules are in the package of the program, and belong to one version.
sluice_package(${shared_package} "renderer of volumes that are larger than memory - library"
"Sluice draws scalar volumes that are larger than memory. This package has the
shared library, for programs that are linked to it.")
string(TOUPPER ${shared_package} key)
set(CPACK_DEBIAN_${key}_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_${key}_PACKAGE_DEPENDS "sluice ${same}")
set(so_version ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
file(WRITE ${CMAKE_BINARY_DIR}/package/shlibs "libsluice ${so_version} ${shared_package} ${same}\n")
file(WRITE ${CMAKE_BINARY_DIR}/package/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_${key}_PACKAGE_CONTROL_EXTRA
    "${CMAKE_BINARY_DIR}/package/shlibs;${CMAKE_BINARY_DIR}/package/triggers")
sluice_package(libsluice-dev "renderer of volumes that are larger than memory - headers"
"Sluice draws scalar volumes that are larger than memory. This package has the
headers of the library, its archive, and its files for CMake and pkg-config.")
set(CPACK_DEBIAN_LIBSLUICE-DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBSLUICE-DEV_PACKAGE_DEPENDS "${shared_package} ${same}, libblosc-dev, libexpat1-dev, libfmt-dev, libhwy-dev, liblz4-dev, liblzma-dev, libopenexr-dev, libpng-dev, libtiff-dev, libzstd-dev, zlib1g-dev")

# Each package has its copyright and the changelog of Debian.
configure_file(${CMAKE_CURRENT_LIST_DIR}/changelog.in ${CMAKE_BINARY_DIR}/package/changelog.Debian @ONLY)
execute_process(COMMAND gzip -9nkf ${CMAKE_BINARY_DIR}/package/changelog.Debian COMMAND_ERROR_IS_FATAL ANY)
foreach(package ${packages})
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/copyright ${CMAKE_BINARY_DIR}/package/changelog.Debian.gz
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${package})
  set(overrides ${CMAKE_BINARY_DIR}/package/overrides/${package})
  file(WRITE ${overrides} "# Nobody asked Debian for the package.\n${package}: initial-upload-closes-no-bugs\n")
  if(package STREQUAL sluice-window)
    file(APPEND ${overrides} "# It is in the package sluice, which this one depends on.\n"
         "${package}: desktop-command-not-in-package *\n")
  endif()
  if(package STREQUAL shared_package)
    file(APPEND ${overrides} "# CPack adds calls beside the trigger, and they do no harm.\n"
         "${package}: maintscript-calls-ldconfig *\n")
  endif()
  install(FILES ${overrides} DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides COMPONENT ${package})
endforeach()
install(CODE "file(GLOB pages \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/share/man/man1/*.1\")
execute_process(COMMAND gzip -9nf \${pages} COMMAND_ERROR_IS_FATAL ANY)" COMPONENT sluice)
include(CPack)
