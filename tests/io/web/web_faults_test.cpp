// Servers that lead elsewhere, or that do not answer.
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <chrono>
#include <map>
#include <thread>
#include <vector>

#include "io/open_volume.h"
#include "io/web/redirect.h"
#include "src/base/files/descriptor.h"
#include "tests/io/python_volumes.h"
#include "tests/io/web/web_case.h"
#include "tests/io/web/web_server.h"

namespace sluice {
namespace {

using std::chrono::seconds;
using std::chrono::steady_clock;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

// A port that never answers: the system takes connections, as many as fit the queue.
class DeafServer {
 public:
  explicit DeafServer(bool is_full) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t bytes = sizeof(address);
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    listening_ = Descriptor(socket(AF_INET, SOCK_STREAM, 0));
    if (bind(listening_.get(), any, bytes) != 0 ||
        getsockname(listening_.get(), any, &bytes) != 0 ||
        listen(listening_.get(), is_full ? 0 : 64) != 0)
      fail("no port");
    host_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    // The queue of no places has one; later connections wait for it.
    for (int i = 0; is_full && i < 4; ++i) {
      filling_.emplace_back(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0));
      connect(filling_.back().get(), any, bytes);
    }
  }
  const std::string& host() const { return host_; }

 private:
  Descriptor listening_;
  std::vector<Descriptor> filling_;
  std::string host_;
};

class WebFaults : public PythonVolumesTest<WebCase> {
 protected:
  static std::string root() { return folder_.string(); }
  static std::string voxelsAt(const std::string& address, const StopToken& stop = {}) {
    OpenOptions options;
    options.stop = stop;
    try {
      return allSteps(*openVolume(address, options));
    } catch (const Error& error) {
      return error.what();
    }
  }
};

TEST_F(WebFaults, nothingIsAskedOfAnotherServer) {
  const WebServer other(root());
  const WebServer server(root(), "to=" + other.address());
  const std::string host = server.address().substr(7);
  for (const std::string user : {"", "me:secret@"})
    EXPECT_THAT(voxelsAt("http://" + user + host + "/one_shard?key=hidden"),
                AllOf(StartsWith(server.address() + "/one_shard"),
                      HasSubstr("another one, " + other.address() + ";"), Not(HasSubstr("\n")),
                      Not(HasSubstr("secret")), Not(HasSubstr("hidden"))));
  OpenOptions options;
  options.web.buckets = {server.address(), "eu-west-1", "AKIDEXAMPLE", "secret", ""};
  EXPECT_THAT(errorOf([&] { openVolume("s3://image/scale1/image", options); }),
              HasSubstr("another one, " + other.address()));
  EXPECT_THAT(other.requests(), IsEmpty());
}

TEST_F(WebFaults, redirectsWithoutEndAreOneLine) {
  const WebServer server(root(), "loop");
  EXPECT_THAT(voxelsAt(server.address() + "/one_shard"), HasSubstr("more than 5 redirects"));
  EXPECT_LT(server.requests().size(), 10U);
}

TEST(WebRedirect, staysAtTheServerAndLeavesNoEncryption) {
  const std::string http = "http://Host/a", https = "https://host/a";
  EXPECT_EQ(redirectFault(http, "http://host:80/b?x", true), "");
  EXPECT_EQ(redirectFault(http, "https://host/b", false), "");
  EXPECT_EQ(redirectFault(https, "https://HOST:443/", true), "");
  EXPECT_THAT(redirectFault(http, "https://host/b", true), HasSubstr("one, https://host;"));
  EXPECT_THAT(redirectFault(https, "http://host/b", false), HasSubstr("one, http://host;"));
  EXPECT_THAT(redirectFault(http, "https://host:444/b", false), HasSubstr("https://host:444;"));
  EXPECT_THAT(redirectFault(https, "https://a:b@host.evil/b?key=1", false),
              AllOf(HasSubstr("https://host.evil;"), Not(HasSubstr("key"))));
  EXPECT_THAT(redirectFault(https, "file:///etc/passwd", false), HasSubstr("no address of http"));
}

// The first connection hangs, and the second gives the voxels.
TEST_F(WebFaults, theFirstConnectionMayHang) {
  const WebServer server(root(), "late");
  EXPECT_TRUE(voxelsAt(server.address() + "/one_shard") == voxelsOf("one_shard"));
}

TEST_F(WebFaults, withoutAnAnswerThereIsOneLineInHalfAMinute) {
  const DeafServer full(true), deaf(false);
  const WebServer trickle(root(), "trickle"), stalls(root(), "stall-metadata"),
      stalls_late(root(), "stall-chunks");
  const std::vector<std::string> addresses = {"http://" + full.host(),  "http://" + deaf.host(),
                                              "https://" + deaf.host(), trickle.address(),
                                              stalls.address(),         stalls_late.address()};
  std::vector<std::string> lines(addresses.size());
  std::vector<double> spent(addresses.size());
  std::vector<std::thread> threads;
  for (size_t i = 0; i < addresses.size(); ++i)
    threads.emplace_back([&, i] {
      const auto begin = steady_clock::now();
      lines[i] = voxelsAt(addresses[i] + "/one_shard");
      spent[i] = std::chrono::duration<double>(steady_clock::now() - begin).count();
    });
  for (std::thread& thread : threads) thread.join();
  for (size_t i = 0; i < addresses.size(); ++i) {
    SCOPED_TRACE(lines[i]);
    EXPECT_THAT(lines[i], AllOf(StartsWith(addresses[i] + "/one_shard"), HasSubstr("tried"),
                                Not(HasSubstr("\n"))));
    EXPECT_LT(spent[i], 30);
  }
}

TEST_F(WebFaults, aStopEndsEachStageWithinASecond) {
  const DeafServer full(true), deaf(false);
  const WebServer stalls(root(), "stall-metadata"), stalls_late(root(), "stall-chunks");
  const std::map<std::string, std::string> stages = {{"connection", "http://" + full.host()},
                                                     {"encryption", "https://" + deaf.host()},
                                                     {"answer", "http://" + deaf.host()},
                                                     {"metadata", stalls.address()},
                                                     {"chunks", stalls_late.address()}};
  for (const auto& [stage, address] : stages) {
    SCOPED_TRACE(stage);
    StopSource stop;
    steady_clock::time_point stopped;
    std::thread stopping([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(500));
      stopped = steady_clock::now();
      stop.requestStop();
    });
    EXPECT_THROW(voxelsAt(address + "/one_shard", stop.token()), Interrupted);
    const auto ended = steady_clock::now();
    stopping.join();
    EXPECT_LT(ended - stopped, seconds(1));
  }
}

}  // namespace
}  // namespace sluice
