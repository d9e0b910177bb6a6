#include "io/web/http_client.h"

#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>
#include <vector>

#include "io/web/redirect.h"
#include "src/base/error.h"
#include "src/base/files/number_text.h"
#include "src/base/threads/threads.h"
#include "src/base/values/letter_case.h"
#include "src/base/values/text_parts.h"

namespace sluice {
namespace {

constexpr long kConnections = 16;    // to one server
constexpr long kConnectSeconds = 8;  // until a connection stands
constexpr long kSilentSeconds = 7;   // until a connection is given up that is slower than
constexpr long kLeastSpeed = 128;    // bytes a second
constexpr int kRedirects = 5;
constexpr uint64_t kMostRedirectBytes = 1 << 16;  // of a body, which says no more than the header
constexpr int kPollMs = 1000;                     // a wake-up comes before
constexpr std::chrono::milliseconds kAskStopEvery(50);

// "bytes 5-9/100", or "bytes */100"
void takeContentRange(std::string_view value, HttpHead& head) {
  if (!value.starts_with("bytes ")) return;
  value.remove_prefix(6);
  const size_t slash = value.find('/');
  if (slash == std::string_view::npos) return;
  head.first_byte = numberIn<uint64_t>(value.substr(0, value.find('-')));
  head.whole = numberIn<uint64_t>(value.substr(slash + 1));
}

// A stamp is an ETag, which is quoted, or a time.
bool isEntityTag(const std::string& stamp) {
  return stamp.find('"') != std::string::npos;
}

bool isRedirect(int status) {
  return status == 301 || status == 302 || status == 303 || status == 307 || status == 308;
}

// Faults of the network and of a busy server, which others do not have.
bool mayPass(CURLcode code) {
  constexpr std::array kPassing = {
      CURLE_COULDNT_CONNECT, CURLE_PARTIAL_FILE, CURLE_OPERATION_TIMEDOUT,
      CURLE_GOT_NOTHING,     CURLE_SEND_ERROR,   CURLE_RECV_ERROR,
      CURLE_HTTP2,           CURLE_HTTP2_STREAM};
  return std::find(kPassing.begin(), kPassing.end(), code) != kPassing.end();
}

// libcurl's line, and what the user can do.
std::string faultOf(CURLcode code, const char* text) {
  switch (code) {
    case CURLE_COULDNT_RESOLVE_HOST:
      return fmt::format("no connection ({}); check the address and the network", text);
    case CURLE_COULDNT_CONNECT:
      return fmt::format("no connection ({})", text);
    case CURLE_PEER_FAILED_VERIFICATION:
      return fmt::format(
          "no secure connection ({}); CURL_CA_BUNDLE names a file of authorities to trust", text);
    default:
      return fmt::format("the connection failed ({}){}", text,
                         mayPass(code) ? "" : "; check the address and the server");
  }
}

HttpEnd noMemory() {
  return {"there is no memory for the request", true};
}

}  // namespace

void takeHeaderLine(std::string_view line, HttpHead& head) {
  if (line.starts_with("HTTP/")) {
    // Headers of an answer that came before, such as 100 Continue, do not count.
    head = {};
    const size_t space = std::min(line.find(' '), line.size());
    const std::string_view status = line.substr(std::min(space + 1, line.size())).substr(0, 3);
    head.status = static_cast<int>(numberIn<uint64_t>(status).value_or(0));
    return;
  }
  const size_t colon = line.find(':');
  if (colon == std::string_view::npos) return;
  // Names of headers have no case (RFC 9110, 5.1).
  const std::string name = lowercase(line.substr(0, colon));
  const std::string_view value = trimmed(line.substr(colon + 1));
  if (name == "content-length") head.length = numberIn<uint64_t>(value);
  if (name == "content-range") takeContentRange(value, head);
  if (name == "etag") head.stamp = value;
  if (name == "last-modified" && head.stamp.empty()) head.stamp = value;
  if (name == "retry-after")
    head.retry_after_s = static_cast<double>(numberIn<uint64_t>(value).value_or(0));
  if (name == "content-encoding") head.is_encoded = value != "identity";
}

struct HttpClient::Transfer {
  explicit Transfer(const HttpGet& get) : request(get), url(get.url) {}

  const HttpGet& request;
  CURL* easy = nullptr;
  curl_slist* headers = nullptr;
  HttpHead head = {};
  bool is_head_told = false;
  std::string url;  // now, after redirects
  int redirects = 0;
  uint64_t redirect_bytes = 0;  // of bodies that were dropped
  std::array<char, CURL_ERROR_SIZE> message{};
  bool is_stopped = false;  // guarded by the client's mutex, as the rest
  bool is_done = false;
  HttpEnd end = {};

