// What the volume and the isosurface representation share: one vtkHyperTreeGrid that stays on its rank, and a
// prop.
//
// ParaView cannot move a hyper tree grid between ranks, so each rank gets the cells of a box here, whatever its pipeline
// gives, renders it, and the images are composited. Those of a composite input are drawn as one where they lie on one
// lattice (MergedGrid.h).

#ifndef vtkTreeAMRRepresentation_h
#define vtkTreeAMRRepresentation_h

#include "vtkNew.h" // for Drafts
#include "vtkPVDataRepresentation.h"
#include "vtkSmartPointer.h"                 // for Grid
#include "vtkTreeAMRRepresentationsModule.h" // for the export macro

#include <array>      // for numbers of ranks
#include <functional> // for reductions
#include <set>        // for what was said
#include <string>     // for array names
#include <vector>     // for isovalues

namespace treeamr
{
struct NamedGrid;
}

class SweepDrafts;
class vtkAlgorithm;
class vtkAlgorithmOutput;
class vtkHyperTreeGrid;
class vtkMultiProcessController;
class vtkProp3D;
class vtkRenderer;

class VTKTREEAMRREPRESENTATIONS_EXPORT vtkTreeAMRRepresentation : public vtkPVDataRepresentation
{
public:
  vtkAbstractTypeMacro(vtkTreeAMRRepresentation, vtkPVDataRepresentation);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  int ProcessViewRequest(
    vtkInformationRequestKey* request, vtkInformation* inInfo, vtkInformation* outInfo) override;
  void SetVisibility(bool visible) override;
  vtkDataObject* GetRenderedDataObject(int port) override;

  ///@{
  /// Forwarded to the prop.
  void SetPosition(double x, double y, double z);
  void SetScale(double x, double y, double z);
  void SetOrientation(double x, double y, double z);
  void SetOrigin(double x, double y, double z);
  /// Row by row, of a matrix that follows the others.
  void SetUserTransform(const double matrix[16]);
  void SetPickable(int pickable);
  ///@}
  ///@{
  /// Of vtkGeometryRepresentation: which grids of a collection are drawn, by selectors of its hierarchy, or of the assembly
  /// that it has itself when that is "Assembly". Default "/": all.
  void AddBlockSelector(const char* selector);
  void RemoveAllBlockSelectors();
  void SetActiveAssembly(const char* assembly);
  ///@}
  ///@{
  /// Of vtkGeometryRepresentation: without effect, which is said once, when they would be seen.
  void SetBlockColor(const char*, double, double, double) { this->IgnoredOfBlocks.insert("BlockColors"); }
  void RemoveAllBlockColors() { this->IgnoredOfBlocks.erase("BlockColors"); }
  void SetBlockOpacity(const char*, double) { this->IgnoredOfBlocks.insert("BlockOpacities"); }
  void RemoveAllBlockOpacities() { this->IgnoredOfBlocks.erase("BlockOpacities"); }
  ///@}

protected:
  vtkTreeAMRRepresentation();
  ~vtkTreeAMRRepresentation() override;

  /// The actor or volume that draws, of the subclass.
  virtual vtkProp3D* GetProp() = 0;
  /// Whether the prop blends, so that ranks must be composited in the order of their depth.
  virtual bool NeedsOrderedCompositing() = 0;
  /// Whether exporters get something of the prop on a process without trees, so that it must be visible there, too.
  virtual bool IsExportedWithoutTrees() { return false; }
  /// In every update of the view, on every rank, whether or not its pipeline has run: the place for what ranks decide
  /// together, as a reader that failed on one of them must not leave the others waiting.
  virtual void UpdateFromAllRanks() {}
  /// Names of the cell arrays that the prop shows; an empty one is the first. The same on all ranks.
  virtual std::set<std::string> GetShownArrays() { return { this->GetColorArrayName() }; }
  /// Whether cells can be selected, so that it must be known where they came from.
  virtual bool HasSelectableCells() { return false; }
  /// The isovalues that the prop shows, if interactive frames are drafts of them, else none: see SweepDrafts.
  virtual std::vector<double> GetDraftedIsovalues() = 0;
  /// Before each render: connect the mapper and bring it up to date with the representation.
  virtual void UpdateMapper(vtkAlgorithmOutput* grid) = 0;
  /// Makes each number the largest of all ranks'.
  using Largest = std::function<void(std::array<double, 3>&)>;
  /// Before each render, on every rank of several: the mapper's.
  virtual void AgreeOnDrafts(vtkRenderer* renderer, const Largest& largest) = 0;
  /// As often: who draws with this rank, which has something to draw or nothing.
  virtual void FindPeers(vtkMultiProcessController*, bool /*draws*/) {}

  /// For ParaView's status bar: tells the progress of the mapper's still frames as its own.
  void FollowProgress(vtkAlgorithm* mapper);

  /// The array chosen in the Coloring section; empty: none.
  std::string GetColorArrayName();

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  bool AddToView(vtkView* view) override;
  bool RemoveFromView(vtkView* view) override;

  /// What this rank draws: of several the cells of its box and those that the field there depends on (GridExchange.h), of
  /// one the input; without trees where this rank has none.
  vtkSmartPointer<vtkHyperTreeGrid> Grid;
  /// Of its block in a composite input; 0: it is made of several.
  unsigned int GridFlatIndex = 1;

private:
  vtkTreeAMRRepresentation(const vtkTreeAMRRepresentation&) = delete;
  void operator=(const vtkTreeAMRRepresentation&) = delete;

  /// Throws treeamr::Error when they are on no lattice.
  void MergeGrids(const std::string& collection, const std::vector<treeamr::NamedGrid>& grids);

  /// Takes those of a collection out that are not selected.
  void KeepSelectedBlocks(vtkDataObject* input, std::vector<treeamr::NamedGrid>& grids) const;
  void WarnOfBlocks();
  void MapperProgressed(vtkObject* mapper, unsigned long event, void* part);
  void AskForShownArrays();
  void Redistribute(bool hasFailed);
  void WarnOfOtherBoxes();

  vtkNew<SweepDrafts> Drafts;
  vtkSmartPointer<vtkHyperTreeGrid>
    Input; // a shallow copy of what this rank's pipeline gives, of several grids the merged one
  bool HasInput = false; // as a client of a server has not
  std::set<std::string> TakenArrays; // by Redistribute(): all that have been shown, for each costs it once
  std::string LastLeftOut;           // by MergeGrids()
  std::set<std::string> SaidOfGrids;
  std::set<std::string> IgnoredOfBlocks; // properties that are given
  std::vector<std::string> BlockSelectors{ "/" };
  std::string ActiveAssembly;
  double LocalBounds[6];
  bool HasExecuted = false; // RequestData(), in this update of the view
};

#endif
