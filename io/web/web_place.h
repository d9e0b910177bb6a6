// What lies at an address, as a place in a store.
#pragma once

#include <string>

#include "io/stores/chunk_store.h"
#include "io/web/address.h"
#include "src/base/threads/stop_token.h"

namespace sluice {

// Asks for nothing yet. `stop` ends reading by Interrupted. Throws Error: no address, the module is
// missing.
StorePlace webPlace(const std::string& address, const WebOptions& options, const StopToken& stop);

}  // namespace sluice
