#include "io/web/address.h"

#include <algorithm>
#include <array>

#include "src/base/error.h"
#include "src/base/values/text_parts.h"

namespace sluice {
namespace {

constexpr std::string_view kBucketScheme = "s3://";
constexpr std::array<std::string_view, 3> kSchemes = {"http://", "https://", kBucketScheme};

std::string_view schemeOf(std::string_view name) {
  for (const std::string_view scheme : kSchemes)
    if (name.starts_with(scheme)) return scheme;
  return "";
}

// s3://BUCKET/KEY as an address of the bucket's server.
Address bucketAddress(std::string_view rest, const BucketAccess& buckets) {
  const size_t end = std::min(rest.find('/'), rest.size());
  const std::string bucket(rest.substr(0, end));
  const std::string key(rest.substr(std::min(end + 1, rest.size())));
  Address address;
  address.is_bucket = true;
  if (const std::string& endpoint = buckets.endpoint; !endpoint.empty()) {
    address.server = withoutSlashes(endpoint);
    address.key = bucket + "/" + key;
  } else if (bucket.find('.') != std::string::npos) {
    // No certificate covers a bucket's name with dots.
    address.server = fmt::format("https://s3.{}.amazonaws.com", buckets.region);
    address.key = bucket + "/" + key;
  } else {
    address.server = fmt::format("https://{}.s3.{}.amazonaws.com", bucket, buckets.region);
    address.key = key;
  }
  if (bucket.empty()) address.server.clear();
  return address;
}

}  // namespace

bool isAddress(std::string_view name) {
  return !schemeOf(name).empty();
}

bool isBucketAddress(std::string_view name) {
  return name.starts_with(kBucketScheme);
}

Address parseAddress(const std::string& name, const BucketAccess& buckets) {
  const std::string_view scheme = schemeOf(name);
  std::string_view rest = std::string_view(name).substr(scheme.size());
  Address address;
  if (scheme == kBucketScheme) {
    address = bucketAddress(rest, buckets);
  } else {
    // A fragment is never sent to a server (RFC 3986, 3.5).
    rest = rest.substr(0, rest.find('#'));
    const size_t query = std::min(rest.find('?'), rest.size());
    address.query = rest.substr(query);
    rest = rest.substr(0, query);
    const size_t path = std::min(rest.find('/'), rest.size());
    std::string_view host = rest.substr(0, path);
    if (const size_t at = host.rfind('@'); at != std::string_view::npos) {
      address.user = host.substr(0, at);
      host = host.substr(at + 1);
    }
    if (!host.empty()) address.server = std::string(scheme) + std::string(host);
    address.key = rest.substr(std::min(path + 1, rest.size()));
  }
  // Keys of chunks are appended with a slash of their own.
  while (address.key.ends_with('/')) address.key.pop_back();
  if (address.server.empty() || address.key.empty())
    fail("{}: expected an address such as https://HOST/PATH or s3://BUCKET/KEY", name);
  return address;
}

std::string printedAddress(const Address& address) {
  return address.server + "/" + address.key;
}

std::string withoutSecrets(const std::string& name) {
  // Schemes that are refused are printed, too.
  const size_t end = name.find("://");
  if (end == name.npos) return name;
  const std::string_view scheme = std::string_view(name).substr(0, end + 3);
  std::string_view rest = std::string_view(name).substr(scheme.size());
  rest = rest.substr(0, rest.find_first_of("?#"));
  const size_t path = std::min(rest.find('/'), rest.size());
  // Up to the last one: a password may have one of its own.
  if (const size_t at = rest.substr(0, path).rfind('@'); at != std::string_view::npos)
    rest.remove_prefix(at + 1);
  return std::string(scheme) + std::string(rest);
}

}  // namespace sluice
