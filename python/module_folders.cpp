// The folders of the modules that readers open at run time (OpenVDB, the web), as
// src/base/files/program_module.cpp asks for them.
extern "C" const char* sluiceModuleFolders();

extern "C" const char* sluiceModuleFolders() {
  return SLUICE_MODULES_FROM_PACKAGE;
}
