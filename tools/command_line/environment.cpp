#include "tools/command_line/environment.h"

#include <cstdlib>
#include <string>

#include "io/web/bucket_access.h"
#include "src/base/error.h"
#include "src/gl/contexts/gl_choice.h"
#include "tools/command_line/progress_line.h"

namespace sluice {
namespace {

// The value of a variable that names a folder by its absolute path; empty otherwise.
std::filesystem::path folderFrom(const char* variable) {
  const char* value = std::getenv(variable);
  // XDG Base Directory Specification: a path that is not absolute is ignored.
  return value != nullptr && value[0] == '/' ? value : "";
}

// A folder in the user's cache; empty: there is none.
std::filesystem::path cacheFolder(const char* name) {
  if (const auto cache = folderFrom("XDG_CACHE_HOME"); !cache.empty())
    return cache / "sluice" / name;
  if (const auto home = folderFrom("HOME"); !home.empty()) return home / ".cache" / "sluice" / name;
  return {};
}

std::string textFrom(const char* variable) {
  const char* value = std::getenv(variable);
  return value == nullptr ? "" : value;
}

// A variable of sluice's own that is wrong is refused, as an option would be. Variables that other
// programs share (XDG_CACHE_HOME) are ignored, as their specification asks for.
std::filesystem::path indexFolder(const std::string& index_dir) {
  if (!index_dir.empty()) return index_dir;
  const std::string said = textFrom("SLUICE_INDEX_DIR");
  if (said.empty()) return cacheFolder("index");
  if (said.front() != '/')
    fail("SLUICE_INDEX_DIR: expected the absolute path of a folder, found '{}'", said);
  return said;
}

}  // namespace

IndexWish indexWish(const std::string& index_dir) {
  const std::string wish = textFrom("SLUICE_INDEX");
  if (!wish.empty() && wish != "beside" && wish != "off")
    fail("SLUICE_INDEX: expected off or beside, found '{}'", wish);
  return {indexFolder(index_dir), wish == "beside" && index_dir.empty(), wish == "off"};
}

std::filesystem::path windowSettings() {
  if (const auto config = folderFrom("XDG_CONFIG_HOME"); !config.empty())
    return config / "sluice" / "view.json";
  if (const auto home = folderFrom("HOME"); !home.empty())
    return home / ".config" / "sluice" / "view.json";
  return {};
}

DecodeOptions decodeOptions() {
  DecodeOptions options;
  if (const char* const chosen = std::getenv("TMPDIR")) options.folder = chosen;
  options.watch = [](const std::string& file) { return progressLine("decoding " + file); };
  return options;
}

std::filesystem::path webCacheFolder() {
  return cacheFolder("web");
}

BucketAccess bucketAccess() {
  return bucketAccess(textFrom);
}

WebCertificates webCertificates() {
  // curl itself takes its own bundle before OpenSSL's variables, too.
  if (std::string bundle = textFrom("CURL_CA_BUNDLE"); !bundle.empty()) return {bundle, ""};
  return {textFrom("SSL_CERT_FILE"), textFrom("SSL_CERT_DIR")};
}

Launch launchOfProcess() {
  return launchOf([](const char* variable) { return std::getenv(variable); });
}

void prepareDriver() {
  const char* const given = std::getenv("GALLIVM_PERF");
  if (given == nullptr) return;  // the library sets it
  // The user's flags stay; only the one that pictures need is added.
  std::string flags = given;
  if (flags.find(kExactSampling) != std::string::npos) return;
  if (!flags.empty()) flags += ',';
  setenv("GALLIVM_PERF", (flags + kExactSampling).c_str(), 1);
}

}  // namespace sluice
