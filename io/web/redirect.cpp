#include "io/web/redirect.h"

#include <curl/curl.h>

#include <memory>

#include "src/base/error.h"
#include "src/base/values/letter_case.h"

namespace sluice {
namespace {

struct UrlDeleter {
  void operator()(CURLU* url) const { curl_url_cleanup(url); }
};
using Url = std::unique_ptr<CURLU, UrlDeleter>;

std::string partOf(CURLU* url, CURLUPart part, unsigned flags = 0) {
  char* text = nullptr;
  if (curl_url_get(url, part, &text, flags) != CURLUE_OK) return "";
  std::string copy = lowercase(text);
  curl_free(text);
  return copy;
}

}  // namespace

std::string originOf(const std::string& url) {
  const Url parts(curl_url());
  if (!parts || curl_url_set(parts.get(), CURLUPART_URL, url.c_str(), 0) != CURLUE_OK) return "";
  const std::string scheme = partOf(parts.get(), CURLUPART_SCHEME),
                    host = partOf(parts.get(), CURLUPART_HOST);
  if ((scheme != "http" && scheme != "https") || host.empty()) return "";
  const std::string port = partOf(parts.get(), CURLUPART_PORT, CURLU_NO_DEFAULT_PORT);
  return scheme + "://" + host + (port.empty() ? "" : ":" + port);
}

std::string redirectFault(const std::string& from, const std::string& to, bool has_credentials) {
  const std::string here = originOf(from), there = originOf(to);
  if (there.empty()) return "the server sends to a place that is no address of http or https";
  if (here == there) return "";
  // The ports are the schemes' own: another port may be anybody's server.
  const bool is_secured = here.find(':', 5) == std::string::npos &&
                          there == "https" + here.substr(std::string("http").size());
  if (here.starts_with("http://") && is_secured && !has_credentials) return "";
  return fmt::format("the server sends to another one, {}; give that address", there);
}

}  // namespace sluice
