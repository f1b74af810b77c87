// Cells and points found on the isosurface: hardware selection against boxes of cells by VTK's cursors, and the
// pickers that read the depth buffer.
#include "PlaneSurface.h"

#include "vtkBitArray.h"
#include "vtkCellData.h"
#include "vtkCellPicker.h"
#include "vtkFloatArray.h"
#include "vtkHardwareSelector.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGridNonOrientedGeometryCursor.h"
#include "vtkIdTypeArray.h"
#include "vtkInformation.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkSelection.h"
#include "vtkSelectionNode.h"
#include "vtkTreeAMRProbeFilter.h"
#include "vtkUnsignedCharArray.h"
#include "vtkWorldPointPicker.h"

#include <algorithm>
#include <map>
#include <set>

using namespace treeamr::test;

namespace
{

/// Of points taken from the depth buffer, in world coordinates.
constexpr double pointTolerance = 1e-5;

void addLeaves(vtkHyperTreeGridNonOrientedGeometryCursor* cursor, std::map<vtkIdType, Box>& leaves)
{
  if (cursor->IsMasked())
  {
    return;
  }
  if (cursor->IsLeaf())
  {
    Box& box = leaves[cursor->GetGlobalNodeIndex()];
    for (int a = 0; a < 3; ++a)
    {
      box.min[a] = cursor->GetOrigin()[a];
      box.max[a] = box.min[a] + cursor->GetSize()[a];
    }
    return;
  }
  for (int child = 0; child < cursor->GetNumberOfChildren(); ++child)
  {
    cursor->ToChild(static_cast<unsigned char>(child));
    addLeaves(cursor, leaves);
    cursor->ToParent();
  }
}

/// Boxes of the leaves by their index in the cell arrays.
std::map<vtkIdType, Box> leavesOf(vtkHyperTreeGrid* grid)
{
  std::map<vtkIdType, Box> leaves;
  vtkNew<vtkHyperTreeGridNonOrientedGeometryCursor> cursor;
  for (vtkIdType tree = 0; tree < grid->GetMaxNumberOfTrees(); ++tree)
  {
    grid->InitializeNonOrientedGeometryCursor(cursor, tree);
    addLeaves(cursor, leaves);
  }
  return leaves;
}

bool contains(const Box& box, const Point& p)
{
  for (int a = 0; a < 3; ++a)
  {
    if (p[a] < box.min[a] - pointTolerance || p[a] > box.max[a] + pointTolerance)
    {
      return false;
    }
  }
  return true;
}

/// What the last render shows in the centre of a pixel, in data coordinates of the actor.
Point pointShown(Scene& scene, vtkActor* actor, int x, int y, float depth)
{
  scene.renderer->SetDisplayPoint(x + 0.5, y + 0.5, depth);
  scene.renderer->DisplayToWorld();
  const double* world = scene.renderer->GetWorldPoint();
  const Point p{ world[0] / world[3], world[1] / world[3], world[2] / world[3] };
  return Scene::inDataOf(actor, { p, p }).near;
}

using Ids = std::set<vtkIdType>;

class SelectionTest : public PlaneSurfaceTest
{
protected:
  /// For the whole view.
  static vtkSmartPointer<vtkHardwareSelector> selectorOf(Scene& scene)
  {
    scene.render(); // the selector cannot initialise a window
    auto selector = vtkSmartPointer<vtkHardwareSelector>::New();
    selector->SetRenderer(scene.renderer);
    selector->SetArea(0, 0, scene.width() - 1, scene.height() - 1);
    return selector;
  }

  /// The cell of an actor in each pixel; -1: not the actor.
  static std::vector<vtkIdType> cellsOfPixels(Scene& scene, vtkActor* actor)
  {
    const auto selector = selectorOf(scene);
    EXPECT_TRUE(selector->CaptureBuffers());
    std::vector<vtkIdType> cells;
    for (unsigned int y = 0; y < static_cast<unsigned int>(scene.height()); ++y)
    {
      for (unsigned int x = 0; x < static_cast<unsigned int>(scene.width()); ++x)
      {
        const unsigned int place[2] = { x, y };
        const auto info = selector->GetPixelInformation(place);
        cells.push_back(info.Valid && info.Prop == actor ? info.AttributeID : -1);
      }
    }
    return cells;
  }

