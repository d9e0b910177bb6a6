// Trees as bytes: the way there and back, and bytes that are no tree.
#include "src/index/boxes_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "tests/classify/boxes/partition.h"
#include "tests/support/random_volume.h"
#include "tests/support/tree_visit.h"

namespace sluice {
namespace {

constexpr Vec3i kCells{39, 35, 32};

BoxTree someTree(uint64_t seed = 1) {
  const auto blobs = makeSparseBlobs({.dims = kCells + Vec3i{1, 1, 1}, .seed = seed, .blobs = 9});
  const DeviceVolume volume(*blobs);
  return growBoxTree(brickGrid(volume.span(), volume.cells(), kSide), {});
}

// The properties of a tree that its readers rely on.
void expectUsable(const BoxTree& tree) {
  int64_t cells = 0, stored = 0;
  for (size_t i = 0; i < tree.boxes.size(); ++i) {
    const Box3 box = tree.boxes[i].local();
    ASSERT_FALSE(box.empty());
    ASSERT_TRUE(boxOf(kCells).contains(box));
    ASSERT_TRUE(tree.textures.at(tree.texture_of.at(i)).local().contains(box));
    ASSERT_LE(tree.boxes[i].range.lo, tree.boxes[i].range.hi);
    cells += box.count();
  }
  for (const GrownBox& texture : tree.textures) stored += texture.local().count();
  ASSERT_EQ(cells, volume(kCells));
  ASSERT_EQ(stored, volume(kCells));
  for (const BoxEye& eye : {BoxEye{true, {1, -2, 3}}, BoxEye{false, {10, 50, -3}}}) {
    std::vector<int> visits(tree.boxes.size(), 0);
    visitFrontToBack(tree, eye, [&](size_t box) { ++visits.at(box); });
    for (const int count : visits) ASSERT_EQ(count, 1);
  }
}

TEST(BoxesFile, aTreeComesBackAsItWas) {
  for (const uint64_t seed : {1, 2, 3}) {
    const BoxTree tree = someTree(seed);
    ASSERT_GT(tree.boxes.size(), 20U);
    const auto found = deserializeBoxTree(serialize(tree), kCells);
    ASSERT_TRUE(found);
    EXPECT_EQ(*found, tree);
  }
}

TEST(BoxesFile, aTreeOfAnotherBlockIsRefused) {
  const auto bytes = serialize(someTree());
  EXPECT_FALSE(deserializeBoxTree(bytes, kCells + Vec3i{1, 0, 0}));
  EXPECT_FALSE(deserializeBoxTree(bytes, kCells - Vec3i{0, 0, 1}));
  EXPECT_FALSE(deserializeBoxTree({}, kCells));
}

TEST(BoxesFile, everyShorterFileIsRefused) {
  const auto bytes = serialize(someTree());
  for (size_t size = 0; size < bytes.size(); ++size)
    ASSERT_FALSE(deserializeBoxTree(std::span(bytes).first(size), kCells)) << size;
  auto longer = bytes;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(deserializeBoxTree(longer, kCells));
}

// Whatever is changed, a tree that is given back can be used.
TEST(BoxesFile, changedBytesAreRefusedOrHarmless) {
  const auto bytes = serialize(someTree());
  std::mt19937 random(17);
  int refused = 0;
  constexpr int kRounds = 20000;
  for (int round = 0; round < kRounds; ++round) {
    auto changed = bytes;
    for (int i = 0; i <= round % 3; ++i)
      changed[random() % changed.size()] = static_cast<std::byte>(random());
    const auto found = deserializeBoxTree(changed, kCells);
    refused += found ? 0 : 1;
    if (!found) continue;
    expectUsable(*found);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(refused, kRounds / 10);
}

TEST(BoxesFile, countsBeyondTheFileTakeNoMemory) {
  auto bytes = serialize(someTree());
  const uint32_t many = std::numeric_limits<uint32_t>::max();
  std::memcpy(bytes.data() + sizeof(uint32_t), &many, sizeof many);
  EXPECT_FALSE(deserializeBoxTree(bytes, kCells));
}

// A chain of planes deeper than a traversal has room for.
TEST(BoxesFile, aTreeThatIsTooDeepIsRefused) {
  const auto chain = [](uint16_t length) {
    BoxTree tree;
    GrownBox box;
    box.hi = {length, 1, 1};
    tree.textures = {box};
    tree.grown = 1;
    for (uint16_t i = 1; i < length; ++i) {
      TreeNode node;
      node.plane = i;
      tree.nodes.push_back(node);
      TreeNode leaf;
      leaf.box = i - 1;
      tree.nodes.push_back(leaf);
      tree.boxes.push_back(box);
      tree.texture_of.push_back(0);
    }
    TreeNode last;
    last.box = length - 1;
    tree.nodes.push_back(last);
    tree.boxes.push_back(box);
    tree.texture_of.push_back(0);
    return serialize(tree);
  };
  const auto deepest = static_cast<uint16_t>(kMostTreeDepth + 1);
  const auto found = deserializeBoxTree(chain(deepest), {deepest, 1, 1});
  ASSERT_TRUE(found);
  size_t visited = 0;
  visitFrontToBack(*found, {true, {-1, 0, 0}}, [&](size_t) { ++visited; });
  EXPECT_EQ(visited, deepest);
  EXPECT_FALSE(deserializeBoxTree(chain(deepest + 1), {deepest + 1, 1, 1}));
}

BoxesOrigin someOrigin() {
  return {blockLayout({100, 90, 80}, 32, 0), {DeviceType::kU8, 1, 0}, {}, kSide};
}

TEST(BoxesFile, piecesAreThoseOfTheirBlocksAndParametersOnly) {
  BoxesPiece piece;
  piece.first = 4;
  for (const uint64_t seed : {1, 2}) {
    const auto tree = serialize(someTree(seed));
    piece.bytes.insert(piece.bytes.end(), tree.begin(), tree.end());
    piece.ends.push_back(piece.bytes.size());
    piece.ends.push_back(piece.bytes.size());  // a block without a tree
  }
  const BoxesOrigin origin = someOrigin();
  const auto bytes = serialize(piece, origin);
  const auto found = deserializeBoxesPiece(bytes, origin, 4, 4);
  ASSERT_TRUE(found);
  EXPECT_EQ(*deserializeBoxTree(found->treeBytes(4), kCells), someTree(1));
  EXPECT_TRUE(found->treeBytes(5).empty());
  EXPECT_EQ(*deserializeBoxTree(found->treeBytes(6), kCells), someTree(2));
  EXPECT_FALSE(deserializeBoxesPiece(bytes, origin, 3, 4));
  EXPECT_FALSE(deserializeBoxesPiece(bytes, origin, 4, 3));
  BoxesOrigin other = origin;
  other.parameters.uniform_range = 16;
  EXPECT_FALSE(deserializeBoxesPiece(bytes, other, 4, 4));
  other = origin;
  other.layout = blockLayout({100, 90, 80}, 64, 0);
  EXPECT_FALSE(deserializeBoxesPiece(bytes, other, 4, 4));
  for (size_t size = 0; size < bytes.size(); size += 7)
    ASSERT_FALSE(deserializeBoxesPiece(std::span(bytes).first(size), origin, 4, 4)) << size;
}

TEST(BoxesFile, endsThatRunBackwardsAreRefused) {
  BoxesPiece piece;
  piece.bytes.resize(20);
  piece.ends = {15, 10, 20};
  EXPECT_FALSE(deserializeBoxesPiece(serialize(piece, someOrigin()), someOrigin(), 0, 3));
  piece.ends = {10, 15, 21};
  EXPECT_FALSE(deserializeBoxesPiece(serialize(piece, someOrigin()), someOrigin(), 0, 3));
  piece.ends = {10, 15, 20};
  EXPECT_TRUE(deserializeBoxesPiece(serialize(piece, someOrigin()), someOrigin(), 0, 3));
}

}  // namespace
}  // namespace sluice
