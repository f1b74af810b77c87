/**
 * @class   vtkTreeAMRP4estReader
 * @brief   reads forests saved by p8est_save into a vtkHyperTreeGrid
 *
 * One hyper tree per tree of the forest, branch factor 2, one vertex per quadrant and ancestor. The trees
 * must be axis-aligned boxes in identity orientation on one rectilinear lattice, such as unit cube and brick
 * connectivities; places of the lattice without a tree stay empty.
 *
 * The file stores each quadrant's payload as bytes without types or names: set Payload to the members of the
 * struct that the program kept in its quadrants, for example `double rho; double velocity[3]`
 * (PayloadLayout.h has the grammar). Each member becomes a cell array of its own type, name and components.
 * Without a Payload, 8 bytes are read as `double value`; of a payload of any other size nothing is read, with
 * a warning.
 *
 * A coarse cell has the mean of its eight children in arrays of float and double, and the value of its first
 * child in arrays of integers.
 *
 * Piece 0 reads the whole forest; all other pieces are empty. A bad file or Payload is an error and leaves
 * the output empty.
 */
#ifndef vtkTreeAMRP4estReader_h
#define vtkTreeAMRP4estReader_h

#include "vtkHyperTreeGridAlgorithm.h"
#include "vtkTreeAMRReaderModule.h"

class VTKTREEAMRREADER_EXPORT vtkTreeAMRP4estReader : public vtkHyperTreeGridAlgorithm
{
public:
  static vtkTreeAMRP4estReader* New();
  vtkTypeMacro(vtkTreeAMRP4estReader, vtkHyperTreeGridAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  vtkSetFilePathMacro(FileName);
  vtkGetFilePathMacro(FileName);

  ///@{
  /**
   * The members of a quadrant's payload, as C declarations; empty by default.
   */
  vtkSetStringMacro(Payload);
  vtkGetStringMacro(Payload);
  ///@}

  ///@{
  /**
   * Whether to add the arrays `level` (unsigned char) and `treeid` (int). Off by default; they are added
   * anyway when no payload is read.
   */
  vtkSetMacro(GenerateLevel, bool);
  vtkGetMacro(GenerateLevel, bool);
  vtkBooleanMacro(GenerateLevel, bool);
  ///@}

  /**
   * 1 if the file begins as those of p4est and p8est do, else 0. Files of 2-D forests are taken, so that
   * reading them tells what is wrong.
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
  bool GenerateLevel = false;

private:
  void Read(vtkHyperTreeGrid* grid);

  vtkTreeAMRP4estReader(const vtkTreeAMRP4estReader&) = delete;
  void operator=(const vtkTreeAMRP4estReader&) = delete;
};

#endif