  /// What a selection holds of an actor.
  static Ids selected(vtkHardwareSelector* selector, vtkActor* actor)
  {
    Ids ids;
    const auto selection = vtkSmartPointer<vtkSelection>::Take(selector->Select());
    for (unsigned int i = 0; i < selection->GetNumberOfNodes(); ++i)
    {
      vtkSelectionNode* node = selection->GetNode(i);
      if (node->GetProperties()->Get(vtkSelectionNode::PROP()) == actor)
      {
        EXPECT_EQ(node->GetContentType(), vtkSelectionNode::INDICES);
        auto* list = vtkIdTypeArray::SafeDownCast(node->GetSelectionList());
        for (vtkIdType k = 0; k < list->GetNumberOfValues(); ++k)
        {
          ids.insert(list->GetValue(k));
        }
      }
    }
    return ids;
  }

  static Ids idsOf(const std::vector<vtkIdType>& cells)
  {
    Ids ids(cells.begin(), cells.end());
    ids.erase(-1);
    return ids;
  }

  /// A pixel has a cell when it shows the surface, and the cell is where it shows the surface. On the plane that
  /// is where the pixel's ray meets it, elsewhere where the depth buffer says. Returns the cells.
  static Ids expectCells(Scene& scene, vtkActor* actor, vtkHyperTreeGrid* grid)
  {
    const std::map<vtkIdType, Box> leaves = leavesOf(grid);
    scene.render();
    const std::vector<float> depths = scene.depths();
    const std::vector<vtkIdType> cells = cellsOfPixels(scene, actor);
    int onPlane = 0;
    for (int y = 0; y < scene.height(); ++y)
    {
      for (int x = 0; x < scene.width(); ++x)
      {
        SCOPED_TRACE("pixel " + std::to_string(x) + ", " + std::to_string(y));
        const std::size_t pixel = static_cast<std::size_t>(y) * scene.width() + x;
        EXPECT_EQ(cells[pixel] >= 0, depths[pixel] < 1.f);
        if (cells[pixel] < 0)
        {
          continue;
        }
        const auto leaf = leaves.find(cells[pixel]);
        if (leaf == leaves.end())
        {
          ADD_FAILURE() << cells[pixel] << " is no leaf";
          continue;
        }
        Point p = pointShown(scene, actor, x, y, depths[pixel]);
        const PixelRay ray = Scene::inDataOf(actor, scene.ray(x, y));
        const Point onRay = ray.at(Scene::meet(ray, center, normal));
        if (isInside(onRay) && !grid->HasMask())
        {
          p = onRay;
          ++onPlane;
        }
        EXPECT_TRUE(contains(leaf->second, p))
          << "cell " << leaf->first << ", point " << p[0] << ", " << p[1] << ", " << p[2];
      }
    }
    EXPECT_TRUE(grid->HasMask() || onPlane > 100);
    const Ids ids = idsOf(cells);
    EXPECT_EQ(selected(selectorOf(scene), actor), ids);
    return ids;
  }
};

} // namespace

TEST_F(SelectionTest, cellsInPerspective)
{
  const auto grid = planeGrid();
  Scene scene(120, 90);
  vtkActor* actor = scene.addIsosurface(grid, "plane", 0.);
  scene.setCamera();
  EXPECT_GT(expectCells(scene, actor, grid).size(), 100u);
}

TEST_F(SelectionTest, cellsOfATransformedActorInParallelProjection)
{
  const auto grid = planeGrid();
  Scene scene(120, 90);
  vtkActor* actor = scene.addIsosurface(grid, "plane", 0.);
  actor->SetScale(1.4, 0.5, 0.8);
  actor->RotateWXYZ(40., 1., 2., -1.);
  actor->SetPosition(0.4, -0.2, 0.3);
  scene.setCamera(true);
  EXPECT_GT(expectCells(scene, actor, grid).size(), 50u);
}

TEST_F(SelectionTest, translucentSurfaceIsSelectedLikeAnOpaqueOne)
{
  Scene scene;
  vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", 0.);
  scene.setCamera();
  const auto opaque = cellsOfPixels(scene, actor);
  EXPECT_GT(idsOf(opaque).size(), 50u);
  actor->GetProperty()->SetOpacity(0.3);
  EXPECT_EQ(cellsOfPixels(scene, actor), opaque);
}

