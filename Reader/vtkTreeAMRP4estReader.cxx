// One pass over the quadrants: the header tells the number of nodes of each tree.
#include "vtkTreeAMRP4estReader.h"

#include "CellArrayFillers.h"
#include "Error.h"
#include "Forest/ForestInput.h"
#include "Forest/ForestPiece.h"
#include "Forest/P4estTreeLattice.h"
#include "Forest/QuadrantArrays.h"
#include "GridPartition.h"
#include "HyperTreeGridBuilder.h"

#include "vtkCommand.h"
#include "vtkDataArraySelection.h"
#include "vtkErrorCode.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkInformationIntegerKey.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

vtkStandardNewMacro(vtkTreeAMRP4estReader);

namespace
{

using treeamr::P4estForestFile;
using treeamr::PayloadField;

std::vector<std::uint64_t> NodeCounts(const P4estForestFile& file)
{
  std::vector<std::uint64_t> counts;
  counts.reserve(file.treeCount());
  for (std::int32_t tree = 0; tree < file.treeCount(); ++tree)
  {
    counts.push_back(file.nodeCount(tree));
  }
  return counts;
}

// What the user should know of where the trees are.
std::string RemarkOnPlaces(const P4estForestFile& file, const treeamr::UnitBoxes& boxes)
{
  const treeamr::UnitBoxes unsaid;
  return file.connectivity().vertices.empty() && boxes.origin == unsaid.origin &&
      boxes.spacing == unsaid.spacing
    ? "the file says how its trees are joined but not where they are, so that they are unit cubes: set "
      "Origin "
      "and Spacing to where the first one begins and how wide each is."
    : "";
}

// As the first word of a sentence.
std::string Capitalised(std::string text, bool isSentence)
{
  if (isSentence && !text.empty())
  {
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  }
  return text;
}

// Of a text property.
std::string TextOf(const char* text)
{
  return text ? text : "";
}

// Those of the payload and of files, which keep their names, and those that tell of the quadrants themselves. Throws Error
// when a file's has the name of one of the payload.
std::vector<std::string> ArrayNames(const std::vector<PayloadField>& fields,
  const std::vector<treeamr::QuadrantArray>& ofFiles, bool generateLevel)
{
  std::vector<std::string> names;
  for (const PayloadField& field : fields)
  {
    names.push_back(field.name);
  }
  for (const treeamr::QuadrantArray& array : ofFiles)
  {
    if (std::ranges::find(names, array.field.name) != names.end())
    {
      throw treeamr::Error("quadrant arrays: \"" + array.field.name +
        "\", which is in the payload, too, allowed are other names (name = file)");
    }
    names.push_back(array.field.name);
  }
  if (generateLevel || names.empty())
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

// A file's values as if they were the payload.
class FileFiller : public treeamr::CellArrayFiller
{
public:
  FileFiller(treeamr::QuadrantArrayFile file, vtkIdType nodes)
    : File(std::move(file))
    , Filler(treeamr::makeFiller(this->File.field(), nodes))
  {
  }
  void setLeaf(vtkIdType node, const treeamr::TreeLeaf& leaf) override { this->setLeaves({ leaf }, &node); }
  void setLeaves(const std::vector<treeamr::TreeLeaf>& leaves, const vtkIdType* nodes) override
  {
    for (std::size_t i = 0; i < leaves.size();)
    {
      std::size_t end = i + 1; // of those that follow each other in the file
      while (end < leaves.size() && leaves[end].number == leaves[end - 1].number + 1)
      {
        ++end;
      }
      this->File.records().visit(leaves[i].number, end - i, [&](const std::byte* values) {
        treeamr::TreeLeaf withValues = leaves[i];
        withValues.payload = values;
        this->Filler->setLeaf(nodes[i++], withValues);
      });
    }
  }
  void setInner(vtkIdType node, vtkIdType firstChild, unsigned present) override
  {
    this->Filler->setInner(node, firstChild, present);
  }
  void setMissing(vtkIdType node, vtkIdType sibling) override { this->Filler->setMissing(node, sibling); }
  vtkAbstractArray* array() const noexcept override { return this->Filler->array(); }

private:
  treeamr::QuadrantArrayFile File;
  std::unique_ptr<treeamr::CellArrayFiller> Filler;
};

// Of an array that is no part of the payload.
std::unique_ptr<treeamr::CellArrayFiller> FillerOf(const std::string& name,
  const std::vector<treeamr::QuadrantArray>& ofFiles, const P4estForestFile& file, vtkIdType nodes)
{
  const auto array =
    std::ranges::find(ofFiles, name, [](const treeamr::QuadrantArray& a) { return a.field.name; });
  if (array != ofFiles.end())
  {
    return std::make_unique<FileFiller>(
      treeamr::QuadrantArrayFile(*array, file.path(), file.quadrantCount()), nodes);
  }
  if (name == treeamr::levelArrayName)
  {
    return std::make_unique<treeamr::LevelFiller>(nodes);
  }
  return std::make_unique<treeamr::TreeIdFiller>(nodes);
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

// Of the arrays that GenerateLevel would add: which there are already, and stay what they are.
std::string RemarkOnOwnArrays(
  const std::vector<PayloadField>& fields, const std::vector<treeamr::QuadrantArray>& ofFiles)
{
  std::vector<std::string> names;
  for (const char* name : { treeamr::levelArrayName, treeamr::treeIdArrayName })
  {
    if (std::ranges::find(fields, name, &PayloadField::name) != fields.end() ||
      std::ranges::find(ofFiles, name, [](const treeamr::QuadrantArray& a) { return a.field.name; }) !=
        ofFiles.end())
    {
      names.emplace_back(name);
    }
  }
  return names.empty() ? ""
                       : "GenerateLevel without effect on " + Quoted(names) +
      ": the file's own of that name; rename it in Payload or QuadrantArrays to have both.";
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
  this->SetQuadrantArrays(nullptr);
}

void vtkTreeAMRP4estReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << (this->FileName ? this->FileName : "(none)") << "\n"
     << indent << "Payload: " << (this->Payload ? this->Payload : "(none)") << "\n"
     << indent << "QuadrantArrays: " << (this->QuadrantArrays ? this->QuadrantArrays : "(none)") << "\n"
     << indent << "Origin: " << this->Origin[0] << ", " << this->Origin[1] << ", " << this->Origin[2] << "\n"
     << indent << "Spacing: " << this->Spacing[0] << ", " << this->Spacing[1] << ", " << this->Spacing[2]
     << "\n"
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
// turns off all arrays that this reader has told of: that is what an empty list in a Python state comes to. Of such a
// list ParaView does not tell again what another Payload has taken away and the next one brings back.
void vtkTreeAMRP4estReader::SetSelectableArrays(const std::vector<std::string>& names)
{
  vtkDataArraySelection* const selection = this->CellDataArraySelection;
  const bool someOff = selection->GetNumberOfArraysEnabled() < selection->GetNumberOfArrays();
  std::map<std::string, int> back;
  for (const std::string& name : names)
  {
    auto node = this->LostStatuses.extract(name);
    if (node && someOff && !selection->ArrayExists(name.c_str()))
    {
      back.insert(std::move(node));
    }
  }
  if (!someOff)
  {
    this->LostStatuses.clear();
  }
  for (int i = 0; i < selection->GetNumberOfArrays() && someOff; ++i)
  {
    const char* const name = selection->GetArrayName(i);
    if (std::ranges::find(names, name) == names.end())
    {
      const int status = selection->GetArraySetting(i);
      this->LostStatuses[name] = status;
      if (status)
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
  for (const auto& [name, status] : back)
  {
    selection->SetArraySetting(name.c_str(), status);
  }
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
  return fileName && treeamr::ForestInput::canRead(fileName) ? 1 : 0;
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
  const std::string payload = TextOf(this->Payload);
  const std::string fileName = TextOf(this->FileName);
  try
  {
    const auto ofFiles = treeamr::parseQuadrantArrays(TextOf(this->QuadrantArrays));
    if (!payload.empty()) // the file is not asked
    {
      this->SetSelectableArrays(
        ArrayNames(treeamr::ForestInput::fieldsOf(fileName, payload), ofFiles, this->GenerateLevel));
    }
    else if (!fileName.empty())
    {
      this->SetSelectableArrays(
        ArrayNames(treeamr::ForestInput(fileName).readPayload(payload).fields, ofFiles, this->GenerateLevel));
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
  using SDDP = vtkStreamingDemandDrivenPipeline;
  const auto asked = [outInfo](vtkInformationIntegerKey* key, int unasked) {
    return outInfo->Has(key) ? outInfo->Get(key) : unasked;
  };
  const int piece = asked(SDDP::UPDATE_PIECE_NUMBER(), 0);
  const int pieces = asked(SDDP::UPDATE_NUMBER_OF_PIECES(), 1);
  if (!this->FileName || !*this->FileName)
  {
    this->ErrorCode = vtkErrorCode::NoFileNameError;
    vtkErrorMacro(
      "FileName is not set; allowed are forests saved by p8est_save or p4est_save, and deal.II's NAME.info.");
    return 1;
  }
  this->ErrorCode = vtkErrorCode::FileFormatError;
  try
  {
    this->Read(output, piece, pieces); // not a copy, for which VTK walks all of a masked grid
    this->ErrorCode = vtkErrorCode::NoError;
  }
  catch (const std::bad_alloc&)
  {
    output->Initialize();
    vtkErrorMacro(<< this->FileName << ": not enough memory");
  }
  catch (const std::exception& error)
  {
    output->Initialize();
    vtkErrorMacro(<< error.what());
  }
  return 1;
}

void vtkTreeAMRP4estReader::Read(vtkHyperTreeGrid* grid, int piece, int pieces)
{
  const treeamr::ForestInput input(this->FileName);
  const P4estForestFile& file = input.forest();
  treeamr::UnitBoxes boxes;
  std::copy_n(this->Origin, 3, boxes.origin.begin());
  std::copy_n(this->Spacing, 3, boxes.spacing.begin());
  const treeamr::TreeLattice lattice = treeamr::p4estTreeLattice(file, boxes);
  std::optional<treeamr::ForestPiece> part; // none: all is read
  if (pieces > 1 && file.dimension() == 3)
  {
    part.emplace(file, lattice, piece, pieces);
  }
  else if (piece > 0)
  {
    return; // the first one shows what has two dimensions
  }
  treeamr::HyperTreeGridBuilder builder(
    grid, lattice, part ? part->nodeCounts() : NodeCounts(file), file.path());
  const vtkIdType nodes = builder.nodeCount();

  const treeamr::PayloadReading payload = input.readPayload(TextOf(this->Payload));
  const auto ofFiles = treeamr::parseQuadrantArrays(TextOf(this->QuadrantArrays));
  std::string remarks;
  for (const std::string& remark : { RemarkOnPlaces(file, boxes), payload.remark,
         this->GenerateLevel ? RemarkOnOwnArrays(payload.fields, ofFiles) : std::string() })
  {
    const bool isNext = !remarks.empty();
    remarks += isNext && !remark.empty() ? " " : "";
    remarks += Capitalised(remark, isNext);
  }
  this->Remark(file.path(), remarks);

  const std::vector<std::string> names = ArrayNames(payload.fields, ofFiles, this->GenerateLevel);
  this->WarnOfUnknownArrays(file.path(), names);
  bool withPayload = false;
  for (const std::string& name : names)
  {
    if (!this->IsSelected(name))
    {
      continue;
    }
    const auto field = std::ranges::find(payload.fields, name, &PayloadField::name);
    if (field != payload.fields.end())
    {
      withPayload = true;
      builder.addArray(field->isAtCorners ? treeamr::makeCornerFiller(*field, nodes, lattice)
                                          : treeamr::makeFiller(*field, nodes));
    }
    else
    {
      builder.addArray(FillerOf(name, ofFiles, file, nodes));
    }
  }
  if (part)
  {
    builder.addArray(std::make_unique<treeamr::GhostFiller>(
      nodes, [&](const treeamr::TreeLeaf& leaf) { return part->isGhost(leaf); }));
    treeamr::setPartition(*grid, { part->boxes(), piece });
  }

  const std::uint64_t leafCount = part ? part->leafCount() : file.quadrantCount();
  const std::uint64_t progressStep = leafCount / 50 + 1;
  std::uint64_t told = 0;
  builder.build(
    leafCount, input.blockQuadrants(),
    [&](std::uint64_t begin, std::uint64_t end, treeamr::LeafBlock& block) {
      const std::vector<treeamr::LeafRange> ranges =
        part ? part->ranges(begin, end) : std::vector<treeamr::LeafRange>{ { begin, end } };
      input.readQuadrants(withPayload, ranges, block);
    },
    [&](std::uint64_t done) {
      if (done - told >= progressStep)
      {
        told = done;
        this->UpdateProgress(static_cast<double>(done) / static_cast<double>(leafCount));
      }
    });
  treeamr::setCornerRanges(*grid);
}

int vtkTreeAMRP4estReader::ProcessTrees(vtkHyperTreeGrid*, vtkDataObject*)
{
  return 1; // pure in the base class, for filters; a source has no trees to process
}
