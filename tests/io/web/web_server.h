// WebServer: tests/io/web_server.py in a process of its own, for as long as this lives.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "src/base/error.h"
#include "tests/io/python_volumes.h"

namespace sluice {

struct WebRequest {
  std::string path, range;  // the range "-" for all of it
  int status = 0;
  uint64_t bytes = 0;  // of the body
  std::string authorization;
};

class WebServer {
 public:
  explicit WebServer(const std::filesystem::path& folder, const std::string& fault = "") {
    std::array<int, 2> to{}, from{};
    if (pipe(to.data()) != 0 || pipe(from.data()) != 0) fail("no pipe");
    const std::string script = SLUICE_TEST_DIR "/web_server.py", served = folder.string(),
                      log = (log_ / "log").string();
    child_ = fork();
    if (child_ == 0) {
      dup2(to[0], 0);
      dup2(from[1], 1);
      close(to[1]);
      close(from[0]);
      execl("/usr/bin/python3", "python3", script.c_str(), served.c_str(), log.c_str(),
            fault.c_str(), nullptr);
      _exit(1);
    }
    close(to[0]);
    close(from[1]);
    input_ = to[1];
    std::string port;
    for (char c = 0; read(from[0], &c, 1) == 1 && c != '\n';) port += c;
    close(from[0]);
    if (port.empty()) fail("web_server.py does not begin");
    address_ = "http://127.0.0.1:" + port;
  }
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;
  ~WebServer() {
    close(input_);
    waitpid(child_, nullptr, 0);
  }

  // "http://HOST:PORT", without a slash at its end.
  const std::string& address() const { return address_; }
  // The file with a line for each request.
  std::filesystem::path log() const { return log_ / "log"; }
  // So far, in their order.
  std::vector<WebRequest> requests() const {
    std::istringstream lines(readFile(log_ / "log"));
    std::vector<WebRequest> all;
    for (WebRequest r; lines >> r.path >> r.range >> r.status >> r.bytes;) {
      std::getline(lines >> std::ws, r.authorization);
      all.push_back(r);
    }
    return all;
  }

 private:
  const TempFolder log_;
  pid_t child_ = 0;
  int input_ = -1;
  std::string address_;
};

}  // namespace sluice
