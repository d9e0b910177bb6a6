// The folders of the modules that are opened at run time, for code that does not lie beside them:
// the shared library, Python's extension module, and programs that link to the installed archive,
// whose CMake package compiles this file into them. Declared and explained in
// src/base/files/program_module.cpp.
extern "C" const char* sluiceModuleFolders();

extern "C" const char* sluiceModuleFolders() {
  return SLUICE_MODULE_FOLDERS;
}
