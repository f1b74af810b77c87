// The layout of inner nodes, with differences of 8 bits to overflow them many times and sums beyond 2^32.
#include "Octree/ChildTable.h"
#include "Octree/Octree.h"

#include <gtest/gtest.h>

#include <bitset>
#include <random>

using namespace treeamr;

namespace
{

static_assert(sizeof(NodeRef) == 8);
static_assert(
  NodeRef(NodeKind::Leaf, 61, (std::uint64_t(1) << 56) - 1).index() == (std::uint64_t(1) << 56) - 1);
static_assert(NodeRef(NodeKind::Leaf, 61, (std::uint64_t(1) << 56) - 1).depth() == 61);

template <class Table>
void expectRunningSums(double refine, std::uint64_t firstInner, std::uint64_t firstLeaf)
{
  constexpr std::uint64_t count = 10000;
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(0., 1.);
  std::vector<ChildMasks> masks(count);
  for (ChildMasks& m : masks)
  {
    m.exists = static_cast<std::uint8_t>(random() % 4 == 0 ? random() : 255);
    for (int o = 0; o < 8; ++o)
    {
      m.leaf |= static_cast<std::uint8_t>((m.exists & 1 << o) != 0 && unit(random) >= refine ? 1 << o : 0);
    }
  }
  Table table;
  table.allocate(count);
  std::uint64_t inner = firstInner;
  std::uint64_t leaf = firstLeaf;
  for (std::uint64_t n = 0; n < count; ++n)
  {
    table.start(n, inner, leaf);
    for (int o = 0; o < 8; ++o)
    {
      if (masks[n].exists >> o & 1)
      {
        table.addChild(n, o, masks[n].isLeaf(o));
        (masks[n].isLeaf(o) ? leaf : inner) += 1;
      }
    }
  }
  for (std::uint64_t block = 0; block < table.blockCount(); ++block)
  {
    table.finishBlock(block);
  }
  inner = firstInner;
  leaf = firstLeaf;
  for (std::uint64_t n = 0; n < count; ++n)
  {
    const Children children = table.children(n);
    ASSERT_EQ(children.firstInner, inner);
    ASSERT_EQ(children.firstLeaf, leaf);
    for (int o = 0; o < 8; ++o)
    {
      NodeRef expected{};
      if (masks[n].isLeaf(o))
      {
        ASSERT_EQ(children.leafIndex(o), leaf);
        expected = { NodeKind::Leaf, 7, leaf++ };
      }
      else if (masks[n].isInner(o))
      {
        ASSERT_EQ(children.innerIndex(o), inner);
        expected = { NodeKind::Inner, 7, inner++ };
      }
      ASSERT_EQ(children.node(o, 7), expected);
    }
    ASSERT_EQ(children.firstInner + children.innerCount(), inner);
    ASSERT_EQ(children.firstLeaf + children.leafCount(), leaf);
  }
}

} // namespace

TEST(ChildTable, BlocksCarryNarrowDifferencesAnyFar)
{
  constexpr std::uint64_t far = (std::uint64_t(1) << 40) + 12345;
  for (const double refine : { 0., 0.125, 0.5, 1. })
  {
    // Up to 31 nodes of 8 children are 248 apart.
    expectRunningSums<ChildTable<std::uint8_t, 5>>(refine, 1, 0);
    expectRunningSums<ChildTable<std::uint8_t, 5>>(refine, far, far / 3);
    expectRunningSums<ChildTable<std::uint8_t, 0>>(refine, far, far / 3);
    expectRunningSums<Octree::Table>(refine, far, far / 3);
  }
}

TEST(ChildTable, CountsTheBitsOfAnyMask)
{
  for (unsigned mask = 0; mask < 256; ++mask)
  {
    EXPECT_EQ(bitCount(mask), std::bitset<8>(mask).count());
  }
}

TEST(ChildTable, CostsSixBytesAndABaseForEachBlock)
{
  Octree::Table table;
  table.allocate(4097);
  EXPECT_EQ(table.byteSize(), 4097u * 6 + 2 * 16);
}
