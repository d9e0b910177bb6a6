# Read by CPack before it makes a package.
set(SHLIBDEPS_EXECUTABLE ${CPACK_SLUICE_SHLIBDEPS})
