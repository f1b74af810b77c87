// One pass over the quadrants: the header tells the number of nodes of each tree, so the arrays' sizes and
// the trees' first global indices are known beforehand. Quadrants come in Morton order, the depth-first order
// of the leaves: the path from the root to the current leaf is all that is kept, and an inner node gets its
// value when its eighth child is complete.
#include "vtkTreeAMRP4estReader.h"

#include "Error.h"
#include "P4estArrayFillers.h"
#include "P4estForestFile.h"
#include "P4estTreeLattice.h"
#include "PayloadGuess.h"
#include "PayloadLayout.h"

#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataArraySelection.h"
#include "vtkDoubleArray.h"
#include "vtkErrorCode.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkSmartPointer.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

vtkStandardNewMacro(vtkTreeAMRP4estReader);

namespace
{

using treeamr::ArrayFillers;
using treeamr::P4estForestFile;
using treeamr::P4estQuadrant;
using treeamr::PayloadField;
using treeamr::PayloadType;

// Grows one hyper tree from its leaves in Morton order.
class TreeBuilder
{
public:
  TreeBuilder(vtkHyperTree* tree, vtkIdType globalStart)
    : Tree(tree)
    , GlobalStart(globalStart)
  {
    tree->SetGlobalIndexStart(globalStart);
  }

