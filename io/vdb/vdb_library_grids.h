// The grids whose functions OpenVDB's library has, since it registers them. They are not compiled
// again, which would take four fifths of the compiler's time. The library lacks what no reader
// calls, such as setting voxels. Known to the module alone.
#pragma once

#include <openvdb/openvdb.h>

#define SLUICE_IN_LIBRARY(name)                                                                 \
  namespace openvdb {                                                                           \
  namespace OPENVDB_VERSION_NAME {                                                              \
  extern template class tree::LeafNode<name##Tree::ValueType, 3>;                               \
  extern template class tree::InternalNode<name##Tree::LeafNodeType, 4>;                        \
  extern template class tree::InternalNode<tree::InternalNode<name##Tree::LeafNodeType, 4>, 5>; \
  extern template class tree::RootNode<name##Tree::RootNodeType::ChildNodeType>;                \
  extern template class tree::Tree<name##Tree::RootNodeType>;                                   \
  extern template class Grid<name##Tree>;                                                       \
  }                                                                                             \
  }
SLUICE_IN_LIBRARY(Float)
SLUICE_IN_LIBRARY(Double)
SLUICE_IN_LIBRARY(Int32)
SLUICE_IN_LIBRARY(Int64)
SLUICE_IN_LIBRARY(Bool)
SLUICE_IN_LIBRARY(Mask)
SLUICE_IN_LIBRARY(Vec3S)
#undef SLUICE_IN_LIBRARY
