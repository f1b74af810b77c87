// Error and time of the last picture of a vtkTreeAMRVolumeRepresentation on all processes that render.
//
// Processes draw parts of the picture whose errors know nothing of each other and are weakened by what lies before: so
// their squares sum to the picture's, or to a bound where parts hide each other. The slowest process takes the frame's
// time.

#ifndef vtkTreeAMRFrameInformation_h
#define vtkTreeAMRFrameInformation_h

#include "vtkPVInformation.h"
#include "vtkTreeAMRRepresentationsModule.h" // for the export macro

class VTKTREEAMRREPRESENTATIONS_EXPORT vtkTreeAMRFrameInformation : public vtkPVInformation
{
public:
  static vtkTreeAMRFrameInformation* New();
  vtkTypeMacro(vtkTreeAMRFrameInformation, vtkPVInformation);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void CopyFromObject(vtkObject* representation) override;
  void AddInformation(vtkPVInformation* information) override;
  void CopyToStream(vtkClientServerStream* stream) override;
  void CopyFromStream(const vtkClientServerStream* stream) override;

  /// Root mean square over all pixels of the view; -1 when no process estimated it.
  double GetEstimatedError() const;
  double GetSeconds() const { return this->Seconds; }

protected:
  vtkTreeAMRFrameInformation() = default;
  ~vtkTreeAMRFrameInformation() override = default;

private:
  vtkTreeAMRFrameInformation(const vtkTreeAMRFrameInformation&) = delete;
  void operator=(const vtkTreeAMRFrameInformation&) = delete;

  double SquaredError = -1.;
  double Seconds = 0.;
};

#endif