  void AddLeaf(const P4estQuadrant& leaf, ArrayFillers& fillers)
  {
    for (; this->Level < leaf.level; ++this->Level)
    {
      // A subdivision's eight children are appended to the tree's vertices.
      this->FirstChild[this->Level] = this->Tree->GetNumberOfVertices();
      this->Tree->SubdivideLeaf(this->Node[this->Level], static_cast<unsigned int>(this->Level));
      this->Node[this->Level + 1] = this->FirstChild[this->Level];
    }
    for (auto& filler : fillers)
    {
      filler->setLeaf(this->GlobalStart + this->Node[this->Level], leaf);
    }
    while (this->Level > 0 && this->Node[this->Level] == this->FirstChild[this->Level - 1] + 7)
    {
      --this->Level;
      for (auto& filler : fillers)
      {
        filler->setInner(
          this->GlobalStart + this->Node[this->Level], this->GlobalStart + this->FirstChild[this->Level]);
      }
    }
    if (this->Level > 0)
    {
      ++this->Node[this->Level];
    }
  }

private:
  vtkHyperTree* Tree;
  vtkIdType GlobalStart;
  // The path from the root to where the next leaf begins: per level the node and, above the last, its first
  // child.
  int Level = 0;
  std::array<vtkIdType, P4estForestFile::maxLevel + 1> Node{};
  std::array<vtkIdType, P4estForestFile::maxLevel + 1> FirstChild{};
};

void SetLattice(vtkHyperTreeGrid* grid, const treeamr::P4estTreeLattice& lattice)
{
  std::array<vtkSmartPointer<vtkDoubleArray>, 3> coordinates;
  std::array<unsigned int, 3> points;
  for (int axis = 0; axis < 3; ++axis)
  {
    const std::vector<double>& planes = lattice.planes()[axis];
    points[axis] = static_cast<unsigned int>(planes.size());
    coordinates[axis] = vtkSmartPointer<vtkDoubleArray>::New();
    coordinates[axis]->SetNumberOfValues(static_cast<vtkIdType>(planes.size()));
    std::ranges::copy(planes, coordinates[axis]->GetPointer(0));
  }
  grid->SetBranchFactor(2);
  grid->SetDimensions(points.data());
  grid->SetXCoordinates(coordinates[0]);
  grid->SetYCoordinates(coordinates[1]);
  grid->SetZCoordinates(coordinates[2]);
}

// The first global index of each tree, and behind the last tree the number of all nodes.
std::vector<vtkIdType> FindTreeStarts(const P4estForestFile& file)
{
  std::vector<vtkIdType> starts(1, 0);
  starts.reserve(file.treeCount() + std::size_t(1));
  for (std::int32_t tree = 0; tree < file.treeCount(); ++tree)
  {
    const std::uint64_t nodes = file.nodeCount(tree);
    constexpr std::uint64_t maxNodes = std::numeric_limits<unsigned int>::max();
    if (nodes > maxNodes)
    {
      throw treeamr::Error(file.path() + ": tree " + std::to_string(tree) + ": " + std::to_string(nodes) +
        " nodes, allowed " + std::to_string(maxNodes) + ", the most of a vtkHyperTree");
    }
    starts.push_back(starts.back() + static_cast<vtkIdType>(nodes));
  }
  return starts;
}

// A layout that fits the size, to show what the property wants.
std::string ExamplePayload(std::size_t size)
{
  for (const auto& [type, bytes] : { std::pair("double", 8), std::pair("float", 4), std::pair("char", 1) })
  {
    if (size % bytes == 0)
    {
      const std::size_t count = size / bytes;
      return std::string(type) + (count > 1 ? " value[" + std::to_string(count) + "]" : " value");
    }
  }
  return {};
}

// What a quadrant's bytes are read as, and what the user should know of it.
struct PayloadReading
{
  std::vector<PayloadField> fields;
  std::string remark;
};

// Without a layout.
PayloadReading GuessPayload(const P4estForestFile& file)
{
  const std::size_t size = file.payloadSize();
  if (size == 0)
  {
    return {};
  }
  const std::string bytes = "the " + std::to_string(size) + " bytes of each quadrant are ";
  if (size != sizeof(double))
  {
    return { {},
      bytes + "left out, for their layout is unknown: set Payload to it, for example \"" +
        ExamplePayload(size) + "\"." };
  }
  constexpr std::uint64_t sampleSize = std::uint64_t(1) << 16; // 1.5 MiB
  treeamr::DoubleGuess guess;
  file.samplePayloads(sampleSize, [&guess](const std::byte* payload) { guess.add(payload); });
  const std::string objection = guess.objection();
  if (objection.empty())
  {
    return { { { "value", PayloadType::Float64, 1, 0 } },
      bytes +
        "read as \"double value\", which they look like: set Payload to say so, or what else they are." };
  }
  return { {},
    bytes + "left out, for it is unknown what they are: read as double they " + objection +
      ". Set Payload to their layout, for example \"double value\", \"long value\" or \"float value[2]\"." };
}

// Throws Error when the layout does not describe what the file holds.
PayloadReading ReadPayload(const P4estForestFile& file, const std::string& text)
{
  if (text.empty())
  {
    return GuessPayload(file);
  }
  const treeamr::PayloadLayout layout = treeamr::PayloadLayout::parse(text);
  if (layout.size() != file.payloadSize())
  {
    throw treeamr::Error(file.path() + ": payload \"" + text + "\" takes " + std::to_string(layout.size()) +
      " bytes, allowed the " + std::to_string(file.payloadSize()) + " bytes per quadrant of the file" +
      (file.payloadSize() == 0 ? "; leave Payload empty for forests saved without data"
                               : "; name all members of the struct, with pad[n] for bytes to leave out"));
  }
  return { layout.fields(), {} };
}

// Those of the payload, which keep their names, and those that tell of the quadrants themselves.
std::vector<std::string> ArrayNames(const std::vector<PayloadField>& fields, bool generateLevel)
{
  std::vector<std::string> names;
  for (const PayloadField& field : fields)
  {
    names.push_back(field.name);
  }
  if (generateLevel || fields.empty())
  {
    for (const char* name : { treeamr::levelArrayName, treeamr::treeIdArrayName })
    {
      if (std::ranges::find(names, name) == names.end())
      {
        names.emplace_back(name);
      }
    }
  }
  return names;
}

std::string Quoted(const std::vector<std::string>& names)
{
  std::string text;
  for (const std::string& name : names)
  {
    text += (text.empty() ? "\"" : ", \"") + name + '"';
  }
  return text;
}

} // namespace

vtkTreeAMRP4estReader::vtkTreeAMRP4estReader()
{
  this->SetNumberOfInputPorts(0);
  this->CellDataArraySelection->AddObserver(
    vtkCommand::ModifiedEvent, this, &vtkTreeAMRP4estReader::Modified);
}

vtkTreeAMRP4estReader::~vtkTreeAMRP4estReader()
{
  this->SetFileName(nullptr);
  this->SetPayload(nullptr);
}

void vtkTreeAMRP4estReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << (this->FileName ? this->FileName : "(none)") << "\n"
     << indent << "Payload: " << (this->Payload ? this->Payload : "(none)") << "\n"
     << indent << "GenerateLevel: " << this->GenerateLevel << "\n"
     << indent << "CellDataArraySelection:\n";
  this->CellDataArraySelection->PrintSelf(os, indent.GetNextIndent());
}

