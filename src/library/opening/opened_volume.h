// OpenedVolume: the state behind the public Volume, shared by its copies and its Renderers.
#pragma once

#include <sluice/volume.h>

#include <exception>
#include <filesystem>
#include <memory>
#include <system_error>
#include <vector>

#include "src/base/error.h"
#include "src/base/field_names.h"
#include "src/base/threads/stop_token.h"
#include "src/library/in_situ.h"
#include "src/library/opening/indexed_volume.h"
#include "src/library/option_fields.h"
#include "src/library/progress_relay.h"

namespace sluice {

struct OpenedVolume {
  std::shared_ptr<ProgressRelay> relay;  // the source's too
  IndexedVolume volume;
  std::vector<IndexedVolume> more;  // further channels that pictures show together with it
  bool whole_series = true;
  // The ranks that have the volume in parts; null: this process has all of it.
  std::shared_ptr<const InSitu> in_situ;
  VolumeInfo info;
};

struct Volume::Impl : OpenedVolume {};

// Runs a call of the library with its exceptions translated: Interrupted becomes Cancelled, errors
// of the C++ library about files and threads become Error, and errors name fields for options.
template <class Call>
auto translated(const Call& call) {
  try {
    return call();
  } catch (const Interrupted&) {
    throw Cancelled();
  } catch (const std::system_error& error) {  // includes those of std::filesystem
    throw Error(error.what(), kindOf(error.code().value()));
  } catch (const FieldError&) {
    throw;
  } catch (const Error& error) {
    throw FieldError(error, inFields(error.what()));
  }
}

}  // namespace sluice
