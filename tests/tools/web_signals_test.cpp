// Ctrl-C while a server keeps the program waiting, at each stage of a picture.
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <chrono>
#include <filesystem>
#include <vector>

#include "src/base/files/descriptor.h"
#include "tests/io/web/web_server.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

struct WebStage {
  const char* name;
  const char* command;
  const char* fault;    // of the server
  const char* request;  // the signal is sent once its log has this
};

// The server stalls in the answer that the program waits for.
const WebStage kStages[] = {
    {"noAnswer", "render", "deaf", "v.zarr"},
    {"metadata", "render", "stall-metadata", "v.zarr/zarr.json"},
    {"metadataOfInfo", "info", "stall-metadata", "v.zarr/zarr.json"},
    {"metadataOfPlan", "plan", "stall-metadata", "v.zarr/zarr.json"},
    {"listOfLevels", "render", "stall-levels", "v.zarr/1/zarr.json"},
    {"chunks", "render", "stall-chunks", "/c/"},
    {"trickle", "render", "trickle", "v.zarr/zarr.json"},
    {"waitBeforeTheNextTry", "render", "later", "503"},
    {"fetch", "fetch", "stall-chunks", "/c/"},
};

class WebSignals : public testing::TestWithParam<WebStage> {};

TEST_P(WebSignals, endTheProgramAtOnceAndLeaveNoTemporary) {
  const WebStage& stage = GetParam();
  const Program program;
  ASSERT_EQ(program
                .run("pack synth:shells,dims=70x60x50 -q -o v.zarr --zarr 3 --chunk 16 "
                     "--shard 32,32,32 --levels auto")
                .status,
            0);
  const WebServer server(program.folder.path(), stage.fault);
  const std::string word = stage.command;
  std::string line = word + " " + server.address() + "/v.zarr";
  if (word != "fetch") line += " --cache 1G --cache-dir kept";
  if (word == "render") line += " -q --size 100 --threshold 90 -o a.png";
  if (word == "fetch") line += " -q -o copy.zarr";
  // The file's time is that of the signal.
  const CommandResult ended =
      program.signalled(line, "INT",
                        "grep -q " + shellQuoted(stage.request) + " " +
                            shellQuoted(server.log().string()) + " && sleep 0.2 && touch sent");
  const auto waited =
      fs::file_time_type::clock::now() - fs::last_write_time(program.folder / "sent");
  EXPECT_EQ(ended.status, 130) << ended.output;
  EXPECT_THAT(ended.output, testing::HasSubstr("sluice: interrupted"));
  EXPECT_EQ(std::count(ended.output.begin(), ended.output.end(), '\n'), 1) << ended.output;
  EXPECT_LT(std::chrono::duration<double>(waited).count(), 1.0);
  EXPECT_FALSE(program.exists("a.png"));
  EXPECT_FALSE(program.exists("copy.zarr"));
  for (const auto& entry : fs::recursive_directory_iterator(program.folder.path())) {
    const std::string name = entry.path().filename().string();
    EXPECT_FALSE(entry.path().extension() == ".tmp" || name.starts_with("writing-")) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Stages, WebSignals, testing::ValuesIn(kStages),
                         [](const auto& stage) { return std::string(stage.param.name); });

// A server that takes no more connections, and one that never speaks TLS.
TEST(WebSignal, endsTheProgramWhileItConnects) {
  const Program program;
  for (const bool is_full : {true, false}) {
    const Descriptor listener(socket(AF_INET, SOCK_STREAM, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    ASSERT_EQ(bind(listener.get(), any, size), 0);
    ASSERT_EQ(listen(listener.get(), is_full ? 0 : 64), 0);
    ASSERT_EQ(getsockname(listener.get(), any, &size), 0);
    std::vector<Descriptor> waiting;
    for (int i = 0; is_full && i < 4; ++i) {
      waiting.emplace_back(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0));
      connect(waiting.back().get(), any, size);
    }
    const CommandResult ended =
        program.signalled(fmt::format("info {}://127.0.0.1:{}/v.zarr", is_full ? "http" : "https",
                                      ntohs(address.sin_port)),
                          "INT", "sleep 1 && touch sent");
    const auto waited =
        fs::file_time_type::clock::now() - fs::last_write_time(program.folder / "sent");
    EXPECT_EQ(ended.status, 130) << ended.output;
    EXPECT_EQ(ended.output, "sluice: interrupted\n");
    EXPECT_LT(std::chrono::duration<double>(waited).count(), 1.0);
  }
}

}  // namespace
}  // namespace sluice
