#include "vtkTreeAMRRepresentation.h"

#include "SweepDrafts.h"

#include "vtkAlgorithmOutput.h"
#include "vtkBoundingBox.h"
#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkCommunicator.h"
#include "vtkCompositeDataSet.h"
#include "vtkCompositeRepresentation.h"
#include "vtkDataArray.h"
#include "vtkDataAssembly.h"
#include "vtkDataAssemblyUtilities.h"
#include "vtkDataSetAttributes.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMath.h"
#include "vtkMatrix4x4.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkPVRenderView.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkProp3D.h"
#include "vtkRenderWindow.h"
#include "vtkRenderer.h"
#include "vtkTransform.h"

#include <vtksys/SystemInformation.hxx>

#include "Error.h"
#include "GridExchange.h"
#include "GridPartition.h"
#include "HyperTreeGridConverter.h"
#include "MachineShare.h"
#include "MergedGrid.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

namespace
{

bool hasTrees(vtkAlgorithmOutput* producer)
{
  return producer &&
    !treeamr::gridsWithTrees(producer->GetProducer()->GetOutputDataObject(producer->GetIndex())).empty();
}

/// Those that a mapper takes without a name: the active scalars, or else the first.
std::vector<std::string> defaultArrays(vtkHyperTreeGrid& grid)
{
  std::vector<std::string> names;
  const auto add = [&](vtkDataArray* array) {
    const std::string name = array && array->GetName() ? array->GetName() : "";
    const bool isData = !name.empty() && name != vtkDataSetAttributes::GhostArrayName();
    if (isData)
    {
      names.push_back(name);
    }
    return isData;
  };
  vtkCellData* const cells = grid.GetCellData();
  add(cells->GetScalars());
  for (int i = 0; i < cells->GetNumberOfArrays() && !add(cells->GetArray(i)); ++i)
  {
  }
  return names;
}

/// Whatever trees it has, and VTK's version (computeLocalBounds()).
std::array<double, 6> latticeBounds(vtkHyperTreeGrid& grid)
{
  std::array<double, 6> bounds;
  vtkDataArray* const planes[] = { grid.GetXCoordinates(), grid.GetYCoordinates(), grid.GetZCoordinates() };
  for (int a = 0; a < 3; ++a)
  {
    planes[a]->GetRange(&bounds[2 * a]);
  }
  return bounds;
}

/// All that draw on a machine, which is known by its name, divide what they may keep among them. On all processes.
void shareMachines(vtkMultiProcessController& controller)
{
  vtksys::SystemInformation machine;
  const auto own = static_cast<vtkIdType>(std::hash<std::string>()(machine.GetHostname()) >> 1);
  std::vector<vtkIdType> all(static_cast<std::size_t>(controller.GetNumberOfProcesses()));
  controller.AllGather(&own, all.data(), 1);
  treeamr::setProcessesOnMachine(static_cast<int>(std::count(all.begin(), all.end(), own)));
}

/// Of what a matrix makes of a box.
void transformBounds(vtkMatrix4x4* matrix, double bounds[6])
{
  const vtkBoundingBox box(bounds);
  if (!box.IsValid())
  {
    return;
  }
  vtkBoundingBox result;
  for (int corner = 0; corner < 8; ++corner)
  {
    double point[4] = { 0., 0., 0., 1. };
    box.GetCorner(corner, point);
    matrix->MultiplyPoint(point, point);
    double place[3] = { point[0] / point[3], point[1] / point[3], point[2] / point[3] };
    result.AddPoint(place);
  }
  result.GetBounds(bounds);
}

/// Whether boxes become boxes: at most moved, scaled, mirrored or turned by right angles.
bool keepsBoxes(vtkMatrix4x4* matrix)
{
  double largest = 0.;
  for (int i = 0; i < 9; ++i)
  {
    largest = std::max(largest, std::abs(matrix->GetElement(i / 3, i % 3)));
  }
  constexpr double rounding = 1e-9;
  for (int column = 0; column < 3; ++column)
  {
    int elements = 0;
    for (int row = 0; row < 3; ++row)
    {
      elements += std::abs(matrix->GetElement(row, column)) > rounding * largest ? 1 : 0;
    }
    if (elements > 1)
    {
      return false;
    }
  }
  return true;
}

} // namespace

