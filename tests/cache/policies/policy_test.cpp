#include "cache/policies/policy.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "cache/policies/random.h"
#include "cache/simulate/belady.h"
#include "src/base/error.h"
#include "tests/cache/policies/naive_policies.h"

namespace sluice {
namespace {

std::vector<Key> keysOf(const std::string& letters) {
  std::vector<Key> keys;
  for (const char c : letters) keys.push_back(static_cast<Key>(c - 'A'));
  return keys;
}

// Replays letters with a page each: a hit prints in lower case, a load in upper case with the
// evicted letter after a slash.
std::string replay(Policy& policy, const std::string& letters) {
  std::string out;
  for (const Key key : keysOf(letters)) {
    std::vector<Key> evicted;
    const Outcome outcome = policy.request(key, 1, evicted);
    if (!out.empty()) out += ' ';
    out += static_cast<char>((outcome == Outcome::kHit ? 'a' : 'A') + static_cast<int>(key));
    if (!evicted.empty()) out += '/';
    for (const Key gone : evicted) out += static_cast<char>('a' + static_cast<int>(gone));
  }
  return out;
}
std::string replay(PolicyKind kind, uint64_t capacity, const std::string& letters) {
  return replay(*makePolicy(kind, capacity), letters);
}

TEST(Policy, lruEvictsTheLeastRecentlyUsed) {
  // A's hit leaves B the oldest; D takes its place; then C is the oldest.
  EXPECT_EQ(replay(PolicyKind::kLru, 3, "ABCADBA"), "A B C a D/b B/c a");
}

TEST(Policy, fifoEvictsTheFirstLoadedWhateverIsHit) {
  EXPECT_EQ(replay(PolicyKind::kFifo, 3, "ABCADBA"), "A B C a D/a b A/b");
}

TEST(Policy, clockGivesASecondChance) {
  // D: the hand clears A and passes, takes B. Then C (clear). Then A, cleared before.
  EXPECT_EQ(replay(PolicyKind::kClock, 3, "ABCADBE"), "A B C a D/b B/c E/a");
}

TEST(Policy, srripEvictsWhatIsPredictedFurthest) {
  // Loads at 2, A's hit makes it 0. D: all rise, A1 B3 C3, B is longest at 3. E: C. A's hit: 0.
  // F: D and E are at 2, rise to 3, A to 1: D.
  EXPECT_EQ(replay(PolicyKind::kSrrip, 3, "ABCADEAF"), "A B C a D/b E/c a F/d");
}

TEST(Policy, sieveKeepsItsHandWhereItEvicted) {
  // Queue C B A, A visited. D: the hand clears A, takes B, stays at C. B: C. E: D, although A is
  // older and unvisited now, since the hand has passed it.
  EXPECT_EQ(replay(PolicyKind::kSieve, 3, "ABCADBEA"), "A B C a D/b B/c E/d a");
}

TEST(Policy, twoQPromotesWhatComesBackFromOut) {
  // Four pages: In keeps 1, Out remembers 2. E: Main is empty, In gives A. A is in Out: loaded into
  // Main, In (3 left of B C D E) gives B. F: In gives C; Out is C B. A hits in Main, D in In
  // without moving: G evicts it; Out is D C. B is forgotten: into In, which gives E.
  EXPECT_EQ(replay(PolicyKind::kTwoQ, 4, "ABCDEAFADGB"), "A B C D E/a A/b F/c a d G/d B/e");
}

TEST(Policy, arcMovesItsTargetOnGhostHits) {
  // Two pages. A twice: T2 = A, T1 = B. C: T1 (1) > target 0, B goes to B1. B: target 1; T1 = C is
  // not above it, T2 gives A to B2; T2 = B. D: T1 = 1 is not above 1, T2 gives B. A: in B2, target
  // 0; T1 = D C gives C.
  EXPECT_EQ(replay(PolicyKind::kArc, 2, "ABACBDA"), "A B a C/b B/a D/b A/c");
}

TEST(Policy, s3FifoMovesWhatIsHitTwiceToMain) {
  // Three pages: Small's share is 1. D: A (two hits) moves to Main, B goes. B: a ghost, into Main;
  // Small = D C gives C. E: Small = D holds its share, gives D. A is still there.
  EXPECT_EQ(replay(PolicyKind::kS3Fifo, 3, "ABCAADBEA"), "A B C a a D/b B/c E/d a");
}

TEST(Policy, lfuEvictsTheLeastOftenRequested) {
  // A twice, B and C once: B is older and goes for D. C is older than D and goes for B. B has begun
  // anew, so B and D have one request each: D is older.
  EXPECT_EQ(replay(PolicyKind::kLfu, 3, "ABCADBEA"), "A B C a D/b B/c E/d a");
}

TEST(Policy, slruProtectsWhatWasHitOnceAmongNewEntries) {
  // Five pages, four protected. A is hit and protected: the scan of F to I takes B, C, D, E.
  EXPECT_EQ(replay(PolicyKind::kSlru, 5, "ABCDEAFGHIA"), "A B C D E a F/b G/c H/d I/e a");
  // Two pages, one protected: B's hit sends A back to the head of Probation, from which C takes it.
  EXPECT_EQ(replay(PolicyKind::kSlru, 2, "ABABC"), "A B a b C/a");
}

TEST(Policy, wTinyLfuKeepsWhatIsRequestedOftenerThanWhatComes) {
  // Three pages: a window of one, of the main two pages one protected. A, B and C fill it; A's hit
  // protects A. D: the window's C (1) is not requested oftener than B (1), so C goes. E: D goes. C:
  // its second request; E goes. F: C (2) against B (1): B goes, C enters the main part.
  EXPECT_EQ(replay(PolicyKind::kWTinyLfu, 3, "ABCADECFC"), "A B C a D/c E/d C/e F/b c");
}

TEST(Policy, lirsKeepsWhatIsRequestedTwiceCloseTogether) {
  // Three pages, two of them LIR: A and B. C, D and E pass through the queue's one page and stay in
  // the stack as ghosts. D comes back: it becomes LIR, and A, the lowest, is queued. E comes back:
  // A goes, E becomes LIR and B, now the lowest, is queued. F takes B.
  EXPECT_EQ(replay(PolicyKind::kLirs, 3, "ABCDEDEF"), "A B C D/c E/d D/e E/a F/b");
}

TEST(Policy, gdsfPrefersSmallEntriesAndForgetsOldRequests) {
  // Four pages. A (three pages): 1/3; B: 1, hit: 2. C: A goes, L = 1/3, C = 4/3. D: 4/3. E: 4/3.
  // F: C is the oldest of 4/3, L = 4/3, F = 7/3. G: D. H: E, L = 4/3. I: B's 2 is the lowest.
  const auto policy = makePolicy(PolicyKind::kGdsf, 4);
  std::vector<Key> evicted;
  policy->request(0, 3, evicted);
  EXPECT_EQ(replay(*policy, "BBCDEFGHI"), "B b C/a D E F/c G/d H/e I/b");
}

TEST(Policy, randomOfOnePageHasNoChoice) {
  EXPECT_EQ(replay(PolicyKind::kRandom, 1, "AABBA"), "A a B/a b A/b");
}

TEST(Policy, randomFollowsItsSeed) {
  const std::string trace = "ABCDEFGHABCDEFGH";
  EXPECT_EQ(replay(*makePolicy(PolicyKind::kRandom, 4, 7), trace),
            replay(*makePolicy(PolicyKind::kRandom, 4, 7), trace));
  EXPECT_NE(replay(*makePolicy(PolicyKind::kRandom, 4, 7), trace),
            replay(*makePolicy(PolicyKind::kRandom, 4, 8), trace));
}

TEST(Policy, beladyEvictsWhatIsNeededLast) {
  // D: next uses A 4, B 5, C 9: C. E: A 7, B 8, D 10: D. C: A and B never again, the larger key B.
  // D: A and C never: C. Seven misses, as in the textbooks.
  const std::string letters = "ABCDABEABCDE";
  const std::vector<uint32_t> next = nextUses(prepareUnit(keysOf(letters)));
  BeladyPolicy belady(3, next);
  EXPECT_EQ(replay(belady, letters), "A B C D/c a b E/d a b C/b D/c e");
}

TEST(Policy, namesAreUnderstood) {
  for (const PolicyKind kind : onlinePolicies()) EXPECT_EQ(parsePolicy(name(kind)), kind);
  EXPECT_EQ(parsePolicy("belady-pages"), PolicyKind::kBeladyPages);
  EXPECT_EQ(parsePolicy("mru"), std::nullopt);
}

class EveryPolicy : public testing::TestWithParam<PolicyKind> {
 protected:
  static std::unique_ptr<Policy> make(uint64_t capacity, std::span<const uint32_t> next_uses = {}) {
    if (GetParam() == PolicyKind::kBelady)
      return std::make_unique<BeladyPolicy>(capacity, next_uses);
    return makePolicy(GetParam(), capacity, 5);
  }
};

// Requests, pins and erasures drawn with a seed; both must answer the same each time.
void compareWithNaive(PolicyKind kind, uint64_t capacity, uint32_t distinct, uint32_t heaviest,
                      bool with_pins, uint64_t seed) {
  Random random(seed);
  std::vector<Key> keys(3000);
  // Half of the requests go to a tenth of the keys.
  for (Key& key : keys)
    key = random.below(2) == 0 ? random.below(1 + distinct / 10) : random.below(distinct);
  std::vector<uint32_t> weights(distinct);
  for (uint32_t& w : weights) w = 1 + random.below(heaviest);
  const std::vector<uint32_t> next = nextUses(prepareUnit(keys));
  std::unique_ptr<Policy> real = kind == PolicyKind::kBelady
                                     ? std::make_unique<BeladyPolicy>(capacity, next)
                                     : makePolicy(kind, capacity, seed);
  const auto naive = test::makeNaivePolicy(kind, capacity, seed, next);
  for (size_t i = 0; i < keys.size(); ++i) {
    const std::string where = fmt::format("{} capacity {} heaviest {} pins {} seed {} request {}",
                                          name(kind), capacity, heaviest, with_pins, seed, i);
    std::vector<Key> evicted, naive_evicted;
    const Outcome outcome = real->request(keys[i], weights[keys[i]], evicted);
    ASSERT_EQ(outcome, naive->request(keys[i], weights[keys[i]], naive_evicted)) << where;
    ASSERT_EQ(evicted, naive_evicted) << where;
    ASSERT_LE(real->used(), capacity);
    if (!with_pins) continue;
    if (random.below(4) == 0) {
      real->pin(keys[i]);
      naive->pin(keys[i]);
    }
    if (random.below(12) == 0) {
      real->unpinAll();
      naive->unpinAll();
    }
    if (random.below(15) == 0) {
      const Key key = random.below(distinct);
      ASSERT_EQ(real->erase(key), naive->erase(key)) << where;
    }
  }
}

TEST_P(EveryPolicy, answersAsTheNaiveOneForSinglePages) {
  for (const uint64_t capacity : {1, 2, 3, 7, 20, 64})
    compareWithNaive(GetParam(), capacity, 60, 1, false, capacity);
}

TEST_P(EveryPolicy, answersAsTheNaiveOneForChunksOfSeveralPages) {
  for (const uint64_t capacity : {3, 8, 21, 64, 200})
    compareWithNaive(GetParam(), capacity, 60, 9, false, capacity);
}

TEST_P(EveryPolicy, answersAsTheNaiveOneWithPinsAndErasures) {
  for (const uint64_t capacity : {4, 16, 50}) {
    compareWithNaive(GetParam(), capacity, 60, 1, true, capacity);
    compareWithNaive(GetParam(), capacity, 60, 5, true, capacity + 1);
  }
}

TEST_P(EveryPolicy, refusesWhatIsLargerThanTheCacheAndKeepsTheRest) {
  const std::vector<uint32_t> next(4, kNever);
  const auto policy = make(4, next);
  std::vector<Key> evicted;
  EXPECT_EQ(policy->request(0, 3, evicted), Outcome::kLoaded);
  EXPECT_EQ(policy->request(1, 5, evicted), Outcome::kDoesNotFit);
  EXPECT_TRUE(evicted.empty());
  EXPECT_TRUE(policy->contains(0));
  EXPECT_EQ(policy->request(2, 4, evicted), Outcome::kLoaded);
  EXPECT_EQ(evicted, std::vector<Key>{0});
}

TEST_P(EveryPolicy, neverEvictsPinnedEntries) {
  const std::vector<uint32_t> next(40, kNever);
  const auto policy = make(4, next);
  std::vector<Key> evicted;
  policy->request(0, 1, evicted);
  policy->request(1, 2, evicted);
  policy->pin(0);
  policy->pin(1);
  for (Key key = 2; key < 20; ++key) EXPECT_EQ(policy->request(key, 1, evicted), Outcome::kLoaded);
  EXPECT_EQ(policy->request(20, 2, evicted), Outcome::kDoesNotFit);
  EXPECT_TRUE(policy->contains(0) && policy->contains(1));
  policy->unpinAll();
  EXPECT_EQ(policy->request(21, 4, evicted), Outcome::kLoaded);
  EXPECT_EQ(policy->residents(), 1u);
}

std::vector<PolicyKind> allKinds() {
  std::vector<PolicyKind> kinds(onlinePolicies().begin(), onlinePolicies().end());
  kinds.push_back(PolicyKind::kBelady);
  return kinds;
}

INSTANTIATE_TEST_SUITE_P(Policies, EveryPolicy, testing::ValuesIn(allKinds()),
                         [](const auto& param_info) {
                           std::string text(name(param_info.param));
                           std::erase(text, '-');
                           return text;
                         });

}  // namespace
}  // namespace sluice
