// `plan` of a volume on a server, against what the server was asked for.
#include <gmock/gmock.h>

#include <cctype>
#include <map>

#include "tests/io/web/web_server.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Names of chunks and shards are numbers.
bool isMetadata(const std::string& path) {
  return std::isdigit(static_cast<unsigned char>(path[path.rfind('/') + 1])) == 0;
}

// The requests for chunks and indices since a moment.
struct Asked {
  int64_t requests = 0;
  uint64_t bytes = 0;   // of their bodies
  int most_of_one = 0;  // the same part, asked for so often
};

Asked askedSince(const WebServer& server, size_t begin) {
  Asked asked;
  std::map<std::string, int> times;
  const std::vector<WebRequest> all = server.requests();
  for (size_t i = begin; i < all.size(); ++i) {
    if (isMetadata(all[i].path)) continue;
    ++asked.requests;
    if (all[i].status < 400) asked.bytes += all[i].bytes;
    asked.most_of_one = std::max(asked.most_of_one, ++times[all[i].path + " " + all[i].range]);
  }
  return asked;
}

constexpr const char* kLook = " --threshold 90 --size 200 ";
constexpr const char* kVolume = "synth:shells,dims=200x180x150";

struct StoreCase {
  const char* name;
  const char* pack;
};
constexpr StoreCase kStores[] = {
    {"shards.zarr", " --zarr 3 --chunk 32 --shard 64,64,128 --levels none"},
    {"files.zarr", " --zarr 2 --chunk 32 --levels none"},
    {"levels.zarr", " --zarr 3 --chunk 32 --shard 64,64,64 --levels auto"}};

class WebPlan : public testing::Test {
 protected:
  void pack(const StoreCase& store) const {
    const CommandResult made =
        program_.run(std::string("pack ") + kVolume + " -q -o " + store.name + store.pack);
    ASSERT_EQ(made.status, 0) << made.output;
  }
  std::string address(const WebServer& server, const StoreCase& store) const {
    return server.address() + "/" + store.name;
  }

  const Program program_;
};

// With an index, the plan reads metadata alone, and the picture no more than it says.
TEST_F(WebPlan, tellsTheRequestsAndBytesOfAPicture) {
  for (const StoreCase& store : kStores) {
    SCOPED_TRACE(store.name);
    pack(store);
    const WebServer server(program_.folder.path());
    ASSERT_EQ(program_.run("info " + address(server, store)).status, 0);
    size_t before = server.requests().size();
    const nlohmann::json plan = program_.json("plan " + address(server, store) + kLook)["store"];
    EXPECT_EQ(askedSince(server, before).requests, 0);
    before = server.requests().size();
    const CommandResult drawn =
        program_.run("render " + address(server, store) + kLook + "-q --force -o a.png");
    ASSERT_EQ(drawn.status, 0) << drawn.output;
    const Asked asked = askedSince(server, before);
    EXPECT_EQ(asked.most_of_one, 1);
    EXPECT_GT(asked.requests, 0);
    EXPECT_LE(asked.requests, plan["requests"].get<int64_t>());
    EXPECT_GE(asked.requests, plan["requests"].get<int64_t>() / 2);  // chunks may be missing
    EXPECT_LE(static_cast<double>(asked.bytes), 1.1 * plan["most_bytes"].get<double>());
    EXPECT_FALSE(plan.contains("first_pass"));
    const CommandResult local = program_.run(std::string("render ") + store.name + kLook +
                                             "-q --force -o b.png && cmp a.png b.png");
    EXPECT_EQ(local.status, 0) << local.output;
  }
}

