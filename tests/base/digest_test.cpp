// Digests tell bytes apart: contents, order, length and how they are cut.
#include "src/base/values/digest.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace sluice {
namespace {

uint64_t digestOf(std::initializer_list<std::string_view> texts) {
  Digest digest;
  for (const std::string_view text : texts) digest.add(text);
  return digest.value();
}

TEST(Digest, dependsOnEachBitAndOnTheLength) {
  std::set<uint64_t> seen;
  size_t count = 0;
  for (size_t length = 0; length < 20; ++length) {
    const std::string zeros(length, '\0');
    seen.insert(digestOf({zeros}));
    ++count;
    for (size_t bit = 0; bit < 8 * length; ++bit) {
      std::string one = zeros;
      one[bit / 8] = static_cast<char>(1 << (bit % 8));
      seen.insert(digestOf({one}));
      ++count;
    }
  }
  EXPECT_EQ(seen.size(), count);
}

TEST(Digest, dependsOnOrderAndOnCuts) {
  EXPECT_EQ(digestOf({"sluice", "gate"}), digestOf({"sluice", "gate"}));
  EXPECT_NE(digestOf({"sluice", "gate"}), digestOf({"gate", "sluice"}));
  EXPECT_NE(digestOf({"sluice", "gate"}), digestOf({"sluic", "egate"}));
  EXPECT_NE(digestOf({"sluice"}), digestOf({"sluice", ""}));
}

}  // namespace
}  // namespace sluice
