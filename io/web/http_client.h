// HttpClient: GET requests of many threads over few connections, by libcurl, on a thread of its
// own.
//
// A request waits for its answer; what the answer brings is handed to it on the client's thread. An
// answer is taken as it comes: trying again is its caller's decision. Redirects are followed as far
// as they stay at the server (io/web/redirect.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>

#include "io/web/address.h"
#include "src/base/threads/mutex.h"
#include "src/base/threads/stop_token.h"

namespace sluice {

// What an answer says before its body comes.
struct HttpHead {
  int status = 0;
  std::optional<uint64_t> length;             // of the body
  std::optional<uint64_t> first_byte, whole;  // of a part: its place, and the size of the whole
  std::string stamp;                          // changes with the content: ETag or Last-Modified
  double retry_after_s = 0;
  bool is_encoded = false;  // compressed for the way, which was not asked for
};

// The line of a header, such as "Content-Range: bytes 5-9/100", taken into a head. A status line
// begins a new head.
void takeHeaderLine(std::string_view line, HttpHead& head);

// Name and password, or an access key with its secret for signed requests to a bucket's server.
struct HttpCredentials {
  std::string user;           // "name:password", or empty
  std::string signs_with;     // libcurl's "aws:amz:REGION:s3", or empty
  std::string session_token;  // of an access key that ends
};

struct HttpGet {
  std::string url;
  std::string range;        // as "0-99" or "-16"; empty: all
  std::string known_stamp;  // an object that has this one still is not sent (status 304)
  // Both are called on the client's thread, the head once the headers of the last answer are
  // complete. False ends the request.
  std::function<bool(const HttpHead& head)> on_head;
  std::function<bool(std::span<const std::byte> bytes)> on_body;
};

struct HttpEnd {
  std::string fault;       // why no answer came, or not all of it; empty: it came
  bool may_pass = false;   // the same request may succeed later
  bool is_silent = false;  // the server said nothing for too long
};

class HttpClient {
 public:
  explicit HttpClient(HttpCredentials credentials, WebCertificates certificates = {});
  // Requires: no thread is in get().
  ~HttpClient();

  // Waits for the answer. Throws Interrupted.
  HttpEnd get(const HttpGet& request, const StopToken& stop);

 private:
  struct Transfer;
  void run();
  // False if libcurl has no memory for it.
  bool begin(Transfer& transfer);
  // Asks again where a redirect leads. Returns the end instead if it leads to another server.
  std::optional<HttpEnd> follow(Transfer& transfer);
  void finish(Transfer& transfer, HttpEnd end);

  const HttpCredentials credentials_;
  const WebCertificates certificates_;
  void* const multi_;  // CURLM, used on the thread
  Mutex mutex_;
  Condition ended_;
  std::deque<Transfer*> waiting_ SLUICE_GUARDED_BY(mutex_);
  bool is_over_ SLUICE_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace sluice