  bool tellHead() {
    if (is_head_told) return true;
    is_head_told = true;
    return request.on_head(head);
  }
  static size_t takeHeader(char* bytes, size_t one, size_t count, void* self) {
    auto& transfer = *static_cast<Transfer*>(self);
    takeHeaderLine({bytes, one * count}, transfer.head);
    return one * count;
  }
  static size_t takeBody(char* bytes, size_t one, size_t count, void* self) {
    auto& transfer = *static_cast<Transfer*>(self);
    const std::span<const std::byte> body(reinterpret_cast<const std::byte*>(bytes), one * count);
    // The body of a redirect is no part of the object.
    if (isRedirect(transfer.head.status)) {
      transfer.redirect_bytes += body.size();
      return transfer.redirect_bytes <= kMostRedirectBytes ? body.size() : CURL_WRITEFUNC_ERROR;
    }
    return transfer.tellHead() && transfer.request.on_body(body) ? body.size()
                                                                 : CURL_WRITEFUNC_ERROR;
  }
};

HttpClient::HttpClient(HttpCredentials credentials, WebCertificates certificates)
    : credentials_(std::move(credentials)),
      certificates_(std::move(certificates)),
      multi_(curl_multi_init()) {
  curl_multi_setopt(multi_, CURLMOPT_MAX_HOST_CONNECTIONS, kConnections);
  thread_ = startThread([this] { run(); });
}

HttpClient::~HttpClient() {
  {
    const MutexLock lock(mutex_);
    is_over_ = true;
  }
  curl_multi_wakeup(multi_);
  thread_.join();
  curl_multi_cleanup(multi_);
}

HttpEnd HttpClient::get(const HttpGet& request, const StopToken& stop) {
  Transfer transfer(request);
  MutexLock lock(mutex_);
  waiting_.push_back(&transfer);
  curl_multi_wakeup(multi_);
  while (!transfer.is_done) {
    // A stop token has no way to wake this thread, so it is asked from time to time.
    ended_.waitUntil(lock, std::chrono::steady_clock::now() + kAskStopEvery);
    if (stop.isStopRequested() && !transfer.is_stopped) {
      transfer.is_stopped = true;
      curl_multi_wakeup(multi_);
    }
  }
  if (transfer.is_stopped) throw Interrupted();
  return transfer.end;
}

bool HttpClient::begin(Transfer& transfer) {
  CURL* const easy = transfer.easy = curl_easy_init();
  if (easy == nullptr) return false;
  const HttpGet& request = transfer.request;
  curl_easy_setopt(easy, CURLOPT_URL, request.url.c_str());
  if (!request.range.empty()) curl_easy_setopt(easy, CURLOPT_RANGE, request.range.c_str());
  curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
  // libcurl would follow a redirect to any host; follow() has the rule.
  curl_easy_setopt(easy, CURLOPT_FOLLOWLOCATION, 0L);
  curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(easy, CURLOPT_PIPEWAIT, 1L);  // one connection for many, if the server can
  curl_easy_setopt(easy, CURLOPT_HTTP_VERSION, CURL_HTTP_VERSION_2TLS);
  curl_easy_setopt(easy, CURLOPT_CONNECTTIMEOUT, kConnectSeconds);
  curl_easy_setopt(easy, CURLOPT_QUICK_EXIT, 1L);  // a stop waits for no name server
  curl_easy_setopt(easy, CURLOPT_LOW_SPEED_LIMIT, kLeastSpeed);
  curl_easy_setopt(easy, CURLOPT_LOW_SPEED_TIME, kSilentSeconds);
  curl_easy_setopt(easy, CURLOPT_USERAGENT, "sluice/" SLUICE_VERSION);
  curl_easy_setopt(easy, CURLOPT_ERRORBUFFER, transfer.message.data());
  curl_easy_setopt(easy, CURLOPT_PRIVATE, &transfer);
  curl_easy_setopt(easy, CURLOPT_HEADERFUNCTION, Transfer::takeHeader);
  curl_easy_setopt(easy, CURLOPT_HEADERDATA, &transfer);
  curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, Transfer::takeBody);
  curl_easy_setopt(easy, CURLOPT_WRITEDATA, &transfer);
  if (!certificates_.file.empty())
    curl_easy_setopt(easy, CURLOPT_CAINFO, certificates_.file.c_str());
  if (!certificates_.folder.empty())
    curl_easy_setopt(easy, CURLOPT_CAPATH, certificates_.folder.c_str());
  if (!credentials_.user.empty())
    curl_easy_setopt(easy, CURLOPT_USERPWD, credentials_.user.c_str());
  if (!credentials_.signs_with.empty())
    curl_easy_setopt(easy, CURLOPT_AWS_SIGV4, credentials_.signs_with.c_str());
  const auto addHeader = [&](const std::string& line) {
    transfer.headers = curl_slist_append(transfer.headers, line.c_str());
  };
  if (!credentials_.session_token.empty())
    addHeader("x-amz-security-token: " + credentials_.session_token);
  if (!request.known_stamp.empty())
    addHeader((isEntityTag(request.known_stamp) ? "If-None-Match: " : "If-Modified-Since: ") +
              request.known_stamp);
  curl_easy_setopt(easy, CURLOPT_HTTPHEADER, transfer.headers);
  return curl_multi_add_handle(multi_, easy) == CURLM_OK;
}