//------------------------------------------------------------------------------
vtkTreeAMRRepresentation::vtkTreeAMRRepresentation()
  : Grid(vtkSmartPointer<vtkHyperTreeGrid>::New())
  , Input(Grid)
{
  vtkMath::UninitializeBounds(this->LocalBounds);
}

//------------------------------------------------------------------------------
vtkTreeAMRRepresentation::~vtkTreeAMRRepresentation() = default;

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Grid: " << this->Grid.Get() << endl;
}

//------------------------------------------------------------------------------
int vtkTreeAMRRepresentation::FillInputPortInformation(int vtkNotUsed(port), vtkInformation* info)
{
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkHyperTreeGrid");
  // Named too, or else the executive would hand over the leaves of a composite input one after the other.
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  // A client and a render server of their own have no input.
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  return 1;
}

//------------------------------------------------------------------------------
int vtkTreeAMRRepresentation::RequestData(
  vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->HasExecuted = true;
  // A copy, because a source fills its output object again while the view may still cache this time step.
  this->Input = vtkSmartPointer<vtkHyperTreeGrid>::New();
  vtkMath::UninitializeBounds(this->LocalBounds);
  this->HasInput = inputVector[0]->GetNumberOfInformationObjects() == 1;
  if (this->HasInput)
  {
    vtkDataObject* input = vtkDataObject::GetData(inputVector[0], 0);
    std::vector<treeamr::NamedGrid> grids = treeamr::gridsWithTrees(input);
    this->KeepSelectedBlocks(input, grids);
    vtkHyperTreeGrid* const only = grids.empty() ? vtkHyperTreeGrid::SafeDownCast(input) : grids.front().grid;
    try
    {
      if (grids.size() > 1)
      {
        this->MergeGrids(input->GetClassName(), grids);
      }
      else if (only)
      {
        this->Input->ShallowCopy(only);
        this->GridFlatIndex = grids.empty() ? 1 : grids.front().flatIndex;
      }
      for (const std::string& block : treeamr::blocksOfOtherKinds(input))
      {
        if (this->SaidOfGrids.insert(block).second)
        {
          vtkWarningMacro(<< block << ", of which this representation draws nothing: show it by itself.");
        }
      }
      treeamr::computeLocalBounds(this->Input, this->LocalBounds);
    }
    catch (const std::exception& e)
    {
      this->Input = vtkSmartPointer<vtkHyperTreeGrid>::New();
      vtkErrorMacro(<< e.what());
    }
  }
  this->Grid = this->Input;
  return this->Superclass::RequestData(request, inputVector, outputVector);
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::AddBlockSelector(const char* selector)
{
  this->BlockSelectors.emplace_back(selector ? selector : "");
  this->MarkModified();
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::RemoveAllBlockSelectors()
{
  this->BlockSelectors.clear();
  this->MarkModified();
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::SetActiveAssembly(const char* assembly)
{
  this->ActiveAssembly = assembly ? assembly : "";
  this->MarkModified();
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::WarnOfBlocks()
{
  for (const std::string& property : this->IgnoredOfBlocks)
  {
    if (!this->SaidOfGrids.insert(property).second)
    {
      continue;
    }
    vtkWarningMacro(<< property
                    << " are without effect: a collection is drawn as one grid. Extract a block to show it "
                       "in its own colour or opacity.");
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::KeepSelectedBlocks(
  vtkDataObject* input, std::vector<treeamr::NamedGrid>& grids) const
{
  vtkCompositeDataSet* const collection = vtkCompositeDataSet::SafeDownCast(input);
  vtkNew<vtkDataAssembly> hierarchy;
  if (!collection ||
    std::find(this->BlockSelectors.begin(), this->BlockSelectors.end(), "/") != this->BlockSelectors.end() ||
    !vtkDataAssemblyUtilities::GenerateHierarchy(collection, hierarchy))
  {
    return;
  }
  auto* const partitioned = vtkPartitionedDataSetCollection::SafeDownCast(input);
  vtkDataAssembly* const assembly = partitioned ? partitioned->GetDataAssembly() : nullptr;
  const std::vector<unsigned int> selected = assembly && this->ActiveAssembly == "Assembly"
    ? vtkDataAssemblyUtilities::GetSelectedCompositeIds(this->BlockSelectors, assembly, partitioned)
    : hierarchy->GetDataSetIndices(hierarchy->SelectNodes(this->BlockSelectors));
  // Partitions and pieces are no nodes of their own: they follow theirs.
  std::vector<unsigned int> nodes = hierarchy->GetDataSetIndices(vtkDataAssembly::GetRootNode());
  std::sort(nodes.begin(), nodes.end());
  const auto isHidden = [&](const treeamr::NamedGrid& grid) {
    const unsigned int node = *std::prev(std::upper_bound(nodes.begin(), nodes.end(), grid.flatIndex));
    return std::find(selected.begin(), selected.end(), node) == selected.end();
  };
  grids.erase(std::remove_if(grids.begin(), grids.end(), isHidden), grids.end());
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::MergeGrids(
  const std::string& collection, const std::vector<treeamr::NamedGrid>& grids)
{
  std::string leftOut;
  try
  {
    for (const std::string& array : treeamr::mergeGrids(grids, this->Input))
    {
      leftOut += (leftOut.empty() ? "" : ", ") + array;
    }
  }
  catch (const std::exception& e)
  {
    throw treeamr::Error("The " + collection + " holds " + std::to_string(grids.size()) +
      " hyper tree grids that cannot be drawn as one: " + e.what() + ". Extract one block first.");
  }
  this->GridFlatIndex = 0;
  if (!leftOut.empty() && leftOut != this->LastLeftOut)
  {
    vtkWarningMacro(
      "The " << collection << " is drawn as one grid without arrays that not all have: " << leftOut);
  }
  this->LastLeftOut = leftOut;
}

//------------------------------------------------------------------------------
std::string vtkTreeAMRRepresentation::GetColorArrayName()
{
  vtkInformation* info = this->GetInputArrayInformation(0);
  const char* name =
    info && info->Has(vtkDataObject::FIELD_NAME()) ? info->Get(vtkDataObject::FIELD_NAME()) : nullptr;
  return name ? name : "";
}

//------------------------------------------------------------------------------
int vtkTreeAMRRepresentation::ProcessViewRequest(
  vtkInformationRequestKey* request, vtkInformation* inInfo, vtkInformation* outInfo)
{
  this->HasExecuted = false;
  vtkMultiProcessController* const controller = vtkMultiProcessController::GetGlobalController();
  const bool isOneOfSeveral = controller && controller->GetNumberOfProcesses() > 1;
  // On a client too, or else it would not have the new grid delivered.
  if (request == vtkPVView::REQUEST_UPDATE() && (isOneOfSeveral || !this->HasInput))
  {
    this->AskForShownArrays();
  }
  const bool isDue = request == vtkPVView::REQUEST_UPDATE() && this->GetNeedsUpdate();
  if (!this->Superclass::ProcessViewRequest(request, inInfo, outInfo))
  {
    return 0;
  }
  const bool hasFailed =
    isDue && !this->HasExecuted && !vtkPVView::SafeDownCast(this->GetView())->IsCached(this);
  if (hasFailed)
  {
    // The input failed, of which ParaView's pipelines do not tell their proxy: it would wait for this update's end
    // for ever, and have no other when the input is mended.
    this->InvokeEvent(vtkCommand::UpdateDataEvent);
  }
  if (request == vtkPVView::REQUEST_UPDATE())
  {
    this->WarnOfBlocks();
    if (isOneOfSeveral)
    {
      this->Redistribute(hasFailed);
    }
    this->UpdateFromAllRanks();
    vtkPVRenderView::SetPiece(inInfo, this, this->Grid);
    vtkPVRenderView::SetDeliverToClientAndRenderingProcesses(inInfo, this, false, false);
    // Until the next render the mapper has the last one's grid or none, for which a vtkVolume answers with the box
    // from -1 to 1: the view would add either to the bounds reported here.
    this->GetProp()->UseBoundsOff();
    vtkNew<vtkMatrix4x4> matrix;
    this->GetProp()->GetMatrix(matrix);
    // The view, given the matrix, would take no more than two corners along, and order ranks by the boxes without it.
    double bounds[6];
    std::copy_n(this->LocalBounds, 6, bounds);
    transformBounds(matrix, bounds);
    vtkPVRenderView::SetGeometryBounds(inInfo, this, bounds);
    vtkPVRenderView::SetRequiresDistributedRendering(inInfo, this, true);
    vtkPVRenderView::SetOrderedCompositingConfiguration(
      inInfo, this, vtkPVRenderView::USE_BOUNDS_FOR_REDISTRIBUTION);
    if (this->NeedsOrderedCompositing())
    {
      outInfo->Set(vtkPVRenderView::NEED_ORDERED_COMPOSITING(), 1);
    }
    if (isOneOfSeveral && controller->GetLocalProcessId() == 0)
    {
      if (this->NeedsOrderedCompositing() && !keepsBoxes(matrix) && this->SaidOfGrids.insert("turned").second)
      {
        vtkWarningMacro(
          "A display that is turned by other than right angles: of several ranks one may be drawn over "
          "another in the wrong order. One rank draws it right.");
      }
      this->WarnOfOtherBoxes();
    }
  }
  else if (request == vtkPVView::REQUEST_UPDATE_LOD())
  {
    vtkPVRenderView::SetRequiresDistributedRenderingLOD(inInfo, this, true);
  }
  else if (request == vtkPVView::REQUEST_RENDER())
  {
    vtkAlgorithmOutput* producer = vtkPVRenderView::GetPieceProducer(inInfo, this);
    this->UpdateMapper(producer);
    const bool draws = this->GetVisibility() && hasTrees(producer);
    if (isOneOfSeveral)
    {
      this->FindPeers(controller, draws);
      this->AgreeOnDrafts(vtkPVRenderView::SafeDownCast(this->GetView())->GetRenderer(),
        [controller](std::array<double, 3>& numbers) {
          const std::array<double, 3> own = numbers;
          controller->AllReduce(own.data(), numbers.data(), 3, vtkCommunicator::MAX_OP);
        });
    }
    this->Drafts->StartFrame(vtkPVRenderView::SafeDownCast(this->GetView()), this->GetDraftedIsovalues());
    this->GetProp()->UseBoundsOn();
    // The mappers report a grid without trees as an error, but many ranks may have nothing to draw.
    this->GetProp()->SetVisibility(draws || (this->GetVisibility() && this->IsExportedWithoutTrees()));
  }
  return 1;
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::FollowProgress(vtkAlgorithm* mapper)
{
  mapper->AddObserver(vtkCommand::ProgressEvent, this, &vtkTreeAMRRepresentation::MapperProgressed);
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::MapperProgressed(
  vtkObject* vtkNotUsed(mapper), unsigned long vtkNotUsed(event), void* part)
{
  auto view = vtkPVRenderView::SafeDownCast(this->GetView());
  // Frames while the camera moves are over before anybody could read it.
  if (view && view->GetRenderWindow()->GetDesiredUpdateRate() < 1.)
  {
    this->UpdateProgress(*static_cast<double*>(part));
  }
}

//------------------------------------------------------------------------------
// A grid with other arrays takes the place of the one in the view's cache when the pipeline has run again.
void vtkTreeAMRRepresentation::AskForShownArrays()
{
  const std::size_t known = this->TakenArrays.size();
  this->TakenArrays.merge(this->GetShownArrays());
  if (this->TakenArrays.size() > known)
  {
    this->MarkModified();
  }
}

//------------------------------------------------------------------------------
// Ranks are composited whole, one in front of the other: right where all have the same boxes.
void vtkTreeAMRRepresentation::WarnOfOtherBoxes()
{
  const auto own = treeamr::partitionOf(*this->Grid);
  for (int i = 0; own && i < this->GetView()->GetNumberOfRepresentations(); ++i)
  {
    vtkObject* shown = this->GetView()->GetRepresentation(i);
    if (auto composite = vtkCompositeRepresentation::SafeDownCast(shown))
    {
      shown = composite->GetActiveRepresentation();
    }
    auto* const other = vtkTreeAMRRepresentation::SafeDownCast(shown);
    if (!other || other == this || !other->GetVisibility() ||
      !(this->NeedsOrderedCompositing() || other->NeedsOrderedCompositing()))
    {
      continue;
    }
    const auto theirs = treeamr::partitionOf(*other->Grid);
    const bool isAlike =
      !theirs || (theirs->boxes == own->boxes && latticeBounds(*this->Grid) == latticeBounds(*other->Grid));
    if (!isAlike && this->SaidOfGrids.insert("boxes").second)
    {
      vtkWarningMacro(
        "Two grids of one view are divided among the ranks in different ways: one of them, or parts of it, may "
        "be drawn in the wrong order, also where the grids do not overlap. One rank draws them right.");
    }
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::Redistribute(bool hasFailed)
{
  vtkMultiProcessController* const controller = vtkMultiProcessController::GetGlobalController();
  const int isNew = this->HasExecuted || hasFailed ? 1 : 0;
  int isNewOnAny = 0;
  controller->AllReduce(&isNew, &isNewOnAny, 1, vtkCommunicator::MAX_OP);
  if (!isNewOnAny)
  {
    return;
  }
  shareMachines(*controller);
  if (hasFailed)
  {
    this->Input =
      vtkSmartPointer<vtkHyperTreeGrid>::New(); // not what there was before beside the others' new ones
  }
  vtkMath::UninitializeBounds(this->LocalBounds);
  try
  {
    treeamr::ExchangeOptions options;
    options.keepsOrigins = this->HasSelectableCells();
    options.mayChange = true; // it is a copy
    for (const std::string& name : this->TakenArrays)
    {
      const std::vector<std::string> names =
        name.empty() ? defaultArrays(*this->Input) : std::vector<std::string>{ name };
      options.arrays.insert(options.arrays.end(), names.begin(), names.end());
    }
    const treeamr::ExchangedGrid made = treeamr::exchangeGrid(this->Input, controller, options);
    this->Grid = made.grid;
    for (const std::string& array : made.leftOut)
    {
      if (this->SaidOfGrids.insert(array).second)
      {
        vtkWarningMacro(<< array << ", and cannot be drawn.");
      }
    }
    treeamr::computeLocalBounds(this->Grid, this->LocalBounds);
  }
  catch (const std::exception& e)
  {
    this->Grid = vtkSmartPointer<vtkHyperTreeGrid>::New();
    vtkErrorMacro(<< e.what());
  }
}

//------------------------------------------------------------------------------
bool vtkTreeAMRRepresentation::AddToView(vtkView* view)
{
  auto renderView = vtkPVRenderView::SafeDownCast(view);
  if (!renderView)
  {
    return false;
  }
  renderView->GetRenderer()->AddViewProp(this->GetProp());
  renderView->RegisterPropForHardwareSelection(this, this->GetProp());
  return this->Superclass::AddToView(view);
}

//------------------------------------------------------------------------------
bool vtkTreeAMRRepresentation::RemoveFromView(vtkView* view)
{
  auto renderView = vtkPVRenderView::SafeDownCast(view);
  if (!renderView)
  {
    return false;
  }
  this->Drafts->Cancel();
  renderView->GetRenderer()->RemoveViewProp(this->GetProp());
  renderView->UnRegisterPropForHardwareSelection(this, this->GetProp());
  return this->Superclass::RemoveFromView(view);
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::SetVisibility(bool visible)
{
  this->Superclass::SetVisibility(visible);
  if (!visible)
  {
    this->Drafts->Cancel();
  }
  this->GetProp()->SetVisibility(visible);
}

//------------------------------------------------------------------------------
vtkDataObject* vtkTreeAMRRepresentation::GetRenderedDataObject(int vtkNotUsed(port))
{
  return this->Input;
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::SetPosition(double x, double y, double z)
{
  this->GetProp()->SetPosition(x, y, z);
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::SetScale(double x, double y, double z)
{
  this->GetProp()->SetScale(x, y, z);
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::SetOrientation(double x, double y, double z)
{
  this->GetProp()->SetOrientation(x, y, z);
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::SetOrigin(double x, double y, double z)
{
  this->GetProp()->SetOrigin(x, y, z);
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::SetUserTransform(const double matrix[16])
{
  vtkNew<vtkTransform> transform;
  transform->SetMatrix(matrix);
  this->GetProp()->SetUserTransform(transform);
}

//------------------------------------------------------------------------------
void vtkTreeAMRRepresentation::SetPickable(int pickable)
{
  this->GetProp()->SetPickable(pickable);
}
