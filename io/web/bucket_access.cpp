#include "io/web/bucket_access.h"

#include <filesystem>
#include <map>
#include <optional>
#include <sstream>

#include "src/base/error.h"
#include "src/base/files/text_file.h"
#include "src/base/values/text_parts.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

using Section = std::map<std::string, std::string>;

// One section of a file of "[name]" and "key = value" lines; nullopt if it has none of that name,
// or if there is no such file.
std::optional<Section> sectionOf(const fs::path& path, const std::string& name) {
  constexpr uint64_t kMostBytes = 1 << 20;
  std::error_code unknown;
  if (path.empty() || !fs::is_regular_file(path, unknown)) return std::nullopt;
  std::istringstream lines(readTextFile(path, kMostBytes, "a file of profiles"));
  std::optional<Section> section;
  bool is_inside = false;
  for (std::string read; std::getline(lines, read);) {
    const std::string_view line = trimmed(read);
    if (line.empty() || line.front() == '#' || line.front() == ';') continue;
    if (line.front() == '[' && line.back() == ']') {
      is_inside = trimmed(line.substr(1, line.size() - 2)) == name;
      if (is_inside) section.emplace();
    } else if (const size_t equals = line.find('='); is_inside && equals != line.npos) {
      section->insert_or_assign(std::string(trimmed(line.substr(0, equals))),
                                trimmed(line.substr(equals + 1)));
    }
  }
  return section;
}

// The file that a variable names, or else the usual one in the user's folder.
fs::path profileFile(const std::string& named, const std::string& home, const char* usual) {
  if (!named.empty()) return named;
  return home.empty() ? fs::path() : fs::path(home) / ".aws" / usual;
}

void take(const Section& section, const char* key, std::string& held) {
  if (const auto found = section.find(key); found != section.end() && !found->second.empty())
    held = found->second;
}

}  // namespace

BucketAccess bucketAccess(const Variable& variable) {
  BucketAccess access;
  const std::string asked = variable("AWS_PROFILE");
  const std::string profile = asked.empty() ? "default" : asked;
  const std::string home = variable("HOME");
  const fs::path credentials =
      profileFile(variable("AWS_SHARED_CREDENTIALS_FILE"), home, "credentials");
  const fs::path config = profileFile(variable("AWS_CONFIG_FILE"), home, "config");
  const auto keys = sectionOf(credentials, profile);
  // The configuration calls its sections "profile NAME", but for the default one; the credentials
  // do not.
  const auto settings = sectionOf(config, profile == "default" ? profile : "profile " + profile);
  if (!asked.empty() && !keys && !settings)
    failRequest("AWS_PROFILE: no profile {} in {} or {}; correct the name or unset it", asked,
                credentials.string(), config.string());
  // Later ones replace earlier ones: the configuration, the credentials, the environment.
  for (const auto& section : {settings, keys}) {
    if (!section) continue;
    take(*section, "aws_access_key_id", access.access_key);
    take(*section, "aws_secret_access_key", access.secret_key);
    take(*section, "aws_session_token", access.session_token);
    take(*section, "region", access.region);
    take(*section, "endpoint_url", access.endpoint);
  }
  const std::string key = variable("AWS_ACCESS_KEY_ID");
  const std::string secret = variable("AWS_SECRET_ACCESS_KEY");
  if (!key.empty() && !secret.empty()) {
    access.access_key = key;
    access.secret_key = secret;
    // The three belong together: a token of other keys would be refused.
    access.session_token = variable("AWS_SESSION_TOKEN");
  }
  for (const std::string& region : {variable("AWS_DEFAULT_REGION"), variable("AWS_REGION")})
    if (!region.empty()) access.region = region;
  if (std::string url = variable("AWS_ENDPOINT_URL"); !url.empty()) access.endpoint = url;
  // A key without its secret cannot sign, so that the bucket is asked without one.
  if (access.secret_key.empty()) access.access_key.clear();
  return access;
}

}  // namespace sluice
