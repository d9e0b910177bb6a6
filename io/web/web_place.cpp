#include "io/web/web_place.h"

#include <span>

#include "io/web/web_module.h"
#include "src/base/error.h"
#include "src/base/files/module_path.h"
#include "src/base/files/shared_library.h"

namespace sluice {
namespace {

OpenWebStore* openModule(const std::string& address) {
  const std::string name = modulePath("sluice_web.so");
  try {
    const SharedLibrary library(std::span(&name, 1), "sluice's module for the web");
    const std::string_view version = library.get<OpenWebVersion*>(kOpenWebVersion)();
    if (version != kWebModuleVersion)
      fail("{} belongs to sluice {}, expected {}; install sluice again", name, version,
           kWebModuleVersion);
    return library.get<OpenWebStore*>(kOpenWebStore);
  } catch (const Error& error) {
    fail("{}: an address, which is not read without {}", address, error.what());
  }
}

}  // namespace

StorePlace webPlace(const std::string& address, const WebOptions& options, const StopToken& stop) {
  const Address parsed = parseAddress(address, options.buckets);
  StorePlace place{nullptr, parsed.key};
  openModule(printedAddress(parsed))(parsed, options, stop, place.store);
  return place;
}

}  // namespace sluice
