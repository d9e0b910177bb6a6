// The interface between the program and its module for the web.
//
// libcurl brings some thirty libraries. So all that includes its headers is a library apart,
// sluice_web.so, opened with the first address (src/base/files/program_module.h says where from).
#pragma once

#include <memory>

#include "io/stores/chunk_store.h"
#include "io/web/address.h"
#include "src/base/threads/stop_token.h"

namespace sluice {

// The one function of the module: the objects of the address's server, as `store`.
using OpenWebStore = void(const Address& address, const WebOptions& options, const StopToken& stop,
                          std::shared_ptr<ChunkStore>& store);
inline constexpr const char* kOpenWebStore = "sluiceOpenWebStore";

// The module exports this before anything is called: the version of sluice and of this interface.
inline constexpr const char* kOpenWebVersion = "sluiceOpenWebVersion";
inline constexpr const char* kWebModuleVersion = SLUICE_VERSION " web module 3";

}  // namespace sluice