TEST_F(SelectionTest, partOfTheView)
{
  Scene scene;
  vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", 0.);
  scene.setCamera();
  const auto cells = cellsOfPixels(scene, actor);
  Ids expected;
  for (int y = 15; y <= 25; ++y)
  {
    for (int x = 20; x <= 32; ++x)
    {
      expected.insert(cells[static_cast<std::size_t>(y) * scene.width() + x]);
    }
  }
  expected.erase(-1);
  EXPECT_LT(expected.size(), idsOf(cells).size());
  const auto selector = selectorOf(scene);
  selector->SetArea(20, 15, 32, 25);
  EXPECT_EQ(selected(selector, actor), expected);
}

TEST_F(SelectionTest, whatIsInFrontHidesCells)
{
  Scene scene;
  vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", 0.);
  scene.setCamera();
  const auto all = cellsOfPixels(scene, actor);
  vtkActor* rectangle =
    scene.addRectangle({ 0.6, 0.5, 0.7 }, { 0.4, 0., -0.2 }, { 0., 0.4, 0. }, { 1., 0., 0. });
  const auto colors = scene.render();
  const auto visible = cellsOfPixels(scene, actor);
  const auto hiding = cellsOfPixels(scene, rectangle);
  int hidden = 0;
  for (std::size_t pixel = 0; pixel < all.size(); ++pixel)
  {
    const bool red = colors[pixel][0] == 1.f && colors[pixel][1] == 0.f;
    EXPECT_EQ(hiding[pixel], red ? 0 : -1);
    EXPECT_EQ(visible[pixel], red ? -1 : all[pixel]);
    hidden += red && all[pixel] >= 0;
  }
  EXPECT_GT(hidden, 50);
  EXPECT_LT(idsOf(visible).size(), idsOf(all).size());
  EXPECT_EQ(selected(selectorOf(scene), actor), idsOf(visible));
}

TEST_F(SelectionTest, maskedHiddenAndGhostCellsAreNotFound)
{
  const auto grid = planeGrid();
  Ids seen;
  {
    Scene scene(120, 90);
    vtkActor* actor = scene.addIsosurface(grid, "plane", 0.);
    scene.setCamera();
    seen = idsOf(cellsOfPixels(scene, actor));
  }
  vtkNew<vtkBitArray> mask;
  vtkNew<vtkUnsignedCharArray> ghosts;
  ghosts->SetName(vtkDataSetAttributes::GhostArrayName());
  for (vtkIdType i = 0; i < grid->GetCellData()->GetArray("plane")->GetNumberOfTuples(); ++i)
  {
    mask->InsertNextValue(0);
    ghosts->InsertNextValue(0);
  }
  Ids left;
  int n = 0;
  for (const vtkIdType id : seen)
  {
    switch (n++ % 5)
    {
      case 0:
        mask->SetValue(id, 1);
        break;
      case 1:
        ghosts->SetValue(id, vtkDataSetAttributes::HIDDENCELL);
        break;
      case 2:
        ghosts->SetValue(id, vtkDataSetAttributes::DUPLICATECELL);
        break;
      default:
        left.insert(id);
    }
  }
  grid->SetMask(mask);
  grid->GetCellData()->AddArray(ghosts);

  Scene scene(120, 90);
  vtkActor* actor = scene.addIsosurface(grid, "plane", 0.);
  scene.setCamera();
  const Ids found = expectCells(scene, actor, grid);
  EXPECT_GT(found.size(), left.size() / 2);
  for (const vtkIdType id : found)
  {
    EXPECT_TRUE(!seen.count(id) || left.count(id)) << "cell " << id;
  }
}

// The first of an id's two passes holds 24 bits.
TEST_F(SelectionTest, indicesOfMoreThan24Bits)
{
  const auto grid = planeGrid();
  Scene scene;
  vtkActor* actor = scene.addIsosurface(grid, "plane", 0.);
  scene.setCamera();
  std::vector<vtkIdType> expected = cellsOfPixels(scene, actor);
  std::vector<vtkIdType> sorted = expected;
  sorted.erase(std::remove(sorted.begin(), sorted.end(), -1), sorted.end());
  std::sort(sorted.begin(), sorted.end());
  // The limit is among the cells in view.
  const vtkIdType shift = (1 << 24) - sorted[sorted.size() / 2];

  vtkDataArray* values = grid->GetCellData()->GetArray("plane");
  vtkNew<vtkFloatArray> shifted;
  shifted->SetName("shifted");
  shifted->SetNumberOfTuples(shift + values->GetNumberOfTuples());
  for (vtkIdType i = 0; i < values->GetNumberOfTuples(); ++i)
  {
    shifted->SetValue(shift + i, static_cast<float>(values->GetTuple1(i)));
  }
  grid->GetCellData()->AddArray(shifted);
  for (vtkIdType tree = 0; tree < grid->GetMaxNumberOfTrees(); ++tree)
  {
    grid->GetTree(tree)->SetGlobalIndexStart(shift + grid->GetTree(tree)->GetGlobalIndexStart());
  }
  grid->Modified();
  Scene::mapperOf(actor)->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "shifted");
  for (vtkIdType& id : expected)
  {
    id = id < 0 ? -1 : id + shift;
  }
  EXPECT_LT(sorted.front() + shift, 1 << 24);
  EXPECT_GT(sorted.back() + shift, 1 << 24);
  EXPECT_EQ(cellsOfPixels(scene, actor), expected);
}

