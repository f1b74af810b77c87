// The triangles of an isosurface on all processes that render it, for the exporters of a client.
#pragma once

#include "vtkPolyDataAlgorithm.h"
#include "vtkWeakPointer.h"

class vtkSMProxy;

/// Fetched anew at each update after it was Modified(); what cannot be fetched is an error, and left out.
class GatheredTriangles : public vtkPolyDataAlgorithm
{
public:
  static GatheredTriangles* New();
  vtkTypeMacro(GatheredTriangles, vtkPolyDataAlgorithm);

  /// Of a vtkTreeAMRIsosurfaceRepresentation.
  void SetProxy(vtkSMProxy* representation);

protected:
  GatheredTriangles();

  int RequestData(
    vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkWeakPointer<vtkSMProxy> Proxy;
};
