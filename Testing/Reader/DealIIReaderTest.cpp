// Checkpoints that a deal.II program wrote (Testing/Data/DealII/Checkpoints/checkpoints.cc), against the means that the
// program itself took of its functions over each cell, and as spoilt files.
#include "vtkTreeAMRP4estReader.h"
#include "vtkTreeAMRProbeFilter.h"

#include "CornerArrays.h"
#include "Field/CornerValues.h"
#include "Interpolation/Sampler.h"
#include "Support/CornerFunction.h"
#include "Support/ForestBytes.h"
#include "Support/HyperTreeGrids.h"

#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkErrorCode.h"
#include "vtkExecutive.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkInformationIntegerKey.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

const std::string data = std::string(TREEAMR_DATA_DIR) + "/DealII/Checkpoints/";

using Centre = std::array<long, 3>;

/// In 1048576ths, which rounding does not reach and no two centres of the files share.
Centre rounded(const std::array<double, 3>& p)
{
  return { std::lround(p[0] * 0x1p20), std::lround(p[1] * 0x1p20), std::lround(p[2] * 0x1p20) };
}

/// What the program knew of its cells: the means of all components.
std::map<Centre, std::vector<double>> tableOf(const std::string& name)
{
  std::map<Centre, std::vector<double>> table;
  std::ifstream file(data + name + ".txt");
  for (std::string line; std::getline(file, line);)
  {
    std::istringstream numbers(line);
    std::array<double, 3> centre;
    numbers >> centre[0] >> centre[1] >> centre[2];
    std::vector<double>& values = table[rounded(centre)];
    for (double value = 0.; numbers >> value;)
    {
      values.push_back(value);
    }
  }
  return table;
}

/// The function that the program interpolated, as checkpoints.cc has it.
double wave(double x, double y, double z, double phase)
{
  return std::sin(2. * x - 3. * y + z + phase) + x * x * y * z - 0.25 * z;
}

struct Component
{
  std::string array;
  int component = 0;
  double tolerance = 2e-15; // a few roundings of values below 4
};

class DealIIReaderTest : public testing::Test
{
protected:
  vtkHyperTreeGrid* read(const std::string& path, const char* payload)
  {
    reader_->SetFileName(path.c_str());
    reader_->SetPayload(payload);
    reader_->Modified(); // files may have changed
    const MessageCatcher errors(reader_, vtkCommand::ErrorEvent);
    const MessageCatcher warnings(reader_, vtkCommand::WarningEvent);
    reader_->Update();
    errors_ = errors.messages();
    warnings_ = warnings.messages();
    return reader_->GetHyperTreeGridOutput();
  }
  void setBoxes(const std::array<double, 3>& origin, const std::array<double, 3>& spacing)
  {
    reader_->SetOrigin(origin.data());
    reader_->SetSpacing(spacing.data());
  }

  /// components: as the columns of the table.
  void expectTable(const std::string& name, const char* payload, const std::vector<Component>& components)
  {
    SCOPED_TRACE(name);
    vtkHyperTreeGrid* const grid = this->read(data + name + ".info", payload);
    ASSERT_TRUE(errors_.empty()) << errors_[0];
    ASSERT_TRUE(warnings_.empty()) << warnings_[0];
    const auto table = tableOf(name);
    ASSERT_FALSE(table.empty());
    for (std::size_t i = 0; i < components.size(); ++i)
    {
      SCOPED_TRACE(components[i].array + ' ' + std::to_string(components[i].component));
      ASSERT_NE(grid->GetCellData()->GetArray(components[i].array.c_str()), nullptr);
      const std::vector<DrawnCell> cells = drawnCells(grid, components[i].array, components[i].component);
      ASSERT_EQ(cells.size(), table.size());
      for (const DrawnCell& cell : cells)
      {
        std::array<double, 3> centre;
        for (int a = 0; a < 3; ++a)
        {
          centre[a] = (cell.bounds[a] + cell.bounds[a + 3]) / 2.;
        }
        const auto found = table.find(rounded(centre));
        ASSERT_NE(found, table.end()) << centre[0] << ' ' << centre[1] << ' ' << centre[2];
        ASSERT_EQ(found->second.size(), components.size());
        if (components[i].tolerance == 0.)
        {
          ASSERT_EQ(cell.value, found->second[i]);
        }
        else
        {
          ASSERT_NEAR(cell.value, found->second[i], components[i].tolerance);
        }
      }
    }
  }