TEST_F(SelectionTest, noPointsAndNoneBehind)
{
  Scene scene;
  vtkActor* surface = scene.addIsosurface(planeGrid(), "plane", 0.);
  vtkActor* rectangle =
    scene.addRectangle({ 0., 0., -0.3 }, { 0.1, 0., 0. }, { 0., 0.1, 0. }, { 1., 0., 0. });
  scene.setCamera();
  const auto selector = selectorOf(scene);
  selector->SetFieldAssociation(vtkDataObject::FIELD_ASSOCIATION_POINTS);
  EXPECT_EQ(selected(selector, surface), Ids{});
  EXPECT_EQ(selected(selector, rectangle), Ids{});
  surface->VisibilityOff();
  EXPECT_EQ(selected(selector, rectangle), (Ids{ 0, 1, 2, 3 }));
}

TEST_F(SelectionTest, noSurface)
{
  Scene scene;
  vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", 100.);
  scene.setCamera();
  EXPECT_EQ(selected(selectorOf(scene), actor), Ids{});
}

TEST_F(SelectionTest, pickedPointsLieOnTheSurface)
{
  const auto grid = planeGrid();
  Scene scene;
  scene.addIsosurface(grid, "plane", 0.07);
  scene.setCamera();
  scene.render();
  const std::vector<float> depths = scene.depths();
  vtkNew<vtkWorldPointPicker> picker;
  vtkNew<vtkPoints> picked;
  for (int y = 0; y < scene.height(); y += 3)
  {
    for (int x = 0; x < scene.width(); x += 3)
    {
      if (depths[static_cast<std::size_t>(y) * scene.width() + x] < 1.f)
      {
        picker->Pick(x + 0.5, y + 0.5, 0., scene.renderer);
        picked->InsertNextPoint(picker->GetPickPosition());
      }
    }
  }
  ASSERT_GT(picked->GetNumberOfPoints(), 50);
  vtkNew<vtkPolyData> points;
  points->SetPoints(picked);
  vtkNew<vtkTreeAMRProbeFilter> probe;
  probe->SetInputData(points);
  probe->SetSourceData(grid);
  probe->Update();
  vtkPointData* values = probe->GetOutput()->GetPointData();
  for (vtkIdType i = 0; i < picked->GetNumberOfPoints(); ++i)
  {
    const double* p = picked->GetPoint(i);
    EXPECT_NEAR(values->GetArray("plane")->GetTuple1(i), 0.07, pointTolerance);
    if (isInside({ p[0], p[1], p[2] }))
    {
      EXPECT_NEAR(values->GetArray("x")->GetTuple1(i), p[0], pointTolerance);
    }
  }
}

// It intersects data sets itself, and does not take the surface's box for the surface.
TEST_F(SelectionTest, cellPickerFindsWhatItKnows)
{
  Scene scene;
  scene.addIsosurface(planeGrid(), "plane", 0.);
  vtkActor* rectangle = scene.addRectangle({ 0., 0., 0. }, { 3., 0., 0. }, { 0., 3., 0. }, { 1., 0., 0. });
  scene.setCamera();
  scene.render();
  vtkNew<vtkCellPicker> picker;
  EXPECT_TRUE(picker->Pick(0.5 * scene.width(), 0.5 * scene.height(), 0., scene.renderer));
  EXPECT_EQ(picker->GetActor(), rectangle);
  rectangle->VisibilityOff();
  EXPECT_FALSE(picker->Pick(0.5 * scene.width(), 0.5 * scene.height(), 0., scene.renderer));
}
