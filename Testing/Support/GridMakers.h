// Runs a filter that makes a hyper tree grid, and keeps what it says.
#pragma once

#include "Support/HyperTreeGrids.h"

#include "vtkCommand.h"
#include "vtkHyperTreeGrid.h"
#include "vtkNew.h"
#include "vtkSmartPointer.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

class vtkDataObject;

namespace treeamr::test
{

struct MadeGrid
{
  vtkSmartPointer<vtkHyperTreeGrid> grid;
  std::vector<std::string> errors;
  std::vector<std::string> warnings;
};

template <class Filter>
MadeGrid makeGridBy(vtkDataObject* input)
{
  vtkNew<Filter> filter;
  const MessageCatcher errors(filter, vtkCommand::ErrorEvent);
  const MessageCatcher warnings(filter, vtkCommand::WarningEvent);
  filter->SetInputDataObject(input);
  filter->Update();
  return { vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0)), errors.messages(),
    warnings.messages() };
}

/// The only one, and there is no grid.
template <class Filter>
std::string errorOf(vtkDataObject* input)
{
  const MadeGrid result = makeGridBy<Filter>(input);
  EXPECT_EQ(result.grid->GetNumberOfNonEmptyTrees(), 0);
  EXPECT_EQ(result.errors.size(), 1u);
  return result.errors.empty() ? "" : result.errors[0];
}

inline void expectIn(const std::string& text, const std::string& part)
{
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

} // namespace treeamr::test