  void expectError(const std::string& path, const char* payload, const std::string& part)
  {
    SCOPED_TRACE(part);
    vtkHyperTreeGrid* const grid = this->read(path, payload);
    ASSERT_EQ(errors_.size(), 1u);
    EXPECT_NE(errors_[0].find(part), std::string::npos) << errors_[0];
    EXPECT_EQ(reader_->GetErrorCode(), static_cast<unsigned long>(vtkErrorCode::FileFormatError));
    EXPECT_EQ(countVertices(grid), 0);
  }

  /// Of a checkpoint, to spoil; its NAME.
  std::string copyOf(const std::string& name)
  {
    for (const char* ending : { "", ".info", "_fixed.data" })
    {
      std::filesystem::copy_file(
        data + name + ending, folder_.file(name + ending), std::filesystem::copy_options::overwrite_existing);
    }
    return folder_.file(name);
  }

  const TemporaryFolder folder_;
  const vtkNew<vtkTreeAMRP4estReader> reader_;
  std::vector<std::string> errors_;
  std::vector<std::string> warnings_;
};

void writeText(const std::string& path, const std::string& text)
{
  std::ofstream(path) << text;
}

} // namespace

TEST_F(DealIIReaderTest, ValuesOfTheProgram)
{
  this->setBoxes({ -1., -1., -1. }, { 2., 2., 2. });
  this->expectTable("cube", "double average = FE_DGQ(0); double now, before = FE_Q<3>(1)",
    { { "average", 0, 0. }, { "now" }, { "before" } });

  this->setBoxes({ -1., -1., -1. }, { 1., 1., 1. });
  this->expectTable(
    "hyper_L", "double average = FE_DGQ<3>(0);double now=FE_Q(1);", { { "average", 0, 0. }, { "now" } });

  this->setBoxes({ -0.3, 0., 0.1 }, { 0.4, 0.35, 0.3 });
  this->expectTable("rectangle",
    "double solution(velocity, pressure, heat) = FESystem<3>[FE_Q<3>(2)^3-FE_Q<3>(1)-FE_DGQ<3>(1)];\n"
    "unsigned material",
    { { "velocity", 0 }, { "velocity", 1 }, { "velocity", 2 }, { "pressure" }, { "heat" },
      { "material", 0, 0. } });

  this->setBoxes({ 0., 0., 0. }, { 1., 1., 1. + 1e-12 }); // without a remark on unit cubes
  this->expectTable("periodic", "double average = FE_DGQ(0)", { { "average", 0, 0. } });
  this->expectTable(
    "turned", "double average = FE_DGQ(0); double now = FE_Q(2)", { { "average", 0, 0. }, { "now" } });
  this->expectTable("elements",
    "double q = FE_Q(4); double dgq = FE_DGQ(3); double dgp = FE_DGP(2); double enriched = FE_Q_DG0(1); "
    "double linear = FE_Q_iso_Q1(3); double legendre = FE_DGQLegendre(1); float small = FE_Q(2)",
    { { "q" }, { "dgq" }, { "dgp" }, { "enriched" }, { "linear" }, { "legendre" }, { "small", 0, 5e-7 } });
}

