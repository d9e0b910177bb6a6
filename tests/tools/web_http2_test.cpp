// A volume on a server that speaks HTTP/2: nghttpd, with a certificate of its own.
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <regex>
#include <set>

#include "src/base/files/descriptor.h"
#include "tests/io/python_volumes.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

// A port that nobody listens at now.
int freePort() {
  const Descriptor probe(socket(AF_INET, SOCK_STREAM, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  if (bind(probe.get(), any, size) != 0 || getsockname(probe.get(), any, &size) != 0)
    throw Error("no free port");
  return ntohs(address.sin_port);
}

class WebHttp2 : public testing::Test {
 protected:
  void SetUp() override {
    if (runCommand("PATH=$PATH:/usr/sbin; command -v nghttpd && command -v openssl").status != 0)
      GTEST_SKIP() << "nghttpd or openssl is not installed";
    const CommandResult made = inFolder(
        "openssl req -x509 -newkey rsa:2048 -nodes -keyout key.pem -out cert.pem -days 2 "
        "-subj /CN=localhost -addext subjectAltName=DNS:localhost");
    ASSERT_EQ(made.status, 0) << made.output;
  }
  CommandResult inFolder(const std::string& line) const {
    return runCommand("cd " + shellQuoted(program_.folder.path().string()) + " && " + line);
  }
  // Runs a line of sh while nghttpd serves the folder at https://localhost:$port. Its log is
  // appended to "log".
  CommandResult served(const std::string& line) const {
    return inFolder(
        "{ unset CURL_CA_BUNDLE SSL_CERT_FILE SSL_CERT_DIR; export PATH=$PATH:/usr/sbin port=" +
        std::to_string(freePort()) +
        "; nghttpd -v -d . $port key.pem cert.pem > now 2>&1 & server=$!; "
        "tries=0; until grep -q listen now || [ $tries -gt 200 ]; do tries=$((tries + 1)); "
        "sleep 0.05; done; " +
        line +
        "\nstatus=$?; kill $server; wait $server 2>/dev/null; cat now >> log; exit $status; }");
  }

  const Program program_;
  const std::string trusted_ = "CURL_CA_BUNDLE=cert.pem " SLUICE_PROGRAM " ";
};

TEST_F(WebHttp2, givesThePictureOfTheDiskOverFewConnections) {
  ASSERT_EQ(program_.run("pack synth:shells,dims=120x110x100 -q -o v.zarr --chunk 16 --levels auto")
                .status,
            0);
  const std::string look = " --threshold 90 --size 200 --pixel-error 1 -q -o ";
  ASSERT_EQ(program_.run("render v.zarr" + look + "disk.png").status, 0);
  const CommandResult drawn =
      served(trusted_ + "render https://localhost:$port/v.zarr" + look + "web.png");
  ASSERT_EQ(drawn.status, 0) << drawn.output;
  EXPECT_EQ(inFolder("cmp disk.png web.png").status, 0);
  const std::string log = readFile(program_.folder / "log");
  const std::regex request(R"(\[id=(\d+)\] \[ *[\d.]+\] recv \(stream_id=\d+\) :path: )");
  std::set<std::string> connections;
  int requests = 0;
  for (std::sregex_iterator at(log.begin(), log.end(), request), end; at != end; ++at, ++requests)
    connections.insert((*at)[1]);
  EXPECT_GT(requests, 200);
  EXPECT_LE(connections.size(), 2U) << requests << " requests";
}

// Each variable that curl looks at, and none: a server whose certificate nobody vouches for.
TEST_F(WebHttp2, trustsTheAuthoritiesThatTheUserNames) {
  ASSERT_EQ(program_.run("pack synth:shells,dims=20x20x20 -q -o v.zarr").status, 0);
  ASSERT_EQ(inFolder("mkdir -p trusted && cp cert.pem trusted && openssl rehash trusted").status,
            0);
  const std::string info = SLUICE_PROGRAM " info https://localhost:$port/v.zarr";
  for (const char* variable :
       {"CURL_CA_BUNDLE=cert.pem ", "SSL_CERT_FILE=cert.pem ", "SSL_CERT_DIR=trusted ",
        "CURL_CA_BUNDLE=cert.pem SSL_CERT_FILE=no "}) {
    const CommandResult told = served(variable + info);
    EXPECT_EQ(told.status, 0) << variable << told.output;
  }
  for (const char* variable : {"", "CURL_CA_BUNDLE=none.pem "}) {
    const CommandResult refused = served(variable + info);
    EXPECT_EQ(refused.status, 1) << variable;
    EXPECT_THAT(refused.output, testing::HasSubstr("certificate"));
    EXPECT_TRUE(isOneLine(refused.output)) << refused.output;
  }
}

}  // namespace
}  // namespace sluice
