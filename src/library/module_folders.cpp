// Compiled into programs that link to the installed library, by its package: the folder of its
// modules. Declared and explained in src/base/files/program_module.cpp.
extern "C" const char* sluiceModuleFolders();

extern "C" const char* sluiceModuleFolders() {
  return SLUICE_MODULE_FOLDER;
}