// At the corners of the cells.
TEST_F(DealIIReaderTest, ValuesAtCorners)
{
  struct Case
  {
    const char* name;
    const char* payload;
    std::array<double, 3> origin;
    std::array<double, 3> spacing;
    double phase;
    std::size_t cells;
  };
  for (const Case& c :
    { Case{
        "cube", "skip; double before, now = FE_Q(1) corners", { -1., -1., -1. }, { 2., 2., 2. }, 2.1, 120 },
      Case{ "turned", "skip; double now = FE_Q(2) corners", { 0., 0., 0. }, { 1., 1., 1. + 1e-12 }, 1.4, 45 },
      Case{ "rectangle", "double s(u, now, other) = FE_Q(2)^3 - FE_Q(1) - FE_DGQ(1) corners; skip",
        { -0.3, 0., 0.1 }, { 0.4, 0.35, 0.3 }, 0.7 + 3., 20 } })
  {
    SCOPED_TRACE(c.name);
    this->setBoxes(c.origin, c.spacing);
    vtkHyperTreeGrid* const grid = this->read(data + c.name, c.payload);
    ASSERT_TRUE(errors_.empty()) << errors_[0];
    vtkDataArray* const array = grid->GetCellData()->GetArray("now");
    ASSERT_EQ(array->GetNumberOfComponents(), 8);
    EXPECT_STREQ(array->GetComponentName(6), "011");
    for (int corner = 0; corner < 8; ++corner)
    {
      const std::vector<DrawnCell> cells = drawnCells(grid, "now", corner);
      ASSERT_EQ(cells.size(), c.cells);
      for (const DrawnCell& cell : cells)
      {
        const auto at = [&](int axis) { return cell.bounds[axis + (corner >> axis & 1 ? 3 : 0)]; };
        ASSERT_NEAR(cell.value, wave(at(0), at(1), at(2), c.phase), 1e-11);
      }
    }
  }
  // A coarse cell has what its children have at its own corners: the root's of the cube.
  this->setBoxes({ -1., -1., -1. }, { 2., 2., 2. });
  vtkDataArray* const now =
    this->read(data + "cube", "skip; double before, now = FE_Q(1) corners")->GetCellData()->GetArray("now");
  for (int corner = 0; corner < 8; ++corner)
  {
    const auto at = [&](int axis) { return corner >> axis & 1 ? 1. : -1.; };
    EXPECT_NEAR(now->GetComponent(0, corner), wave(at(0), at(1), at(2), 2.1), 1e-14);
  }
  this->expectError(
    data + "cube", "double a = FE_DGQ(0) corners; skip", "\"corners\", allowed corners for one component");
  this->expectError(data + "cube", "skip; double a, b = FE_Q_DG0(1) corners", "\"corners\", allowed corners");
}

// Between the corners of cells, on all of the three meshes. Finite elements are constrained where cells of two levels meet;
// the program interpolated without that.
TEST_F(DealIIReaderTest, ValuesAtCornersAreInterpolated)
{
  struct Case
  {
    const char* name;
    const char* payload;
    std::array<double, 3> origin;
    std::array<double, 3> spacing;
    double phase;
    std::size_t cells;
  };
  for (const Case& c : { Case{ "cube", "skip; double before, now = FE_Q(1) corners", { -1., -1., -1. },
                           { 2., 2., 2. }, 2.1, 120 },
         Case{ "hyper_L", "skip; double now = FE_Q(1) corners", { -1., -1., -1. }, { 1., 1., 1. }, 1.4, 119 },
         Case{ "rectangle", "double s(u, now, other) = FE_Q(2)^3 - FE_Q(1) - FE_DGQ(1) corners; skip",
           { -0.3, 0., 0.1 }, { 0.4, 0.35, 0.3 }, 0.7 + 3., 20 } })
  {
    SCOPED_TRACE(c.name);
    this->setBoxes(c.origin, c.spacing);
    vtkHyperTreeGrid* const grid = this->read(data + c.name, c.payload);
    ASSERT_TRUE(errors_.empty()) << errors_[0];
    EXPECT_TRUE(grid->GetCellData()->GetArray("now")->GetInformation()->Has(cornerValuesKey()));
    const auto field = acquireField(grid, { "now" });
    ASSERT_TRUE(field->corners());
    std::vector<LeafCell> cells;
    for (const CellId& leaf : leavesOf(field->octree()))
    {
      cells.push_back({ leaf, 0.f });
    }
    ASSERT_EQ(cells.size(), c.cells);
    const auto worldOf = [&](const std::array<double, 3>& p) {
      return std::array{ c.origin[0] + c.spacing[0] * p[0], c.origin[1] + c.spacing[1] * p[1],
        c.origin[2] + c.spacing[2] * p[2] };
    };
    const CornerFunction expected(cells, [&](const std::array<double, 3>& p) {
      const auto [x, y, z] = worldOf(p);
      return wave(x, y, z, c.phase);
    });
    const auto sampler = Sampler::create(InterpolationMethod::GTI, field);
    const double range = static_cast<double>(field->range().max) - field->range().min;
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0.001, 0.999);
    for (int i = 0; i < 10000; ++i)
    {
      const CellId& cell = cells[random() % cells.size()].cell;
      std::array<double, 3> place;
      for (int a = 0; a < 3; ++a)
      {
        place[a] = std::ldexp(static_cast<double>(cell.index[a]) + uniform(random), -cell.level);
      }
      FieldSample sample;
      ASSERT_TRUE(sampler->sample(worldOf(place), sample));
      ASSERT_NEAR(sample.value, expected.value(cell, place), 1e-6 * range);
    }
  }
}

