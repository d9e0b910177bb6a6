#include <gmock/gmock.h>

#include <cstdlib>
#include <map>
#include <thread>

#include "io/open_volume.h"
#include "io/web/address.h"
#include "io/zarr/reading/zarr_source.h"
#include "tests/io/python_volumes.h"
#include "tests/io/web/web_case.h"
#include "tests/io/web/web_server.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class WebVolume : public PythonVolumesTest<WebCase> {
 protected:
  static std::string root() { return folder_.string(); }
  // The voxels of a store of some chunks, or the error.
  static std::string voxelsFrom(const WebServer& server, const std::string& name) {
    try {
      return allSteps(*openVolume(server.address() + "/" + name));
    } catch (const Error& error) {
      return error.what();
    }
  }
};

TEST_F(WebVolume, hasTheVoxelsOfTheFolderAndAsksForNothingTwice) {
  const WebServer server(root());
  for (const WebCase& c : cases_) {
    SCOPED_TRACE(c.name);
    OpenOptions options;
    options.channel = c.options().channel;
    const auto source = openVolume(server.address() + "/" + c.name, options);
    EXPECT_EQ(source->layout().dims, c.dims);
    EXPECT_EQ(source->layout().name, c.name);
    EXPECT_TRUE(allSteps(*source) == voxelsOf(c.name));
  }
  std::map<std::string, int> times;
  // Each volume looks for an image around it.
  for (const WebRequest& r : server.requests())
    if (r.path.find('/') != std::string::npos) ++times[r.path + " " + r.range];
  for (const auto& [request, count] : times) EXPECT_EQ(count, 1) << request;
}

TEST_F(WebVolume, readsOneIndexOfAShardAndTheChunksOfABox) {
  const WebServer server(root());
  const auto source = openVolume(server.address() + "/one_shard");
  readBox(*source, {{0, 0, 0}, {5, 4, 2}}, 0);
  std::vector<std::string> ranges;
  for (const WebRequest& r : server.requests())
    if (r.path == "one_shard/c/0/0/0") ranges.push_back(r.range);
  ASSERT_GE(ranges.size(), 2U);
  EXPECT_EQ(ranges[0], "bytes=-2052");
  EXPECT_LE(ranges.size(), 3U);
}

// A picture is the same as from disk, or there is one line that says what is wrong.
TEST_F(WebVolume, faultsThatPassChangeNoVoxel) {
  for (const char* fault : {"drop", "silent", "delay", "busy", "broken", "long"})
    for (const char* name : {"one_shard", "keys_v2_slash"}) {
      // Too long an object of numbers as they are cannot be told from another type of number.
      if (fault == std::string("long") && name == std::string("keys_v2_slash")) continue;
      SCOPED_TRACE(std::string(fault) + " " + name);
      const WebServer server(root(), fault);
      EXPECT_TRUE(voxelsFrom(server, name) == voxelsOf(name)) << voxelsFrom(server, name);
    }
}

TEST_F(WebVolume, aDroppedObjectGoesOnWhereItStopped) {
  const WebServer server(root(), "drop");
  EXPECT_TRUE(voxelsFrom(server, "one_shard") == voxelsOf("one_shard"));
  std::map<std::string, int> times;
  for (const WebRequest& r : server.requests()) ++times[r.path + " " + r.range];
  for (const auto& [request, count] : times) EXPECT_EQ(count, 1) << request;
}

TEST_F(WebVolume, faultsThatDoNotPassAreOneLine) {
  const std::map<std::string, std::string> lines = {{"changed", "changed while"},
                                                    {"gzip", "Content-Encoding"}};
  for (const auto& [fault, line] : lines) {
    SCOPED_TRACE(fault);
    const WebServer server(root(), fault);
    const std::string error = voxelsFrom(server, "one_shard");
    EXPECT_THAT(error, AllOf(StartsWith(server.address() + "/one_shard"), HasSubstr(line),
                             Not(HasSubstr("\n"))));
  }
}

TEST_F(WebVolume, aServerIsFollowedToItsOwnPlacesAndToNoOtherServer) {
  const WebServer moved(root(), "moved"), other(root()), sends(root(), "to=" + other.address());
  EXPECT_TRUE(voxelsFrom(moved, "one_shard") == voxelsOf("one_shard"));
  const std::string error = voxelsFrom(sends, "one_shard");
  EXPECT_THAT(error, AllOf(StartsWith(sends.address() + "/one_shard"),
                           HasSubstr(": the server sends to another one, " + other.address() + ";"),
                           Not(HasSubstr("\n"))));
  EXPECT_THAT(other.requests(), testing::IsEmpty());
}

