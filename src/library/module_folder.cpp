// Compiled into programs that link to the installed library, by its package: where its modules are.
// Declared, and said what for, in src/base/module_path.cpp.
extern "C" const char* sluiceModuleFolder();

extern "C" const char* sluiceModuleFolder() {
  return SLUICE_MODULE_FOLDER;
}