// What is one value a cell, to the last digit.
TEST_F(DealIIReaderTest, ValuesOfCellsAtRandomPoints)
{
  struct Case
  {
    const char* name;
    const char* payload;
    std::array<double, 3> origin;
    std::array<double, 3> spacing;
    std::size_t column;
  };
  for (const Case& c :
    { Case{ "cube", "double found = FE_DGQ(0); skip", { -1., -1., -1. }, { 2., 2., 2. }, 0 },
      Case{ "hyper_L", "double found = FE_DGQ(0); skip", { -1., -1., -1. }, { 1., 1., 1. }, 0 },
      Case{ "rectangle", "skip; unsigned found", { -0.3, 0., 0.1 }, { 0.4, 0.35, 0.3 }, 5 } })
  {
    SCOPED_TRACE(c.name);
    this->setBoxes(c.origin, c.spacing);
    vtkHyperTreeGrid* const grid = this->read(data + c.name, c.payload);
    ASSERT_TRUE(errors_.empty()) << errors_[0];
    const auto table = tableOf(c.name);
    const std::vector<DrawnCell> cells = drawnCells(grid, "found");
    ASSERT_EQ(cells.size(), table.size());
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0.001, 0.999);
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    std::vector<double> expected;
    for (int i = 0; i < 10000; ++i)
    {
      const auto& bounds = cells[random() % cells.size()].bounds;
      std::array<double, 3> centre;
      std::array<double, 3> p;
      for (int a = 0; a < 3; ++a)
      {
        centre[a] = (bounds[a] + bounds[a + 3]) / 2.;
        p[a] = std::lerp(bounds[a], bounds[a + 3], uniform(random));
      }
      points->InsertNextPoint(p.data());
      expected.push_back(table.at(rounded(centre))[c.column]);
    }
    vtkNew<vtkPolyData> input;
    input->SetPoints(points);
    vtkNew<vtkTreeAMRProbeFilter> probe;
    probe->SetInputData(input);
    probe->SetSourceData(grid);
    probe->SetInterpolationMethodToNearest();
    probe->Update();
    vtkDataArray* const found = probe->GetOutput()->GetPointData()->GetArray("found");
    for (std::size_t i = 0; i < expected.size(); ++i)
    {
      ASSERT_EQ(found->GetComponent(static_cast<vtkIdType>(i), 0), expected[i]);
    }
  }
}