std::optional<HttpEnd> HttpClient::follow(Transfer& transfer) {
  const char* to = nullptr;
  curl_easy_getinfo(transfer.easy, CURLINFO_REDIRECT_URL, &to);
  if (to == nullptr)
    return HttpEnd{
        fmt::format("the server answered with status {}, a redirect that does not tell where to",
                    transfer.head.status),
        false};
  const bool has_credentials = !credentials_.user.empty();
  if (std::string fault = redirectFault(transfer.url, to, has_credentials); !fault.empty())
    return HttpEnd{std::move(fault), false};
  if (++transfer.redirects > kRedirects)
    return HttpEnd{fmt::format("the server sends on by more than {} redirects", kRedirects), false};
  transfer.url = to;
  transfer.head = {};
  curl_multi_remove_handle(multi_, transfer.easy);
  curl_easy_setopt(transfer.easy, CURLOPT_URL, transfer.url.c_str());
  if (curl_multi_add_handle(multi_, transfer.easy) != CURLM_OK) return noMemory();
  return std::nullopt;
}

void HttpClient::finish(Transfer& transfer, HttpEnd end) {
  curl_multi_remove_handle(multi_, transfer.easy);
  curl_easy_cleanup(transfer.easy);
  curl_slist_free_all(transfer.headers);
  const MutexLock lock(mutex_);
  transfer.end = std::move(end);
  transfer.is_done = true;
  ended_.notifyAll();
}

void HttpClient::run() {
  std::vector<Transfer*> going;
  for (;;) {
    std::vector<Transfer*> fresh, stopped;
    {
      const MutexLock lock(mutex_);
      if (is_over_ && going.empty() && waiting_.empty()) return;
      fresh.assign(waiting_.begin(), waiting_.end());
      waiting_.clear();
      // Only this thread touches libcurl's handles, so that a stop is carried out here.
      for (Transfer* transfer : going)
        if (transfer->is_stopped) stopped.push_back(transfer);
    }
    for (Transfer* transfer : fresh)
      if (begin(*transfer))
        going.push_back(transfer);
      else
        finish(*transfer, noMemory());
    for (Transfer* transfer : stopped) {
      std::erase(going, transfer);
      finish(*transfer, {"stopped", false});
    }
    int running = 0, left = 0;
    curl_multi_perform(multi_, &running);
    while (const CURLMsg* message = curl_multi_info_read(multi_, &left)) {
      if (message->msg != CURLMSG_DONE) continue;
      Transfer* transfer = nullptr;
      curl_easy_getinfo(message->easy_handle, CURLINFO_PRIVATE, &transfer);
      const CURLcode code = message->data.result;
      HttpEnd end;
      if (code == CURLE_OK && isRedirect(transfer->head.status)) {
        std::optional<HttpEnd> refused = follow(*transfer);
        if (!refused) continue;
        end = std::move(*refused);
      } else if (code == CURLE_OK) {
        transfer->tellHead();  // an answer without a body
      } else {
        const char* text = transfer->message[0] != 0 ? transfer->message.data() : nullptr;
        end = {faultOf(code, text != nullptr ? text : curl_easy_strerror(code)), mayPass(code),
               code == CURLE_OPERATION_TIMEDOUT};
      }
      std::erase(going, transfer);
      finish(*transfer, std::move(end));
    }
    curl_multi_poll(multi_, nullptr, 0, kPollMs, nullptr);
  }
}

}  // namespace sluice
