#include "io/web/web_place.h"

#include "io/web/web_module.h"
#include "src/base/error.h"
#include "src/base/files/program_module.h"

namespace sluice {
namespace {

OpenWebStore* webModule(const std::string& address) {
  try {
    return openModule(
               {"sluice_web.so", "sluice's module for the web", kOpenWebVersion, kWebModuleVersion})
        .get<OpenWebStore*>(kOpenWebStore);
  } catch (const Error& error) {
    failAs(error.kind(), "{}: an address, which is not read without {}", address, error.what());
  }
}

}  // namespace

StorePlace webPlace(const std::string& address, const WebOptions& options, const StopToken& stop) {
  WebOptions known = options;
  if (isBucketAddress(address) && options.find_buckets) known.buckets = options.find_buckets();
  const Address parsed = parseAddress(address, known.buckets);
  StorePlace place{nullptr, parsed.key};
  webModule(printedAddress(parsed))(parsed, known, stop, place.store);
  return place;
}

}  // namespace sluice
