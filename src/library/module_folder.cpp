// Compiled into programs that link to the installed library, by its package: the folder of its
// modules. Declared and explained in src/base/files/module_path.cpp.
extern "C" const char* sluiceModuleFolder();

extern "C" const char* sluiceModuleFolder() {
  return SLUICE_MODULE_FOLDER;
}