// A system without names of its own, in other words; what is skipped.
TEST_F(DealIIReaderTest, NamesOfArrays)
{
  vtkCellData* cells =
    this->read(data + "rectangle", "double s = FE_Q(2)^3 - FE_Q(1)^1 - FE_DGQ<3,3>(1); skip")->GetCellData();
  ASSERT_TRUE(errors_.empty()) << errors_[0];
  ASSERT_EQ(cells->GetNumberOfArrays(), 3);
  EXPECT_EQ(cells->GetArray("s_0")->GetNumberOfComponents(), 3);
  EXPECT_EQ(cells->GetArray("s_1")->GetNumberOfComponents(), 1);
  EXPECT_EQ(cells->GetArray("s_2")->GetNumberOfComponents(), 1);
  EXPECT_STREQ(cells->GetScalars()->GetName(), "s_0");

  // Systems in systems have the same values, in arrays of more components.
  vtkNew<vtkTreeAMRP4estReader> nested;
  nested->SetFileName((data + "rectangle").c_str());
  nested->SetSpacing(0.4, 0.35, 0.3);
  nested->SetPayload(
    "double s = FESystem[FESystem[FE_Q(2)^3 - FE_Q(1)] - FE_DGQ(1)]; {uint8 low; uint8 high[3]}");
  nested->Update();
  vtkCellData* const found = nested->GetHyperTreeGridOutput()->GetCellData();
  ASSERT_EQ(found->GetNumberOfArrays(), 4);
  ASSERT_EQ(found->GetArray("s_0")->GetNumberOfComponents(), 4);
  for (vtkIdType i = 0; i < cells->GetNumberOfTuples(); ++i)
  {
    for (int c = 0; c < 3; ++c)
    {
      ASSERT_EQ(found->GetArray("s_0")->GetComponent(i, c), cells->GetArray("s_0")->GetComponent(i, c));
    }
    ASSERT_EQ(found->GetArray("s_0")->GetComponent(i, 3), cells->GetArray("s_1")->GetTuple1(i));
    ASSERT_EQ(found->GetArray("s_1")->GetTuple1(i), cells->GetArray("s_2")->GetTuple1(i));
  }
  EXPECT_EQ(found->GetArray("high")->GetNumberOfComponents(), 3);

  reader_->SetCellArrayStatus("s_0", 0);
  cells =
    this->read(data + "rectangle.info", "double s = FE_Q(2)^3 - FE_Q(1) - FE_DGQ(1); skip")->GetCellData();
  EXPECT_EQ(cells->GetNumberOfArrays(), 2);
}

// Without a word of the user; said once.
TEST_F(DealIIReaderTest, WithoutAPayload)
{
  vtkHyperTreeGrid* grid = this->read(data + "cube.info", "");
  ASSERT_TRUE(errors_.empty()) << errors_[0];
  ASSERT_EQ(warnings_.size(), 1u);
  for (const char* part : { "they are unit cubes: set Origin and Spacing",
         "Of the 2 blocks that deal.II attached to each cell, number 1, of 8 bytes, is read as \"double "
         "block1 = FE_DGQ(0)\", number 2, of 128 bytes, is left out. "
         "Set Payload",
         "\"double block1 = FE_DGQ(0); double block2[16]\": vectors" })
  {
    EXPECT_NE(warnings_[0].find(part), std::string::npos) << warnings_[0];
  }
  ASSERT_EQ(grid->GetCellData()->GetNumberOfArrays(), 1);
  EXPECT_STREQ(grid->GetCellData()->GetScalars()->GetName(), "block1");
  this->read(data + "cube.info", "");
  EXPECT_TRUE(warnings_.empty());

  this->setBoxes({ -1., -1., -1. }, { 1., 1., 1. });
  grid = this->read(data + "hyper_L", ""); // its .info is beside it
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(
    warnings_[0].find("number 2, of 64 bytes, is read as \"double block2 = FE_Q(1)\""), std::string::npos);
  const auto table = tableOf("hyper_L");
  std::vector<double> expected;
  std::vector<double> found;
  for (const auto& [centre, values] : table)
  {
    expected.push_back(values[1]);
  }
  for (const DrawnCell& cell : drawnCells(grid, "block2"))
  {
    found.push_back(cell.value);
  }
  std::ranges::sort(expected);
  std::ranges::sort(found);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
  {
    EXPECT_NEAR(found[i], expected[i], 2e-15);
  }

  grid = this->read(data + "rectangle.info", "");
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_[0].find("number 1, of 776 bytes, is left out, number 2, of 4 bytes, is left out."),
    std::string::npos)
    << warnings_[0];
  EXPECT_EQ(grid->GetCellData()->GetNumberOfArrays(), 2); // level and treeid
  const char* const example = "double block1[97]; float block2";
  EXPECT_NE(warnings_[0].find(example), std::string::npos) << warnings_[0];
  EXPECT_EQ(this->read(data + "rectangle.info", example)->GetCellData()->GetNumberOfArrays(), 2);
  EXPECT_TRUE(errors_.empty());
  grid = this->read(data + "bare.info", "");
  EXPECT_TRUE(errors_.empty() && warnings_.empty());
  EXPECT_EQ(drawnCells(grid, "level").size(), 8u);

  this->read(data + "hp.info", "double average = FE_DGQ(0)");
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_[0].find("left out: 1 block of variable size, in " + data + "hp_variable.data."),
    std::string::npos)
    << warnings_[0];
}