// A small object may come whole where a part was asked for.
TEST_F(WebVolume, aServerWithoutPartsSendsSmallObjectsWhole) {
  const WebServer server(root(), "whole");
  EXPECT_TRUE(voxelsFrom(server, "one_shard") == voxelsOf("one_shard"));
}

TEST_F(WebVolume, whatIsNoStoreAndWhatIsForbiddenIsOneLine) {
  const WebServer plain(root()), forbidding(root(), "forbidden");
  EXPECT_THAT(errorOf([&] { openVolume(plain.address() + "/cases.txt"); }),
              HasSubstr("expected a Zarr or N5 store"));
  EXPECT_THAT(errorOf([&] { openVolume(forbidding.address() + "/nothing"); }),
              HasSubstr("expected a Zarr or N5 store"));
  EXPECT_TRUE(voxelsFrom(forbidding, "one_shard") == voxelsOf("one_shard"));
  EXPECT_THAT(
      errorOf([] { openVolume("http://127.0.0.1:1/a.zarr"); }),
      AllOf(StartsWith("http://127.0.0.1:1/a.zarr"), HasSubstr(": no connection (Failed to"),
            HasSubstr("tried 6 times"), HasSubstr("; check the address, or try again later"),
            Not(HasSubstr("expected"))));
  const WebServer down(root(), "down");
  EXPECT_THAT(errorOf([&] { openVolume(down.address() + "/one_shard"); }),
              AllOf(StartsWith(down.address() + "/one_shard"),
                    HasSubstr(": the server answered with status 500; tried 6 times"),
                    HasSubstr("try again later")));
}

TEST_F(WebVolume, neverPrintsAPasswordOrAQuery) {
  const WebServer server(root());
  const std::string host = server.address().substr(7);
  const std::string address = "http://me:secret@" + host + "/one_shard?token=hidden";
  const auto source = openVolume(address);
  EXPECT_TRUE(allSteps(*source) == voxelsOf("one_shard"));
  std::string printed = source->identity() + source->layout().name;
  for (const std::string& file : source->files()) printed += file;
  printed += errorOf([&] { openVolume("http://me:secret@" + host + "/x?token=hidden"); });
  EXPECT_THAT(printed, AllOf(Not(HasSubstr("secret")), Not(HasSubstr("hidden"))));
  EXPECT_THAT(server.requests().back().authorization, StartsWith("Basic "));
}

TEST_F(WebVolume, ofABucketIsReadWithASignature) {
  const WebServer server(root());
  OpenOptions options;
  options.web.buckets = {server.address(), "eu-west-1", "AKIDEXAMPLE", "secret", ""};
  const auto source = openVolume("s3://image/scale1/image", options);
  EXPECT_TRUE(allSteps(*source) == readFile(pathOf("image_coarse.bin")));
  EXPECT_THAT(server.requests().back().authorization,
              AllOf(StartsWith("AWS4-HMAC-SHA256 Credential=AKIDEXAMPLE/"),
                    HasSubstr("/eu-west-1/s3/aws4_request")));
}

TEST_F(WebVolume, readingEndsWhenItIsStopped) {
  const WebServer server(root(), "delay");
  StopSource stop;
  OpenOptions options;
  options.stop = stop.token();
  const auto source = openVolume(server.address() + "/one_shard", options);
  stop.requestStop();
  EXPECT_THROW(readAll(*source), Interrupted);
}

TEST(WebAddress, isParted) {
  const Address plain = parseAddress("https://me:pw@host:81/a/b.zarr/?x=1#c");
  EXPECT_EQ(plain.server, "https://host:81");
  EXPECT_EQ(plain.key, "a/b.zarr");
  EXPECT_EQ(plain.query, "?x=1");
  EXPECT_EQ(plain.user, "me:pw");
  EXPECT_EQ(printedAddress(plain), "https://host:81/a/b.zarr");
  EXPECT_EQ(printedAddress(parseAddress("s3://data/v.zarr")),
            "https://data.s3.us-east-1.amazonaws.com/v.zarr");
  EXPECT_EQ(printedAddress(parseAddress("s3://my.data/v.zarr", {"", "eu-west-1", "", "", ""})),
            "https://s3.eu-west-1.amazonaws.com/my.data/v.zarr");
  EXPECT_EQ(
      printedAddress(parseAddress("s3://data/v.zarr", {"http://localhost:9000/", "", "", "", ""})),
      "http://localhost:9000/data/v.zarr");
  for (const char* wrong :
       {"http://", "https:///a", "https://host", "https://host/", "s3://", "s3:///a"})
    EXPECT_THAT(errorOf([&] { parseAddress(wrong); }), HasSubstr("expected an address")) << wrong;
  EXPECT_FALSE(isAddress("a/http://b"));
}

}  // namespace
}  // namespace sluice