// What the disk cache has is told, with the exact bytes of the rest.
TEST_F(WebPlan, countsWhatTheCacheHas) {
  for (const StoreCase& store : {kStores[0], kStores[1]}) {
    SCOPED_TRACE(store.name);
    pack(store);
    const WebServer server(program_.folder.path());
    const std::string volume = address(server, store) + " --cache 1G --cache-dir kept" + kLook;
    ASSERT_EQ(program_.run("render " + volume + "-q --force -o a.png").status, 0);
    const nlohmann::json plan = program_.json("plan " + volume)["store"];
    // Shards that the server does not have are asked for again.
    EXPECT_GT(plan["cached"].get<int64_t>(), plan["requests"].get<int64_t>() * 8 / 10);
    const nlohmann::json without = program_.json("plan " + address(server, store) + kLook)["store"];
    EXPECT_EQ(without["cached"], 0);
    EXPECT_LT(plan["most_bytes"].get<double>(), 0.1 * without["most_bytes"].get<double>());
    const size_t before = server.requests().size();
    ASSERT_EQ(program_.run("render " + volume + "-q --force -o a.png").status, 0);
    EXPECT_EQ(askedSince(server, before).bytes, 0U);
  }
}

// Without an index and without levels a picture reads everything: the plan says so and reads
// nothing.
TEST_F(WebPlan, readsNothingOfAVolumeWithoutAnIndex) {
  for (const StoreCase& store : {kStores[0], kStores[1]}) {
    SCOPED_TRACE(store.name);
    pack(store);
    const WebServer server(program_.folder.path());
    const std::string volume = address(server, store) + kLook;
    const nlohmann::json pass = program_.json("plan " + volume)["store"]["first_pass"];
    EXPECT_EQ(askedSince(server, 0).requests, 0);
    EXPECT_EQ(pass["level"], 0);
    const CommandResult said = program_.run("plan " + volume);
    EXPECT_EQ(said.status, 0);
    EXPECT_THAT(said.output,
                HasSubstr("has no index here, so that the first picture reads all of level 0"));
    const size_t before = server.requests().size();
    ASSERT_EQ(program_.run("render " + volume + "-q --force -o a.png").status, 0);
    const Asked asked = askedSince(server, before);
    EXPECT_EQ(asked.most_of_one, 1);
    EXPECT_LE(asked.requests, pass["requests"].get<int64_t>());
    EXPECT_LE(static_cast<double>(asked.bytes), 1.1 * pass["most_bytes"].get<double>());
  }
}

// With levels, the coarse level that is read for its values is told before it is read.
TEST_F(WebPlan, tellsTheLevelThatIsReadForItsValues) {
  const StoreCase& store = kStores[2];
  pack(store);
  const WebServer server(program_.folder.path());
  const std::string volume = address(server, store) + " --threshold 90 --size 40 --pixel-error 2 ";
  const nlohmann::json plan = program_.json("plan " + volume)["store"];
  ASSERT_TRUE(plan.contains("first_pass")) << plan;
  const Asked asked = askedSince(server, 0);
  EXPECT_GT(asked.requests, 0);
  EXPECT_LE(asked.requests, plan["first_pass"]["requests"].get<int64_t>());
  EXPECT_LE(static_cast<double>(asked.bytes), 1.1 * plan["first_pass"]["most_bytes"].get<double>());
  EXPECT_THAT(program_.run("plan " + volume).output, HasSubstr("is read for its values"));
  const size_t before = server.requests().size();
  ASSERT_EQ(program_.run("render " + volume + "-q --force -o a.png").status, 0);
  const Asked drawn = askedSince(server, before);
  const auto sumOf = [&](const char* field) {
    return plan[field].get<double>() + plan["first_pass"][field].get<double>();
  };
  EXPECT_LE(static_cast<double>(drawn.requests), sumOf("requests"));
  EXPECT_LE(static_cast<double>(drawn.bytes), 1.1 * sumOf("most_bytes"));
  EXPECT_EQ(drawn.most_of_one, 1);
}

// Blocks of 4 voxels have no room for the border that several levels take.
TEST_F(WebPlan, ofTheSmallestBlocksIsThatOfLevelZero) {
  for (const StoreCase& store : kStores) {
    SCOPED_TRACE(store.name);
    const CommandResult made = program_.run(std::string("pack synth:shells,dims=21x19x17 -q -o ") +
                                            store.name + store.pack);
    ASSERT_EQ(made.status, 0) << made.output;
    const WebServer server(program_.folder.path());
    const std::string volume = address(server, store) + kLook + "--block 4 ";
    const nlohmann::json plan = program_.json("plan " + volume)["store"];
    EXPECT_EQ(plan["first_pass"]["level"], 0);
    EXPECT_EQ(program_.run("render " + volume + "-q --force -o a.png").status, 0);
    // Levels that are asked for are refused, as by render.
    const CommandResult refused = program_.run("plan " + volume + "--pixel-error 4");
    EXPECT_EQ(refused.status, program_.run("render " + volume + "--pixel-error 4 -o b.png").status);
    EXPECT_THAT(refused.output, Not(HasSubstr("internal")));
  }
}

