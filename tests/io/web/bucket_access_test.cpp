#include "io/web/bucket_access.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/support/error_of.h"
#include "tests/support/temp_folder.h"

namespace sluice {
namespace {

using testing::HasSubstr;

class Bucket : public testing::Test {
 protected:
  Bucket() {
    std::filesystem::create_directory(folder_ / ".aws");
    writeFile(folder_ / ".aws" / "credentials",
              "# keys\n[default]\naws_access_key_id = ONE\naws_secret_access_key=first\n\n"
              "[lab]\r\n  aws_access_key_id=TWO\r\naws_secret_access_key = se=cond \r\n"
              "aws_session_token = token\n");
    writeFile(folder_ / ".aws" / "config",
              "[default]\nregion = eu-north-1\n[profile lab]\nregion = us-west-2\n"
              "endpoint_url = http://127.0.0.1:9000\n");
    set_["HOME"] = folder_.path().string();
  }
  BucketAccess access() const {
    return bucketAccess([&](const char* name) {
      const auto found = set_.find(name);
      return found == set_.end() ? std::string() : found->second;
    });
  }

  const TempFolder folder_;
  std::map<std::string, std::string> set_;
};

TEST_F(Bucket, isReadWithTheDefaultProfile) {
  EXPECT_EQ(access().access_key, "ONE");
  EXPECT_EQ(access().secret_key, "first");
  EXPECT_EQ(access().region, "eu-north-1");
  EXPECT_EQ(access().endpoint, "");
}

TEST_F(Bucket, isReadWithTheProfileThatIsNamed) {
  set_["AWS_PROFILE"] = "lab";
  EXPECT_EQ(access().access_key, "TWO");
  EXPECT_EQ(access().secret_key, "se=cond");
  EXPECT_EQ(access().session_token, "token");
  EXPECT_EQ(access().region, "us-west-2");
  EXPECT_EQ(access().endpoint, "http://127.0.0.1:9000");
}

TEST_F(Bucket, isReadWithWhatTheEnvironmentSays) {
  set_["AWS_PROFILE"] = "lab";
  set_["AWS_ACCESS_KEY_ID"] = "THREE";
  EXPECT_EQ(access().access_key, "TWO") << "half a key is none";
  set_["AWS_SECRET_ACCESS_KEY"] = "third";
  set_["AWS_DEFAULT_REGION"] = "sa-east-1";
  set_["AWS_ENDPOINT_URL"] = "https://store";
  EXPECT_EQ(access().access_key, "THREE");
  EXPECT_EQ(access().secret_key, "third");
  EXPECT_EQ(access().session_token, "") << "the token of another key";
  EXPECT_EQ(access().region, "sa-east-1");
  EXPECT_EQ(access().endpoint, "https://store");
  set_["AWS_REGION"] = "ca-central-1";
  EXPECT_EQ(access().region, "ca-central-1");
}

TEST_F(Bucket, isReadWithoutASignatureIfNothingSaysAKey) {
  set_["HOME"] = (folder_ / "elsewhere").string();
  EXPECT_EQ(access().access_key, "");
  EXPECT_EQ(access().region, "us-east-1");
}

TEST_F(Bucket, hasNoProfileOfAnUnknownName) {
  set_["AWS_PROFILE"] = "lap";
  EXPECT_THAT(errorOf([&] { static_cast<void>(access()); }), HasSubstr("no profile lap in "));
  set_["AWS_SHARED_CREDENTIALS_FILE"] = (folder_ / "mine").string();
  writeFile(folder_ / "mine", "[lap]\naws_access_key_id=A\naws_secret_access_key=B\n");
  EXPECT_EQ(access().access_key, "A");
}

}  // namespace
}  // namespace sluice