vtkDataArraySelection* vtkTreeAMRP4estReader::GetCellDataArraySelection()
{
  return this->CellDataArraySelection;
}

int vtkTreeAMRP4estReader::GetNumberOfCellArrays()
{
  return this->CellDataArraySelection->GetNumberOfArrays();
}

const char* vtkTreeAMRP4estReader::GetCellArrayName(int index)
{
  return this->CellDataArraySelection->GetArrayName(index);
}

int vtkTreeAMRP4estReader::GetCellArrayStatus(const char* name)
{
  return this->CellDataArraySelection->ArrayIsEnabled(name);
}

void vtkTreeAMRP4estReader::SetCellArrayStatus(const char* name, int status)
{
  this->CellDataArraySelection->SetArraySetting(name, status);
}

// ParaView tells the statuses of a saved state before the Payload whose arrays they are, together with those
// of the arrays there were until then. A list with arrays on and others off is meant as a whole, and so is one that
// turns off all arrays that this reader has told of: that is what an empty list in a Python state comes to.
void vtkTreeAMRP4estReader::SetSelectableArrays(const std::vector<std::string>& names)
{
  vtkDataArraySelection* const selection = this->CellDataArraySelection;
  const bool someOff = selection->GetNumberOfArraysEnabled() < selection->GetNumberOfArrays();
  if (someOff)
  {
    for (int i = 0; i < selection->GetNumberOfArrays(); ++i)
    {
      const char* const name = selection->GetArrayName(i);
      if (selection->GetArraySetting(i) && std::ranges::find(names, name) == names.end())
      {
        this->UnknownArrays.insert(name);
      }
    }
  }
  std::vector<const char*> list;
  bool someOn = false;
  for (const std::string& name : names)
  {
    list.push_back(name.c_str());
    someOn = someOn || selection->ArrayIsEnabled(name.c_str());
  }
  const bool allOff = someOff && selection->GetNumberOfArraysEnabled() == 0 && this->HasToldOfArrays;
  selection->SetArraysWithDefault(
    list.data(), static_cast<int>(list.size()), !allOff && !(someOff && someOn));
  this->HasToldOfArrays = true;
}

bool vtkTreeAMRP4estReader::IsSelected(const std::string& name)
{
  // The file may have got another payload since UpdateInformation().
  return !this->CellDataArraySelection->ArrayExists(name.c_str()) ||
    this->CellDataArraySelection->ArrayIsEnabled(name.c_str());
}

// The names of RequestInformation, which the payload may have got meanwhile.
void vtkTreeAMRP4estReader::WarnOfUnknownArrays(
  const std::string& path, const std::vector<std::string>& names)
{
  std::vector<std::string> unknown;
  std::ranges::copy_if(this->UnknownArrays, std::back_inserter(unknown),
    [&](const std::string& name) { return std::ranges::find(names, name) == names.end(); });
  this->UnknownArrays.clear();
  if (!unknown.empty())
  {
    vtkWarningMacro(<< path << ": " << Quoted(unknown) << " to be read, allowed are " << Quoted(names));
  }
}

// Once: the steps of a series all give the same remark.
void vtkTreeAMRP4estReader::Remark(const std::string& path, const std::string& remark)
{
  if (!remark.empty() && remark != this->LastRemark)
  {
    vtkWarningMacro(<< path << ": " << remark);
  }
  this->LastRemark = remark;
}

int vtkTreeAMRP4estReader::CanReadFile(const char* fileName)
{
  return fileName && P4estForestFile::hasMagic(fileName) ? 1 : 0;
}

int vtkTreeAMRP4estReader::FillOutputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), "vtkHyperTreeGrid");
  return 1;
}

int vtkTreeAMRP4estReader::RequestInformation(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  outputVector->GetInformationObject(0)->Set(vtkAlgorithm::CAN_HANDLE_PIECE_REQUEST(), 1);
  const std::string payload = this->Payload ? this->Payload : "";
  const std::string fileName = this->FileName ? this->FileName : "";
  try
  {
    if (!payload.empty()) // the file is not asked
    {
      this->SetSelectableArrays(
        ArrayNames(treeamr::PayloadLayout::parse(payload).fields(), this->GenerateLevel));
    }
    else if (!fileName.empty())
    {
      this->SetSelectableArrays(
        ArrayNames(GuessPayload(P4estForestFile(fileName)).fields, this->GenerateLevel));
    }
  }
  catch (const std::exception&)
  {
    // RequestData fails of the same and says so.
  }
  return 1;
}