TEST_F(WebPlan, neverPrintsAPassword) {
  pack(kStores[0]);
  pack(kStores[2]);
  const WebServer server(program_.folder.path());
  const std::string host = server.address().substr(7);
  for (const char* store : {"shards.zarr", "levels.zarr", "none"}) {
    const std::string volume = fmt::format(" 'http://me:secret@{}/{}?token=hidden' ", host, store);
    for (const std::string& line :
         {"plan" + volume, "plan" + volume + "--json", "info" + volume + "--json",
          "info" + volume + "--time 3", "info" + volume + "--channel 1,2",
          "render" + volume + "--force -q --size 40 --pixel-error 2 -o a.png --report r.json",
          "render" + volume + "--force --size 40 -o a.exr --json && cat r.json a.exr",
          "render synth:phantom,dims=16x16x16 --over" + volume +
              "--force -q --size 40 -o a.png --report r.json; cat r.json",
          "bench skipping" + volume + "--frames 1 --size 40 --json",
          "plan" + volume + "--culling toc", "fetch" + volume, "fetch --json --force" + volume}) {
      SCOPED_TRACE(line);
      EXPECT_THAT(program_.run(line).output,
                  AllOf(Not(HasSubstr("secret")), Not(HasSubstr("token="))));
    }
  }
  // Nor is one in the name of a file.
  for (const auto& entry : std::filesystem::recursive_directory_iterator(program_.folder.path()))
    EXPECT_THAT(entry.path().string(), AllOf(Not(HasSubstr("secret")), Not(HasSubstr("hidden"))));
}

// Chunks that are planes: decoded once if memory holds a row of blocks of them, otherwise at most
// as often as the plan says.
TEST(PlanDecodes, ofPlanesAreNoMoreThanThePlanSays) {
  const Program program;
  const CommandResult made =
      runCommand("cd " + shellQuoted(program.folder.path().string()) +
                 " && /usr/bin/python3 -c \"import numpy, zarr\nn = 192\n"
                 "g = numpy.indices((n, n, n)).sum(0)\n"
                 "a = zarr.open('planes', mode='w', shape=(n, n, n), chunks=(1, n, n), dtype='u2', "
                 "compressor=None)\na[:] = g\"");
  if (made.status != 0) GTEST_SKIP() << "Python has no numpy or zarr";
  constexpr double kChunk = 192 * 192 * 2;
  ASSERT_EQ(program.run("info planes").status, 0);
  for (const char* memory : {"512M", "64M", "24M", "16M"}) {
    SCOPED_TRACE(memory);
    const std::string options = std::string(
                                    " planes --threshold 20 --block 32 --device cpu --threads 1 "
                                    "--size 100 --memory ") +
                                memory;
    const nlohmann::json plan = program.json("plan" + options)["store"];
    const nlohmann::json drawn = program.json("render" + options + " --force -o a.png");
    const double decoded = drawn["levels"]["disk"]["read_bytes"].get<double>() / kChunk;
    EXPECT_EQ(plan["chunks"], 192);
    const bool is_enough = plan["decoded_bytes"].get<double>() * 16 < std::stod(memory) * (1 << 20);
    const double told = plan["most_decodes"].get<double>();
    EXPECT_LT(decoded, told + 1);  // the headers are less than a chunk
    if (is_enough) {
      EXPECT_EQ(told, 192);
      EXPECT_THAT(program.run("plan" + options).output, HasSubstr("decodes 192 chunks, each once"));
    }
    if (std::string(memory) == "16M") {
      EXPECT_GT(decoded, 192);
      EXPECT_THAT(program.run("plan" + options).output, HasSubstr("decodes 192 chunks up to "));
    }
  }
}

}  // namespace
}  // namespace sluice
