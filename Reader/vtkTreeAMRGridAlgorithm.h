/**
 * @class   vtkTreeAMRGridAlgorithm
 * @brief   what filters that make one vtkHyperTreeGrid of data of another kind have in common
 *
 * In parallel the first process gets the pieces of all others and makes all of the grid; those of the others are empty. All
 * processes must update it then, as ParaView's do. Data that cannot be sent (GathersPieces()) stay where they are.
 *
 * What is wrong with the input is one error, and the output is empty then. Warnings come once until they go away.
 */
#ifndef vtkTreeAMRGridAlgorithm_h
#define vtkTreeAMRGridAlgorithm_h

#include "vtkHyperTreeGridAlgorithm.h"
#include "vtkTreeAMRReaderModule.h"

#include <memory> // for std::unique_ptr
#include <string>
#include <vector>

namespace treeamr
{
class OnceReporter;
struct BlockArrays;
} // namespace treeamr

class VTKTREEAMRREADER_EXPORT vtkTreeAMRGridAlgorithm : public vtkHyperTreeGridAlgorithm
{
public:
  vtkAbstractTypeMacro(vtkTreeAMRGridAlgorithm, vtkHyperTreeGridAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

protected:
  vtkTreeAMRGridAlgorithm();
  ~vtkTreeAMRGridAlgorithm() override;

  /// For messages.
  virtual const char* GetInputKind() const = 0;
  virtual bool GathersPieces() const { return true; }
  /// pieces: of the input, one or more, that of the first process first. output: an empty grid. Throws std::exception.
  virtual void Convert(const std::vector<vtkDataObject*>& pieces, vtkHyperTreeGrid* output) = 0;

  void Warn(const std::string& message);
  /// Of those that are averaged or left out.
  void WarnOfArrays(const treeamr::BlockArrays& arrays);
  /// Nothing when there are none.
  void WarnOfLeftOut(const std::vector<std::string>& leftOut);

  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int ProcessTrees(vtkHyperTreeGrid* input, vtkDataObject* output) override;

private:
  vtkTreeAMRGridAlgorithm(const vtkTreeAMRGridAlgorithm&) = delete;
  void operator=(const vtkTreeAMRGridAlgorithm&) = delete;

  std::unique_ptr<treeamr::OnceReporter> Warnings;
};

#endif