TEST_F(DealIIReaderTest, Files)
{
  EXPECT_EQ(reader_->CanReadFile((data + "cube.info").c_str()), 1);
  EXPECT_EQ(reader_->CanReadFile((data + "cube").c_str()), 1);
  EXPECT_EQ(reader_->CanReadFile((data + "cube_fixed.data").c_str()), 0);
  const std::string other = folder_.file("other.info");
  writeText(other, "version 1\n");
  EXPECT_EQ(reader_->CanReadFile(other.c_str()), 0);

  // A coarse mesh that is no boxes.
  this->expectError(data + "shell.info", "",
    "shell: tree 1, face 1: joined with tree 4, turned against where other faces put it");
}

TEST_F(DealIIReaderTest, WrongPayloads)
{
  const std::string cube = data + "cube.info";
  this->expectError(cube, "double a = FE_DGQ(0)",
    "cube.info: payload \"double a = FE_DGQ(0)\" is of 1 block, allowed 2, as many as deal.II attached to "
    "each cell, of "
    "8, 128 bytes");
  this->expectError(cube, "skip; double a = FE_Q(1)",
    "cube_fixed.data: payload \"double a = FE_Q(1)\" takes 64 bytes, allowed the 128 bytes per cell of block "
    "2; name all "
    "of its vectors, which may be 2 times as many");
  this->expectError(
    cube, "skip; double a = FE_Q(2)", "takes 216 bytes, allowed the 128 bytes per cell of block 2");
  this->expectError(cube, "skip; double a = FE_Q(0)", "position 17: \"0\", allowed a number in 1..16");
  this->expectError(cube, "skip; double a = FE_Nedelec(1)", "\"FE_Nedelec\", allowed FESystem, FE_Q, FE_DGQ");
  this->expectError(cube, "skip; long a = FE_Q(1)", "\"long\", allowed double or float");
  this->expectError(cube, "skip; double a b = FE_Q(1)", "\"b\", allowed \"=\"");
  this->expectError(cube, "skip; double a = FE_Q(1) FE_Q(1)", "\"FE_Q\", allowed \"-\"");
  this->expectError(cube, "skip; double a(b,c) = FE_Q(1)", "2 names in brackets, allowed 1");
  this->expectError(cube, "double a = FE_DGQ(0); double a, b = FE_Q(1)", "\"a\" twice");
  this->expectError(cube, "double a = FE_DGQ(0);; skip", "nothing for a block");
  this->expectError(cube, "skip; double a = FE_Q<2>(1)", "\"2\", allowed \"3\"");
  this->expectError(cube, "skip; double a = FE_Q(1)^1001", "allowed a number in 1..1000");
  this->expectError(cube, "skip; double a = FE_Q(16)^14", "allowed a number in 1..13");
  this->expectError(cube, "skip; double a, b = FE_Q(16)^7", "allowed at most 65536 values of a cell");
  std::string deep = "skip; double a = ";
  for (int i = 0; i < 100000; ++i)
  {
    deep += "FESystem[";
  }
  this->expectError(cube, deep.c_str(), "at most 8 systems");
  this->expectError(cube, "skip; nonsense", "\"nonsense\", allowed pad[n] or a type");
  this->expectError(
    data + "bare.info", "double a = FE_Q(1)", "allowed 0, as many as deal.II attached to each cell: leave");
  this->read(cube, "skip; skip"); // and recovers
  EXPECT_TRUE(errors_.empty());
}

