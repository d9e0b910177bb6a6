// Environment variables of the program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <string>

#include "src/base/error.h"
#include "src/gl/contexts/gl_choice.h"
#include "tools/command_line/environment.h"
#include "tools/options/view_arguments.h"

namespace sluice {
namespace {

using testing::ThrowsMessage;

// An environment variable for the time of a test.
class ScopedVariable {
 public:
  ScopedVariable(const char* name, const char* value) : name_(name) {
    const char* before = getenv(name);
    if (before != nullptr) before_ = before;
    if (value == nullptr)
      unsetenv(name);
    else
      setenv(name, value, 1);
  }
  ~ScopedVariable() {
    if (before_)
      setenv(name_, before_->c_str(), 1);
    else
      unsetenv(name_);
  }
  ScopedVariable(const ScopedVariable&) = delete;
  ScopedVariable& operator=(const ScopedVariable&) = delete;

 private:
  const char* const name_;
  std::optional<std::string> before_;
};

TEST(IndexWish, theCacheFolderOrWhereTheUserSays) {
  const ScopedVariable xdg("XDG_CACHE_HOME", "/caches"), setting("SLUICE_INDEX", nullptr);
  {
    const ScopedVariable folder("SLUICE_INDEX_DIR", nullptr);
    EXPECT_EQ(indexWish("").folder, "/caches/sluice/index");
  }
  const ScopedVariable folder("SLUICE_INDEX_DIR", "/scratch");
  EXPECT_EQ(indexWish("").folder, "/scratch");
  EXPECT_EQ(indexWish("/mine").folder, "/mine");
  EXPECT_EQ(indexWish("here").folder, "here");
  EXPECT_FALSE(indexWish("").beside || indexWish("").disabled);
}

TEST(IndexWish, homeStandsInForTheCacheVariable) {
  const ScopedVariable xdg("XDG_CACHE_HOME", nullptr), home("HOME", "/home/ada");
  const ScopedVariable folder("SLUICE_INDEX_DIR", nullptr);
  EXPECT_EQ(indexWish("").folder, "/home/ada/.cache/sluice/index");
  const ScopedVariable homeless("HOME", nullptr);
  EXPECT_EQ(indexWish("").folder, "");
  const ScopedVariable odd("XDG_CACHE_HOME", "relative");
  EXPECT_EQ(indexWish("").folder, "");
}

TEST(IndexWish, besideTheVolumeOrNowhere) {
  const ScopedVariable beside("SLUICE_INDEX", "beside");
  EXPECT_TRUE(indexWish("").beside);
  EXPECT_FALSE(indexWish("/mine").beside) << "--index-dir goes before it";
  const ScopedVariable off("SLUICE_INDEX", "off");
  EXPECT_TRUE(indexWish("").disabled);
  EXPECT_TRUE(indexWish("/mine").disabled);
}

TEST(IndexWish, refusesValuesThatMeanNothing) {
  const ScopedVariable xdg("XDG_CACHE_HOME", "/caches"), setting("SLUICE_INDEX", nullptr);
  const ScopedVariable folder("SLUICE_INDEX_DIR", "rel");
  EXPECT_THAT([] { indexWish(""); },
              ThrowsMessage<Error>(
                  "SLUICE_INDEX_DIR: expected the absolute path of a folder, found 'rel'"));
  EXPECT_EQ(indexWish("/mine").folder, "/mine") << "the variable has no part in it";
  const ScopedVariable empty("SLUICE_INDEX_DIR", "");
  EXPECT_EQ(indexWish("").folder, "/caches/sluice/index");
  const ScopedVariable odd("SLUICE_INDEX", "foo");
  EXPECT_THAT([] { indexWish(""); },
              ThrowsMessage<Error>("SLUICE_INDEX: expected off or beside, found 'foo'"));
  const ScopedVariable unset("SLUICE_INDEX", "");
  EXPECT_FALSE(indexWish("").beside || indexWish("").disabled);
}

TEST(DecodeOptions, temporaryFilesGoWhereTheUserSays) {
  const ScopedVariable here("TMPDIR", "/scratch");
  EXPECT_EQ(decodeOptions().folder, "/scratch");
  const ScopedVariable unset("TMPDIR", nullptr);
  EXPECT_EQ(decodeOptions().folder, "");
}

// The window and the frames of a saved path open volumes as the library does.
TEST(WebOf, passesOnCertificatesAndCache) {
  WebOptions web;
  web.cache = {"/kept", 5};
  web.certificates = {"/ca.pem", "/certificates"};
  const VolumeOptions::Web options = webOf(web, {"https://host/v.zarr"});
  EXPECT_EQ(options.cache_folder, "/kept");
  EXPECT_EQ(options.cache_bytes, 5U);
  EXPECT_EQ(options.certificate_file, "/ca.pem");
  EXPECT_EQ(options.certificate_folder, "/certificates");
  // A limit without a folder would be no cache.
  web.cache.folder.clear();
  EXPECT_THROW(webOf(web, {"https://host/v.zarr"}), Error);
}

TEST(Driver, keepsTheUsersFlags) {
  const ScopedVariable given("GALLIVM_PERF", "nopt");
  prepareDriver();
  prepareDriver();
  EXPECT_EQ(std::string(getenv("GALLIVM_PERF")), std::string("nopt,") + kExactSampling);
}

}  // namespace
}  // namespace sluice
