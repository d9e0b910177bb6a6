// The key for signed requests to buckets, from where Amazon's own tools look for it.
#pragma once

#include <functional>
#include <string>

#include "io/web/address.h"

namespace sluice {

// The value of an environment variable; empty if it is not set.
using Variable = std::function<std::string(const char* name)>;

// Key and region from AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_SESSION_TOKEN, AWS_REGION and
// AWS_DEFAULT_REGION; what is not there, from the profile AWS_PROFILE (or "default") of the files
// ~/.aws/credentials and ~/.aws/config, or those that AWS_SHARED_CREDENTIALS_FILE and
// AWS_CONFIG_FILE name. The server is AWS_ENDPOINT_URL. A file that is not there says nothing.
// Throws Error for a profile that AWS_PROFILE names and no file has.
BucketAccess bucketAccess(const Variable& variable);

}  // namespace sluice
