// The triangles that exporters write of a vtkTreeAMRIsosurfaceRepresentation, of all processes that render it.
//
// Messages between processes are below 2 GiB, which processes share: triangles of a process that has more are left out,
// and the problem said.

#ifndef vtkTreeAMRTrianglesInformation_h
#define vtkTreeAMRTrianglesInformation_h

#include "vtkPVInformation.h"
#include "vtkSmartPointer.h"                 // for Pieces
#include "vtkTreeAMRRepresentationsModule.h" // for the export macro

#include <string> // for Problem
#include <vector> // for Pieces

class vtkPolyData;

class VTKTREEAMRREPRESENTATIONS_EXPORT vtkTreeAMRTrianglesInformation : public vtkPVInformation
{
public:
  static vtkTreeAMRTrianglesInformation* New();
  vtkTypeMacro(vtkTreeAMRTrianglesInformation, vtkPVInformation);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void CopyFromObject(vtkObject* representation) override;
  void AddInformation(vtkPVInformation* information) override;
  void CopyToStream(vtkClientServerStream* stream) override;
  void CopyFromStream(const vtkClientServerStream* stream) override;

  /// Of all processes in one.
  vtkSmartPointer<vtkPolyData> GetTriangles() const;
  /// Why some are missing; empty: none are.
  const std::string& GetProblem() const { return this->Problem; }

protected:
  vtkTreeAMRTrianglesInformation() = default;
  ~vtkTreeAMRTrianglesInformation() override = default;

private:
  vtkTreeAMRTrianglesInformation(const vtkTreeAMRTrianglesInformation&) = delete;
  void operator=(const vtkTreeAMRTrianglesInformation&) = delete;

  std::vector<vtkSmartPointer<vtkPolyData>> Pieces; // none of them empty
  std::string Problem;
};

#endif