int vtkTreeAMRP4estReader::RequestData(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  vtkInformation* const outInfo = outputVector->GetInformationObject(0);
  vtkHyperTreeGrid* const output = vtkHyperTreeGrid::GetData(outInfo);
  output->Initialize();
  this->ErrorCode = vtkErrorCode::NoError; // not by its setter, which is a modification
  if (outInfo->Has(vtkStreamingDemandDrivenPipeline::UPDATE_PIECE_NUMBER()) &&
    outInfo->Get(vtkStreamingDemandDrivenPipeline::UPDATE_PIECE_NUMBER()) > 0)
  {
    return 1;
  }
  if (!this->FileName || !*this->FileName)
  {
    this->ErrorCode = vtkErrorCode::NoFileNameError;
    vtkErrorMacro("FileName is not set; allowed are forests saved by p8est_save.");
    return 1;
  }
  this->ErrorCode = vtkErrorCode::FileFormatError;
  try
  {
    vtkNew<vtkHyperTreeGrid> grid;
    this->Read(grid);
    output->ShallowCopy(grid);
    this->ErrorCode = vtkErrorCode::NoError;
  }
  catch (const std::bad_alloc&)
  {
    vtkErrorMacro(<< this->FileName << ": not enough memory");
  }
  catch (const std::exception& error)
  {
    vtkErrorMacro(<< error.what());
  }
  return 1;
}

void vtkTreeAMRP4estReader::Read(vtkHyperTreeGrid* grid)
{
  const P4estForestFile file(this->FileName);
  const treeamr::P4estTreeLattice lattice(file);
  SetLattice(grid, lattice);
  const std::vector<vtkIdType> treeStarts = FindTreeStarts(file);
  const vtkIdType nodes = treeStarts.back();

  const PayloadReading payload = ReadPayload(file, this->Payload ? this->Payload : "");
  this->Remark(file.path(), payload.remark);

  const std::vector<std::string> names = ArrayNames(payload.fields, this->GenerateLevel);
  this->WarnOfUnknownArrays(file.path(), names);
  ArrayFillers fillers;
  for (const std::string& name : names)
  {
    if (!this->IsSelected(name))
    {
      continue;
    }
    vtkCellData* const cellData = grid->GetCellData();
    const auto field = std::ranges::find(payload.fields, name, &PayloadField::name);
    if (field != payload.fields.end())
    {
      fillers.push_back(treeamr::makeFiller(cellData, *field, nodes));
    }
    else if (name == treeamr::levelArrayName)
    {
      fillers.push_back(std::make_unique<treeamr::LevelFiller>(cellData, nodes));
    }
    else
    {
      fillers.push_back(std::make_unique<treeamr::TreeIdFiller>(cellData, nodes));
    }
    if (fillers.size() == 1)
    {
      cellData->SetActiveScalars(name.c_str());
    }
  }

  std::unique_ptr<TreeBuilder> builder;
  std::int32_t tree = -1;
  std::uint64_t visited = 0;
  const std::uint64_t progressStep = file.quadrantCount() / 50 + 1;
  file.visitQuadrants([&](const P4estQuadrant& leaf) {
    if (leaf.tree != tree)
    {
      tree = leaf.tree;
      const std::array<int, 3>& place = lattice.place(tree);
      vtkIdType index;
      grid->GetIndexFromLevelZeroCoordinates(index, place[0], place[1], place[2]);
      builder = std::make_unique<TreeBuilder>(grid->GetTree(index, true), treeStarts[tree]);
    }
    builder->AddLeaf(leaf, fillers);
    if (++visited % progressStep == 0)
    {
      this->UpdateProgress(static_cast<double>(visited) / static_cast<double>(file.quadrantCount()));
    }
  });
}

int vtkTreeAMRP4estReader::ProcessTrees(vtkHyperTreeGrid*, vtkDataObject*)
{
  return 1; // pure in the base class, for filters; a source has no trees to process
}
