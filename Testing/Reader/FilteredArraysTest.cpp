// What the filters take of a grid: the selected arrays, and no other is read.
#include "vtkTreeAMRContourFilter.h"
#include "vtkTreeAMRProbeFilter.h"

#include "Support/AllocationCounter.h"
#include "Support/HyperTreeGrids.h"

#include "HyperTreeGridConverter.h"

#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataArraySelection.h"
#include "vtkDataSetAttributes.h"
#include "vtkExecutive.h"
#include "vtkFloatArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkStringArray.h"
#include "vtkTypeInt64Array.h"

#include <gtest/gtest.h>

#include <atomic>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// Counts how often its values are read.
class WatchedArray : public vtkIntArray
{
public:
  static WatchedArray* New() { VTK_STANDARD_NEW_BODY(WatchedArray); }
  double GetComponent(vtkIdType tuple, int component) override
  {
    ++reads;
    return this->vtkIntArray::GetComponent(tuple, component);
  }
  std::atomic<long> reads{ 0 };
};

struct Watched
{
  vtkSmartPointer<vtkHyperTreeGrid> grid = makeUniformlyRefinedGrid(3);
  std::vector<vtkSmartPointer<WatchedArray>> arrays;

  Watched()
  {
    for (int i = 0; i < 20; ++i)
    {
      const auto array = vtkSmartPointer<WatchedArray>::New();
      array->SetName(std::string(1, 'a').append(std::to_string(i)).c_str());
      array->SetNumberOfValues(countVertices(grid));
      array->FillValue(i);
      grid->GetCellData()->AddArray(array);
      arrays.push_back(array);
    }
    grid->GetCellData()->SetActiveScalars("scalar");
  }
  /// Names of the arrays that were read since the last call.
  std::string read()
  {
    std::string names;
    for (const auto& array : arrays)
    {
      names += array->reads.exchange(0) > 0 ? std::string(array->GetName()) + " " : "";
    }
    return names;
  }
};

vtkSmartPointer<vtkPolyData> onePoint()
{
  vtkNew<vtkPoints> points;
  points->InsertNextPoint(0.3, 0.4, 0.6);
  const auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  return data;
}

std::string namesOf(vtkPolyData* data)
{
  std::string names;
  for (int i = 0; i < data->GetPointData()->GetNumberOfArrays(); ++i)
  {
    names += std::string(data->GetPointData()->GetArrayName(i)) + " ";
  }
  return names;
}

} // namespace

TEST(FilteredArrays, AProbeReadsTheSelectedAlone)
{
  Watched watched;
  vtkNew<vtkTreeAMRProbeFilter> probe;
  probe->SetInputData(onePoint());
  probe->SetSourceData(watched.grid);
  probe->GetCellDataArraySelection()->EnableArray("a7");
  probe->GetCellDataArraySelection()->EnableArray("a3");
  const MessageCatcher warnings(probe, vtkCommand::WarningEvent);
  probe->Update();
  EXPECT_EQ(watched.read(), "a3 a7 ");
  EXPECT_EQ(namesOf(vtkPolyData::SafeDownCast(probe->GetOutput())), "a3 a7 vtkValidPointMask ");
  EXPECT_EQ(probe->GetOutput()->GetPointData()->GetArray("a7")->GetTuple1(0), 7.);
  // A change of the selection is one of the filter.
  probe->GetCellDataArraySelection()->DisableArray("a7");
  probe->Update();
  EXPECT_EQ(watched.read(), "a3 ");
  probe->GetCellDataArraySelection()->RemoveAllArrays();
  probe->Update();
  EXPECT_EQ(probe->GetOutput()->GetPointData()->GetNumberOfArrays(), 22);
  EXPECT_TRUE(warnings.messages().empty());
  probe->SelectionIsFinalOn();
  const MessageCatcher errors(probe, vtkCommand::ErrorEvent);
  const MessageCatcher pipeline(probe->GetExecutive(), vtkCommand::ErrorEvent);
  probe->Update();
  ASSERT_EQ(errors.messages().size(), 1u);
  EXPECT_NE(errors.messages()[0].find("named and selected"), std::string::npos);
}

TEST(FilteredArrays, AContourReadsTheSelectedBesideItsOwn)
{
  Watched watched;
  vtkNew<vtkTreeAMRContourFilter> contour;
  contour->SetInputData(watched.grid);
  contour->SetValue(0, 300.);
  contour->GetCellDataArraySelection()->EnableArray("a7");
  contour->Update();
  EXPECT_EQ(watched.read(), "a7 ");
  EXPECT_EQ(namesOf(contour->GetOutput()), "scalar Normals a7 ");
  EXPECT_EQ(contour->GetOutput()->GetPointData()->GetArray("a7")->GetTuple1(0), 7.);
  contour->GetCellDataArraySelection()->RemoveAllArrays();
  contour->GetCellDataArraySelection()->EnableArray("scalar");
  contour->Update();
  EXPECT_EQ(watched.read(), "");
  EXPECT_EQ(namesOf(contour->GetOutput()), "scalar Normals ");
  contour->GetCellDataArraySelection()->RemoveAllArrays();
  contour->Update();
  EXPECT_EQ(contour->GetOutput()->GetPointData()->GetNumberOfArrays(), 22);
  contour->SelectionIsFinalOn();
  contour->Update();
  EXPECT_EQ(namesOf(contour->GetOutput()), "scalar Normals ");
  contour->SelectionIsFinalOff();
  // Without a surface there is nothing to interpolate.
  watched.read();
  contour->SetValue(0, -1.);
  contour->Update();
  EXPECT_EQ(watched.read(), "");
  EXPECT_EQ(contour->GetOutput()->GetPointData()->GetNumberOfArrays(), 22);
}

