// The environment variables that the program looks at (docs/command-line.md). The library looks at
// none.
#pragma once

#include <filesystem>
#include <string>

#include "io/headers/decode_options.h"
#include "io/web/address.h"
#include "src/index/index_file.h"
#include "src/parallel/communication/mpi_ranks.h"

namespace sluice {

// The place for indices: `index_dir` (--index-dir), $SLUICE_INDEX_DIR, $XDG_CACHE_HOME/sluice/index
// or ~/.cache/sluice/index, the first that is set. SLUICE_INDEX=beside: next to the volume, unless
// --index-dir is given. SLUICE_INDEX=off: nowhere. Throws Error if SLUICE_INDEX has another value,
// or SLUICE_INDEX_DIR decides and is no absolute path.
IndexWish indexWish(const std::string& index_dir);

// The settings that the window keeps between runs: $XDG_CONFIG_HOME/sluice/view.json or
// ~/.config/sluice/view.json; empty if neither variable is set.
std::filesystem::path windowSettings();

// Options for decoding into $TMPDIR, with a line of progress.
DecodeOptions decodeOptions();

// The folder for what was read from the web: $XDG_CACHE_HOME/sluice/web or ~/.cache/sluice/web;
// empty: neither is set.
std::filesystem::path webCacheFolder();

// The server of s3:// addresses and the key for them: bucketAccess() of io/web/bucket_access.h with
// this process's environment. Throws Error.
BucketAccess bucketAccess();

// $CURL_CA_BUNDLE, or else $SSL_CERT_FILE and $SSL_CERT_DIR: the variables that curl looks at.
WebCertificates webCertificates();

// The rank that a launcher has started this process as, and the number of ranks.
Launch launchOfProcess();

// Adds the flags that pictures need to the user's flags for Mesa (gl_choice.h), which the driver
// reads. Called once, before there are threads.
void prepareDriver();

}  // namespace sluice
