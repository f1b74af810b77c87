// What the tests of the forests' reader share: forests with payloads that can be told, and the grids that are read of them,
// cell by cell.
#pragma once

#include "vtkTreeAMRP4estReader.h"

#include "Support/ExampleForests.h"
#include "Support/ForestBytes.h"
#include "Support/HyperTreeGrids.h"

#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkErrorCode.h"
#include "vtkExecutive.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"
#include "vtkHyperTreeGridNonOrientedGeometryCursor.h"
#include "vtkNew.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace treeamr::test
{

/// What a simulation might keep in its quadrants.
struct State
{
  double rho;
  float velocity[3];
  int rank;
  unsigned char flags[2];
  long long id;
};
constexpr const char* stateText =
  "double rho; float velocity[3]; int rank; unsigned char flags[2]; long long id";

inline State stateOf(const ForestQuadrant& q)
{
  const std::uint64_t h = hashOf(q);
  const auto part = [&](int i) { return static_cast<float>(h >> i & 255) / 16.f; };
  State state{};
  state.rho = std::ldexp(static_cast<double>(h >> 11), -53);
  std::ranges::generate(state.velocity, [&, i = 0]() mutable { return part(8 * i++); });
  state.rank = static_cast<int>(h);
  state.flags[0] = static_cast<unsigned char>(h >> 40);
  state.flags[1] = static_cast<unsigned char>(h >> 48);
  state.id = static_cast<long long>(h);
  return state;
}

inline void fillWithStates(ForestWriter& forest)
{
  forest.setPayload(sizeof(State), [](const ForestQuadrant& q, std::byte* payload) {
    const State state = stateOf(q);
    std::memcpy(payload, &state, sizeof(state));
  });
}

using Visit = std::function<void(vtkHyperTreeGridNonOrientedGeometryCursor*)>;

inline void visitLeaves(vtkHyperTreeGridNonOrientedGeometryCursor* cursor, const Visit& visit)
{
  if (cursor->IsLeaf())
  {
    visit(cursor);
    return;
  }
  for (unsigned char child = 0; child < 8; ++child)
  {
    cursor->ToChild(child);
    visitLeaves(cursor, visit);
    cursor->ToParent();
  }
}

/// All leaves by VTK's own cursor.
inline void visitLeaves(vtkHyperTreeGrid* grid, const Visit& visit)
{
  vtkHyperTreeGrid::vtkHyperTreeGridIterator iterator;
  grid->InitializeTreeIterator(iterator);
  vtkNew<vtkHyperTreeGridNonOrientedGeometryCursor> cursor;
  vtkIdType index;
  while (iterator.GetNextTree(index))
  {
    grid->InitializeNonOrientedGeometryCursor(cursor, index);
    visitLeaves(cursor, visit);
  }
}

/// Coarse vertices with their children's first global index; children of a vertex follow each other.
inline void visitCoarse(vtkHyperTreeGrid* grid, const std::function<void(vtkIdType, vtkIdType)>& visit)
{
  vtkHyperTreeGrid::vtkHyperTreeGridIterator iterator;
  grid->InitializeTreeIterator(iterator);
  while (vtkHyperTree* tree = iterator.GetNextTree())
  {
    for (vtkIdType vertex = 0; vertex < tree->GetNumberOfVertices(); ++vertex)
    {
      if (!tree->IsLeaf(vertex))
      {
        visit(tree->GetGlobalIndexFromLocal(vertex),
          tree->GetGlobalIndexFromLocal(tree->GetElderChildIndex(static_cast<unsigned int>(vertex))));
      }
    }
  }
}

inline void refineAnyhow(ForestWriter& forest)
{
  forest.refine([](const ForestQuadrant& q) { return q.level < 1 || (q.level < 4 && hashOf(q) % 5 == 0); });
  fillWithStates(forest);
}

class ForestReaderFixture : public ::testing::Test
{
protected:
  /// Reads without a message.
  vtkHyperTreeGrid* read(const std::string& path, const char* payload, bool generateLevel)
  {
    const MessageCatcher errors(reader_, vtkCommand::ErrorEvent);
    const MessageCatcher warnings(reader_, vtkCommand::WarningEvent);
    reader_->SetFileName(path.c_str());
    reader_->SetPayload(payload);
    reader_->SetGenerateLevel(generateLevel);
    reader_->Modified(); // the file may be another under the same name
    reader_->Update();
    EXPECT_TRUE(errors.messages().empty()) << errors.messages()[0];
    EXPECT_TRUE(warnings.messages().empty()) << warnings.messages()[0];
    EXPECT_EQ(reader_->GetErrorCode(), vtkErrorCode::NoError);
    return reader_->GetHyperTreeGridOutput();
  }

  /// Reads without a Payload and returns the one warning.
  std::string warningOf(const std::string& path)
  {
    const MessageCatcher errors(reader_, vtkCommand::ErrorEvent);
    const MessageCatcher warnings(reader_, vtkCommand::WarningEvent);
    reader_->SetFileName(path.c_str());
    reader_->SetPayload("");
    reader_->SetGenerateLevel(false);
    reader_->Modified();
    reader_->Update();
    EXPECT_TRUE(errors.messages().empty()) << errors.messages()[0];
    EXPECT_EQ(warnings.messages().size(), 1u);
    return warnings.messages().empty() ? "" : warnings.messages()[0];
  }

  std::vector<std::string> arraysRead()
  {
    vtkCellData* const data = reader_->GetHyperTreeGridOutput()->GetCellData();
    std::vector<std::string> names;
    for (int i = 0; i < data->GetNumberOfArrays(); ++i)
    {
      names.emplace_back(data->GetArrayName(i));
    }
    return names;
  }

  /// Reading fails with a message that has this part, and leaves nothing.
  void expectError(const std::string& path, const char* payload, const std::string& part)
  {
    const MessageCatcher errors(reader_, vtkCommand::ErrorEvent);
    const MessageCatcher failures(reader_->GetExecutive(), vtkCommand::ErrorEvent);
    reader_->SetFileName(path.c_str());
    reader_->SetPayload(payload);
    reader_->Modified();
    // A failed pipeline of one process would let the filters of others wait.
    EXPECT_TRUE(reader_->UpdatePiece(0, 1, 0));
    EXPECT_TRUE(failures.messages().empty());
    EXPECT_NE(reader_->GetErrorCode(), vtkErrorCode::NoError);
    ASSERT_EQ(errors.messages().size(), 1u) << part;
    EXPECT_NE(errors.messages()[0].find(part), std::string::npos)
      << errors.messages()[0] << "should say " << part;
    expectEmpty();
  }

  void expectEmpty()
  {
    vtkHyperTreeGrid* const grid = reader_->GetHyperTreeGridOutput();
    EXPECT_EQ(countVertices(grid), 0);
    EXPECT_EQ(grid->GetCellData()->GetNumberOfArrays(), 0);
  }

  /// Everything about a forest of State.
  void expectReadsAs(ForestWriter& forest)
  {
    fillWithStates(forest);
    const std::string path = folder_.file("forest.p8est");
    forest.save(path);
    vtkHyperTreeGrid* const grid = this->read(path, stateText, true);
    this->expectLeaves(grid, forest);
    this->expectCoarse(grid);
  }

  void expectLeaves(vtkHyperTreeGrid* grid, const ForestWriter& forest)
  {
    std::map<int, std::vector<ForestQuadrant>> trees;
    for (const ForestQuadrant& q : forest.quadrants())
    {
      trees[q.tree].push_back(q);
    }
    vtkCellData* const data = grid->GetCellData();
    std::map<int, std::size_t> visited;
    visitLeaves(grid, [&](vtkHyperTreeGridNonOrientedGeometryCursor* cursor) {
      const vtkIdType id = cursor->GetGlobalNodeIndex();
      const int tree = static_cast<int>(data->GetArray("treeid")->GetTuple1(id));
      ASSERT_LT(visited[tree], trees[tree].size());
      const ForestQuadrant& q = trees[tree][visited[tree]++];
      ASSERT_EQ(cursor->GetLevel(), static_cast<unsigned int>(q.level));
      ASSERT_EQ(data->GetArray("level")->GetTuple1(id), q.level);

      double bounds[6];
      cursor->GetBounds(bounds);
      const std::array<ForestWriter::Point, 2> expected = forest.bounds(q);
      for (int a = 0; a < 3; ++a)
      {
        const double width = expected[1][a] - expected[0][a];
        const double rounding = 1e-15 * (std::abs(expected[0][a]) + std::abs(expected[1][a]));
        ASSERT_NEAR(bounds[2 * a], expected[0][a], rounding) << q.level;
        ASSERT_NEAR(bounds[2 * a + 1] - bounds[2 * a], width, rounding);
      }

      const State state = stateOf(q);
      ASSERT_EQ(data->GetArray("rho")->GetTuple1(id), state.rho);
      for (int c = 0; c < 3; ++c)
      {
        ASSERT_EQ(data->GetArray("velocity")->GetComponent(id, c), state.velocity[c]);
      }
      ASSERT_EQ(data->GetArray("rank")->GetTuple1(id), state.rank);
      ASSERT_EQ(data->GetArray("flags")->GetComponent(id, 0), state.flags[0]);
      ASSERT_EQ(data->GetArray("flags")->GetComponent(id, 1), state.flags[1]);
      ASSERT_EQ(data->GetArray("id")->GetVariantValue(id).ToLongLong(), state.id);
    });
    for (const auto& [tree, quadrants] : trees)
    {
      EXPECT_EQ(visited[tree], quadrants.size()) << "tree " << tree;
    }
  }

  void expectCoarse(vtkHyperTreeGrid* grid)
  {
    vtkCellData* const data = grid->GetCellData();
    visitCoarse(grid, [&](vtkIdType node, vtkIdType child) {
      for (const auto& [name, components] : { std::pair("rho", 1), std::pair("velocity", 3) })
      {
        for (int c = 0; c < components; ++c)
        {
          double mean = 0.;
          for (int i = 0; i < 8; ++i)
          {
            mean += data->GetArray(name)->GetComponent(child + i, c) / 8.;
          }
          ASSERT_NEAR(data->GetArray(name)->GetComponent(node, c), mean, 1e-6);
        }
      }
      ASSERT_EQ(data->GetArray("id")->GetVariantValue(node).ToLongLong(),
        data->GetArray("id")->GetVariantValue(child).ToLongLong());
      ASSERT_EQ(
        data->GetArray("flags")->GetComponent(node, 1), data->GetArray("flags")->GetComponent(child, 1));
      ASSERT_EQ(data->GetArray("level")->GetTuple1(node), data->GetArray("level")->GetTuple1(child) - 1);
      ASSERT_EQ(data->GetArray("treeid")->GetTuple1(node), data->GetArray("treeid")->GetTuple1(child));
    });
  }

  TemporaryFolder folder_;
  vtkNew<vtkTreeAMRP4estReader> reader_;
};

} // namespace treeamr::test
