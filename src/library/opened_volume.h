// OpenedVolume: what the public Volume stands for, shared by its copies and its Renderers.
#pragma once

#include <sluice/volume.h>

#include <exception>
#include <filesystem>
#include <memory>
#include <system_error>

#include "src/base/stop_token.h"
#include "src/library/indexed_volume.h"
#include "src/library/progress_relay.h"

namespace sluice {

struct OpenedVolume {
  std::shared_ptr<ProgressRelay> relay;  // the source's too
  IndexedVolume volume;
  bool whole_series = true;
  VolumeInfo info;
};

struct Volume::Impl : OpenedVolume {};

// What comes out of a call of the library: Cancelled where it was stopped, Error for what the C++
// library says of files and threads.
template <class Call>
auto translated(const Call& call) {
  try {
    return call();
  } catch (const Interrupted&) {
    throw Cancelled();
  } catch (const std::system_error& error) {  // those of std::filesystem are some
    throw Error(error.what());
  }
}

}  // namespace sluice
