// What the last picture of a vtkTreeAMRVolumeRepresentation was made of, its error and its time, on all processes that render.
//
// Processes draw parts of the picture whose errors know nothing of each other and are weakened by what lies before: so
// their squares sum to the picture's, or to a bound where parts hide each other. The slowest process takes the frame's
// time. Cells that several processes hold count for each.

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
  double GetCells() const { return this->Cells; }
  int GetLevels() const { return this->Levels; }
  double GetMemory() const { return this->Memory; } // MiB
  double GetSamples() const { return this->Samples; }

protected:
  vtkTreeAMRFrameInformation() = default;
  ~vtkTreeAMRFrameInformation() override = default;

private:
  vtkTreeAMRFrameInformation(const vtkTreeAMRFrameInformation&) = delete;
  void operator=(const vtkTreeAMRFrameInformation&) = delete;

  double SquaredError = -1.;
  double Seconds = 0.;
  double Cells = 0.;
  int Levels = 0;
  double Memory = 0.;
  double Samples = 0.;
};

#endif
