#include "GatheredTriangles.h"

#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPVSession.h"
#include "vtkPolyData.h"
#include "vtkSMProxy.h"
#include "vtkSMSession.h"
#include "vtkTreeAMRTrianglesInformation.h"

vtkStandardNewMacro(GatheredTriangles);

GatheredTriangles::GatheredTriangles()
{
  this->SetNumberOfInputPorts(0);
}

void GatheredTriangles::SetProxy(vtkSMProxy* representation)
{
  this->Proxy = representation;
  this->Modified();
}

int GatheredTriangles::RequestData(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  if (!this->Proxy)
  {
    return 1;
  }
  vtkNew<vtkTreeAMRTrianglesInformation> all;
  this->Proxy->GetSession()->GatherInformation(vtkPVSession::RENDER_SERVER, all, this->Proxy->GetGlobalID());
  if (!all->GetProblem().empty())
  {
    vtkErrorMacro(<< all->GetProblem());
  }
  vtkPolyData::GetData(outputVector)->ShallowCopy(all->GetTriangles());
  return 1;
}