TEST(FilteredArrays, ProbesHoldOneFieldAtATimeAndNoneAfterwards)
{
  const auto grid = makeUniformlyRefinedGrid(5);
  vtkNew<vtkFloatArray> tensor;
  tensor->SetName("tensor");
  tensor->SetNumberOfComponents(9);
  tensor->SetNumberOfTuples(countVertices(grid));
  tensor->Fill(2.);
  grid->GetCellData()->AddArray(tensor);
  std::size_t field = 0;
  const std::size_t one = peakBytes([&] {
    const auto made = acquireField(grid, { "tensor", 0 });
    field = made->byteSize();
  });
  vtkNew<vtkTreeAMRProbeFilter> probe;
  probe->SetInputData(onePoint());
  probe->SetSourceData(grid);
  const std::size_t before = allocatedBytes;
  EXPECT_LT(peakBytes([&] { probe->Update(); }), one + 2 * field);
  EXPECT_LT(allocatedBytes, before + field / 4);
  EXPECT_EQ(probe->GetOutput()->GetPointData()->GetArray("tensor")->GetComponent(0, 8), 2.);
}

TEST(FilteredArrays, SayWhatCannotBeTaken)
{
  Watched watched;
  vtkNew<vtkStringArray> text;
  text->SetName("text");
  text->SetNumberOfValues(countVertices(watched.grid));
  watched.grid->GetCellData()->AddArray(text);
  vtkNew<vtkTypeInt64Array> ids;
  ids->SetName("ids");
  ids->SetNumberOfValues(countVertices(watched.grid));
  ids->FillValue(16777217);
  ids->SetValue(countVertices(watched.grid) - 1, 0);
  watched.grid->GetCellData()->AddArray(ids);
  const auto expectWarning = [&](vtkAlgorithm* filter, vtkDataArraySelection* selection) {
    for (const char* name : { "text", "a1", "missing", "ids" })
    {
      selection->EnableArray(name);
    }
    const MessageCatcher warnings(filter, vtkCommand::WarningEvent);
    filter->Update();
    ASSERT_EQ(warnings.messages().size(), 2u);
    EXPECT_NE(warnings.messages()[0].find("'ids' has whole numbers up to 16777217"), std::string::npos);
    EXPECT_NE(
      warnings.messages()[1].find("'missing' does not exist; there are: 'scalar'"), std::string::npos);
    // As in the steps of a series, where the numbers vary.
    ids->SetValue(1, 16777219);
    ids->Modified();
    filter->Modified();
    filter->Update();
    EXPECT_EQ(warnings.messages().size(), 2u);
    selection->DisableArray("missing");
    filter->Update();
    EXPECT_EQ(warnings.messages().size(), 2u);
    selection->EnableArray("missing");
    filter->Update();
    EXPECT_EQ(warnings.messages().size(), 3u) << "gone away meanwhile";
    ids->SetValue(1, 16777217);
    ids->Modified();
  };
  vtkNew<vtkTreeAMRProbeFilter> probe;
  probe->SetInputData(onePoint());
  probe->SetSourceData(watched.grid);
  expectWarning(probe, probe->GetCellDataArraySelection());
  EXPECT_EQ(namesOf(vtkPolyData::SafeDownCast(probe->GetOutput())), "a1 ids vtkValidPointMask ");
  vtkNew<vtkTreeAMRContourFilter> contour;
  contour->SetInputData(watched.grid);
  contour->SetValue(0, 300.);
  expectWarning(contour, contour->GetCellDataArraySelection());
  EXPECT_EQ(namesOf(contour->GetOutput()), "scalar Normals a1 ids ");

  // As ParaView says that none is wanted.
  probe->GetCellDataArraySelection()->RemoveAllArrays();
  probe->GetCellDataArraySelection()->SetArraySetting(vtkDataSetAttributes::GhostArrayName(), 0);
  const MessageCatcher errors(probe, vtkCommand::ErrorEvent);
  const MessageCatcher pipeline(probe->GetExecutive(), vtkCommand::ErrorEvent);
  probe->Update();
  ASSERT_EQ(errors.messages().size(), 1u);
  EXPECT_NE(errors.messages()[0].find("named and selected"), std::string::npos);
}
