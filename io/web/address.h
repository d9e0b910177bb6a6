// Addresses of volumes on the web, as users name them: http://HOST/PATH, https://HOST/PATH?QUERY,
// s3://BUCKET/KEY. Pure functions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace sluice {

// Whether a name is an address, and not a file's.
bool isAddress(std::string_view name);
// Whether it is that of a bucket: s3://BUCKET/KEY.
bool isBucketAddress(std::string_view name);

// A server of buckets, and the key for signed requests; without one, requests are not signed.
struct BucketAccess {
  std::string endpoint;  // as "http://127.0.0.1:9000"; empty: Amazon's
  std::string region = "us-east-1";
  std::string access_key, secret_key, session_token;
};

// Where pieces of objects are kept from one time to the next, and how much of them; 0 bytes:
// nowhere.
struct WebCache {
  std::filesystem::path folder;
  uint64_t budget_bytes = 0;
};

// Certificates of authorities, in place of the system's; empty: the system's.
struct WebCertificates {
  std::string file, folder;  // of PEM; as `openssl rehash` arranges them
};

// The refusal of a cache without a folder.
inline constexpr const char* kNoCacheFolder =
    "--cache: expected a folder for it, found none, because neither XDG_CACHE_HOME nor HOME names "
    "one; give --cache-dir";

struct WebOptions {
  BucketAccess buckets = {};
  // Finds `buckets` when the first s3:// address is opened; not set: they are known.
  std::function<BucketAccess()> find_buckets = {};
  WebCache cache = {};
  // Told in one line, once for each opened volume, that the cache cannot keep what was read, and
  // why. Not set: nobody is told. Called by any thread, and while others are reading.
  std::function<void(const std::string& line)> warn = {};
  WebCertificates certificates = {};
};

struct Address {
  std::string server;      // "https://host:port", without a user's name and password
  std::string key;         // the path, without the slash at its beginning
  std::string query;       // "?...", or empty: sent with every request, printed never
  std::string user;        // "name:password", or empty
  bool is_bucket = false;  // it may take signed requests
};

// Throws Error: no server, or no path.
Address parseAddress(const std::string& name, const BucketAccess& buckets = {});

// The address without name, password and query: for messages, reports and titles.
std::string printedAddress(const Address& address);

// The name that a user gave, for messages, reports and names of files: an address loses its user,
// password and query.
std::string withoutSecrets(const std::string& name);

}  // namespace sluice
