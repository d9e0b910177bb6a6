#include "io/web/web_module.h"

#include <curl/curl.h>

#include "io/web/http_store.h"
#include "src/base/error.h"

namespace sluice {
namespace {

HttpCredentials credentialsFor(const Address& address, const BucketAccess& buckets) {
  if (!address.is_bucket || buckets.access_key.empty()) return {address.user, {}, {}};
  return {buckets.access_key + ":" + buckets.secret_key,
          fmt::format("aws:amz:{}:s3", buckets.region), buckets.session_token};
}

}  // namespace
}  // namespace sluice

extern "C" const char* sluiceOpenWebVersion() {
  return sluice::kWebModuleVersion;
}

extern "C" void sluiceOpenWebStore(const sluice::Address& address,
                                   const sluice::WebOptions& options, const sluice::StopToken& stop,
                                   std::shared_ptr<sluice::ChunkStore>& store) {
  using namespace sluice;
  if (curl_global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK)
    failSystem("{}: libcurl cannot begin", printedAddress(address));
  store =
      std::make_shared<HttpStore>(address, credentialsFor(address, options.buckets), options, stop);
}
