#include "tests/support/vdb_writer.h"

#include <random>

#include "io/vdb/vdb_library_grids.h"

// OpenVDB's library may lack the functions that set voxels and tiles, since no reader calls them.
#define SLUICE_SETTERS(Tree, Node)                                       \
  template void Node::setValueOn(const Coord&, const Tree::ValueType&);  \
  template void Node::setValueOff(const Coord&, const Tree::ValueType&); \
  template void Node::addTile(Index, const Coord&, const Tree::ValueType&, bool);
#define SLUICE_TREE_SETTERS(Tree)                         \
  SLUICE_SETTERS(Tree, Tree::RootNodeType)                \
  SLUICE_SETTERS(Tree, Tree::RootNodeType::ChildNodeType) \
  SLUICE_SETTERS(Tree, Tree::RootNodeType::ChildNodeType::ChildNodeType)
namespace openvdb {
namespace OPENVDB_VERSION_NAME {
SLUICE_TREE_SETTERS(FloatTree)
SLUICE_TREE_SETTERS(DoubleTree)
SLUICE_TREE_SETTERS(Int32Tree)
SLUICE_TREE_SETTERS(Int64Tree)
SLUICE_TREE_SETTERS(BoolTree)
SLUICE_TREE_SETTERS(MaskTree)
SLUICE_TREE_SETTERS(Vec3STree)
}  // namespace OPENVDB_VERSION_NAME
}  // namespace openvdb
#undef SLUICE_TREE_SETTERS
#undef SLUICE_SETTERS

namespace sluice {
namespace {

void write(const std::filesystem::path& path, const openvdb::GridPtrVec& grids,
           uint32_t compression = openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK) {
  openvdb::io::File file(path.string());
  file.setCompression(compression);
  file.write(grids);
  file.close();
}

template <class Grid>
WrittenGrid writeMixed(const std::filesystem::path& path, typename Grid::ValueType background,
                       bool as_half, uint32_t compression) {
  using Value = typename Grid::ValueType;
  const auto grid = Grid::create(background);
  auto& tree = grid->tree();
  std::mt19937 random(3);
  const auto value = [&] {
    if constexpr (std::is_same_v<Value, bool>) {
      return true;
    } else {
      return static_cast<Value>(int(random() % 2000) - 1000);
    }
  };
  // Across the origin, so that coordinates of both signs occur.
  for (int i = 0; i < 3000; ++i)
    tree.setValue({int(random() % 60) - 20, int(random() % 60) - 30, int(random() % 40) - 5},
                  value());
  for (int i = 0; i < 200; ++i)
    tree.setValueOff({int(random() % 60) - 20, int(random() % 60) - 30, int(random() % 40) - 5},
                     value());
  tree.addTile(1, {48, 8, 8}, value(), true);
  tree.addTile(1, {48, 16, 8}, value(), false);
  tree.addTile(1, {48, 24, 8}, background, true);  // active, but as its surroundings
  tree.addTile(2, {-130, -100, -100}, value(), true);
  grid->setSaveFloatAsHalf(as_half);
  grid->setName("mixed");
  write(path, {grid}, compression);

  const auto active = grid->evalActiveVoxelBoundingBox();
  WrittenGrid result;
  const auto lo = active.min(), hi = active.max();
  result.active = {{lo.x(), lo.y(), lo.z()}, {hi.x() + 1, hi.y() + 1, hi.z() + 1}};
  result.box = {result.active.lo - Vec3i{1, 1, 1}, result.active.hi + Vec3i{1, 1, 1}};
  for (int z = lo.z() - 1; z <= hi.z() + 1; ++z)
    for (int y = lo.y() - 1; y <= hi.y() + 1; ++y)
      for (int x = lo.x() - 1; x <= hi.x() + 1; ++x)
        result.values.push_back(static_cast<double>(tree.getValue({x, y, z})));
  result.leaves = static_cast<int64_t>(tree.leafCount());
  result.tiles = 3;
  return result;
}

}  // namespace

WrittenGrid writeMixedGrid(const std::filesystem::path& path, const std::string& type,
                           uint32_t compression) {
  openvdb::initialize();
  if (type == "float") return writeMixed<openvdb::FloatGrid>(path, 0.5F, false, compression);
  if (type == "half") return writeMixed<openvdb::FloatGrid>(path, 0.5F, true, compression);
  if (type == "double") return writeMixed<openvdb::DoubleGrid>(path, -0.1, false, compression);
  if (type == "int32") return writeMixed<openvdb::Int32Grid>(path, -7, false, compression);
  if (type == "int64")
    return writeMixed<openvdb::Int64Grid>(path, int64_t{1} << 40, false, compression);
  if (type == "bool") return writeMixed<openvdb::BoolGrid>(path, false, false, compression);
  return writeMixed<openvdb::MaskGrid>(path, false, false, compression);
}

void writePoints(const std::filesystem::path& path,
                 const std::map<std::array<int, 3>, float>& points) {
  openvdb::initialize();
  const auto grid = openvdb::FloatGrid::create(0);
  for (const auto& [at, value] : points) grid->tree().setValue({at[0], at[1], at[2]}, value);
  grid->setName("f");
  write(path, {grid});
}

void writeTransformed(const std::filesystem::path& path, const double (&rows)[4][3]) {
  openvdb::initialize();
  const auto grid = openvdb::FloatGrid::create(0);
  grid->tree().setValue({3, 4, 5}, 1);
  grid->setName("f");
  auto matrix = openvdb::Mat4d::identity();
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 3; ++c) matrix(r, c) = rows[r][c];
  grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
  write(path, {grid});
}

void writeFrustum(const std::filesystem::path& path) {
  openvdb::initialize();
  const auto grid = openvdb::FloatGrid::create(0);
  grid->tree().setValue({3, 4, 5}, 1);
  grid->setName("f");
  grid->setTransform(openvdb::math::Transform::createFrustumTransform(
      openvdb::BBoxd({0, 0, 0}, {10, 10, 10}), 0.5, 10, 0.1));
  write(path, {grid});
}

void writeSeveral(const std::filesystem::path& path) {
  openvdb::initialize();
  const auto velocity = openvdb::Vec3SGrid::create();
  velocity->tree().setValue({0, 0, 0}, {1, 2, 3});
  velocity->setName("velocity");
  const auto id = openvdb::Int32Grid::create(0);
  id->tree().setValue({0, 0, 0}, 7);
  id->setName("id");
  const auto density = openvdb::FloatGrid::create(0);
  density->tree().setValue({0, 0, 0}, 2);
  density->setName("density");
  density->setGridClass(openvdb::GRID_FOG_VOLUME);
  const auto finer = openvdb::DoubleGrid::create(0);
  finer->tree().setValue({0, 0, 0}, 3);
  finer->setName("density");
  const auto nothing = openvdb::FloatGrid::create(0);
  nothing->setName("nothing");
  write(path, {velocity, id, density, finer, nothing});
}

}  // namespace sluice