TEST_F(DealIIReaderTest, WrongFiles)
{
  const std::string name = this->copyOf("hyper_L");
  const std::string info = name + ".info";
  const std::string fixed = name + "_fixed.data";
  const std::string head =
    "version nproc n_attached_fixed_size_objs n_attached_variable_size_objs n_coarse_cells\n";
  writeText(info, head + "6 2 2 0 7\n");
  this->expectError(info, "", info + ": version 6, allowed 4 and 5");
  writeText(info, head + "5 2 2 0 7\n"); // of 9.5 and newer
  this->read(info, "");
  EXPECT_TRUE(errors_.empty());
  writeText(info, head + "5 2 -1 0 7\n");
  this->expectError(info, "", "the number of blocks of fixed size: \"-1\", allowed a number");
  writeText(info, head + "5 2 4000000000 0 7\n");
  this->expectError(info, "", "the number of blocks of fixed size: 4000000000, allowed at most");
  writeText(info, head + "5 2 60000 0 7\n");
  this->expectError(info, "", fixed + ": header: 9056 bytes, allowed at least 240004");
  writeText(info, head + "5 2 2 0\n");
  this->expectError(info, "", "the number of coarse cells: \"\", allowed a number");
  writeText(info, head + "5 2 2 0 8\n");
  this->expectError(info, "", "8 coarse cells, allowed 7, the trees of the forest beside it");
  writeText(info, head + "5 2 1 1 7\n");
  this->expectError(
    info, "", "header: 64 bytes of a cell for the ends of 1 blocks of variable size, allowed 4");
  writeText(info, head.substr(0, head.rfind(' ')) + " n_global_active_cells\n5 2 2 0 7\n");
  this->expectError(info, "", "ends in \"n_global_active_cells\", allowed n_coarse_cells");

  this->copyOf("hyper_L");
  const Bytes bytes = readBytes(fixed);
  const auto spoil = [&](std::size_t offset, std::uint32_t value) {
    Bytes spoilt = bytes;
    putAt(spoilt, offset, value);
    writeBytes(fixed, spoilt);
  };
  spoil(0, 0x04000000);
  this->expectError(info, "", fixed + ": header: 67108864 bytes for a cell's status, allowed 4");
  spoil(4, 3);
  this->expectError(info, "", "header: block 1 of a cell ends at 3, allowed at least 4");
  spoil(8, ~0u);
  this->expectError(
    info, "", "cells: 9044 bytes behind the header, allowed 4294967295 for each of the forest's 119 cells");
  spoil(12 + 76 * 5, 3);
  this->expectError(info, "", fixed + ": cell 5: status 3, allowed 0");
  writeBytes(fixed, Bytes(bytes.begin(), bytes.end() - 1));
  this->expectError(info, "", "cells: 9043 bytes behind the header, allowed 76 for each");
  writeBytes(fixed, Bytes(bytes.begin(), bytes.begin() + 5));
  this->expectError(info, "", "header: 5 bytes, allowed at least 12");
  std::filesystem::remove(fixed);
  this->expectError(
    info, "", info + ": 2 blocks are attached to each cell, but " + fixed + " is not beside it");
  std::filesystem::create_directory(fixed);
  this->expectError(info, "", fixed + ": a directory");
  std::filesystem::remove(fixed);
  this->copyOf("hyper_L");
  std::filesystem::rename(info, name + ".txt");
  this->expectError(name + ".txt", "", "by another name, allowed NAME.info");
  this->copyOf("hyper_L");
  std::filesystem::remove(name);
  this->expectError(info, "", "the forest " + name + " is not beside it");
}

TEST_F(DealIIReaderTest, SpoiltFiles)
{
  const std::string name = this->copyOf("periodic");
  std::mt19937_64 random(5);
  int errorCount = 0;
  for (const char* ending : { "", ".info", "_fixed.data" })
  {
    const Bytes bytes = readBytes(name + ending);
    for (int i = 0; i < 60; ++i)
    {
      Bytes spoilt = bytes;
      spoilt[random() % bytes.size()] ^= std::byte(1 << random() % 8);
      if (i % 5 == 0)
      {
        spoilt.resize(random() % bytes.size());
      }
      writeBytes(name + ending, spoilt);
      this->read(name + ".info", "double average = FE_DGQ(0)");
      ASSERT_LE(errors_.size(), 1u);
      errorCount += static_cast<int>(errors_.size());
    }
    writeBytes(name + ending, bytes);
  }
  EXPECT_GT(errorCount, 45);
}
