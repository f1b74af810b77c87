/**
 * @class   vtkTreeAMRP4estReader
 * @brief   reads forests saved by p8est_save or p4est_save, also those of deal.II, into a vtkHyperTreeGrid
 *
 * One hyper tree per tree of the forest, branch factor 2, one vertex per quadrant and ancestor. The trees
 * must be axis-aligned boxes on one rectilinear lattice, such as unit cube and brick connectivities, turned or reflected
 * in any way; places of the lattice without a tree stay empty. Where the file says how trees are joined but not where they
 * are, as deal.II's do, they are laid out as equal boxes, from Origin and Spacing wide.
 *
 * A forest of two dimensions (p4est_save) becomes a grid in a plane across z, for ParaView's own Surface: there is nothing
 * in it to trace rays through.
 *
 * The file stores each quadrant's payload as bytes without types or names: set Payload to the members of the
 * struct that the program kept in its quadrants, for example `double rho; double velocity[3]`
 * (PayloadLayout.h has the grammar). Each member becomes a cell array of its own type, name and components;
 * the first one that is read is the active scalars. Without a Payload, 8 bytes are read as `double value` if
 * their values look like doubles; anything else is left out. A warning says either.
 *
 * What programs keep in files of their own, one value or several for each quadrant, QuadrantArrays names.
 *
 * A FileName of NAME.info, or of NAME with NAME.info beside it, is a checkpoint of deal.II (`Triangulation::save`): NAME is
 * a forest without payloads, NAME_fixed.data has blocks of bytes for each cell. Here Payload says what each block is, for
 * example `double solution = FE_Q(2); skip; unsigned material` (DealIIBlocks.h has the grammar): arrays have the mean over
 * each cell of functions of finite elements, or after `corners` the values at its eight corners. Without a Payload, blocks
 * of 8 and 64 bytes are read as FE_DGQ(0) and FE_Q(1) if their values look like doubles. A warning says so and lists the blocks.
 *
 * The cell data selection has the arrays there are, all of them on: those that are off take neither memory
 * nor time. Turn an array off before UpdateInformation() has told of it, and it stays off. When some are off
 * and some on, or all that UpdateInformation() has told of are off, those that nobody named are off, too; a name
 * that is on among them must be one of an array.
 *
 * A coarse cell has the mean of its eight children in arrays of float and double, and the value of its first
 * child in arrays of integers.
 *
 * Piece 0 reads the whole forest; all other pieces are empty. A bad file or Payload is an error, told by
 * GetErrorCode() too, and leaves the output empty. The pipeline goes on: in parallel, filters of the other
 * processes wait for those of the first.
 */
#ifndef vtkTreeAMRP4estReader_h
#define vtkTreeAMRP4estReader_h

#include "vtkHyperTreeGridAlgorithm.h"
#include "vtkNew.h"
#include "vtkTreeAMRReaderModule.h"

#include <map>
#include <set>
#include <string>
#include <vector>

class vtkDataArraySelection;

class VTKTREEAMRREADER_EXPORT vtkTreeAMRP4estReader : public vtkHyperTreeGridAlgorithm
{
public:
  static vtkTreeAMRP4estReader* New();
  vtkTypeMacro(vtkTreeAMRP4estReader, vtkHyperTreeGridAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The forest, or NAME.info of a checkpoint.
   */
  vtkSetFilePathMacro(FileName);
  vtkGetFilePathMacro(FileName);
  ///@}

  ///@{
  /**
   * The members of a quadrant's payload, as C declarations, after the word packed those of a packed struct, or what deal.II
   * attached to each cell; empty by default.
   */
  vtkSetStringMacro(Payload);
  vtkGetStringMacro(Payload);
  ///@}

  ///@{
  /**
   * Arrays in files beside the forest, for example `density.npy; double velocity[3] = {}_u.raw`; empty by default.
   * Forest/QuadrantArrays.h has the grammar.
   */
  vtkSetStringMacro(QuadrantArrays);
  vtkGetStringMacro(QuadrantArrays);
  ///@}

  ///@{
  /**
   * Where the first box of a forest without vertices begins, and how wide each is; (0, 0, 0) and (1, 1, 1) by default. Not
   * used for others. A spacing that is not positive is an error.
   */
  vtkSetVector3Macro(Origin, double);
  vtkGetVector3Macro(Origin, double);
  vtkSetVector3Macro(Spacing, double);
  vtkGetVector3Macro(Spacing, double);
  ///@}

  ///@{
  /**
   * Whether there are the arrays `level` (unsigned char) and `treeid` (int). Off by default; they are there
   * anyway when no payload is read.
   */
  vtkSetMacro(GenerateLevel, bool);
  vtkGetMacro(GenerateLevel, bool);
  vtkBooleanMacro(GenerateLevel, bool);
  ///@}

  ///@{
  /**
   * Which arrays are read; status is 0 or 1.
   */
  vtkDataArraySelection* GetCellDataArraySelection();
  int GetNumberOfCellArrays();
  const char* GetCellArrayName(int index);
  int GetCellArrayStatus(const char* name);
  void SetCellArrayStatus(const char* name, int status);
  ///@}

  /**
   * 1 if the file begins as those of p4est and p8est do, or deal.II's NAME.info, else 0.
   */
  virtual int CanReadFile(VTK_FILEPATH const char* fileName);

protected:
  vtkTreeAMRP4estReader();
  ~vtkTreeAMRP4estReader() override;

  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestInformation(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int ProcessTrees(vtkHyperTreeGrid* input, vtkDataObject* output) override;

  char* FileName = nullptr;
  char* Payload = nullptr;
  char* QuadrantArrays = nullptr;
  double Origin[3] = { 0., 0., 0. };
  double Spacing[3] = { 1., 1., 1. };
  bool GenerateLevel = false;

private:
  void Read(vtkHyperTreeGrid* grid, int piece, int pieces);
  void SetSelectableArrays(const std::vector<std::string>& names);
  bool IsSelected(const std::string& name);
  void WarnOfUnknownArrays(const std::string& path, const std::vector<std::string>& names);
  void Remark(const std::string& path, const std::string& remark);

  vtkNew<vtkDataArraySelection> CellDataArraySelection;
  bool HasToldOfArrays = false;
  std::set<std::string> UnknownArrays;
  std::map<std::string, int> LostStatuses; // of arrays that another Payload has taken away
  std::string LastRemark;

  vtkTreeAMRP4estReader(const vtkTreeAMRP4estReader&) = delete;
  void operator=(const vtkTreeAMRP4estReader&) = delete;
};

#endif
