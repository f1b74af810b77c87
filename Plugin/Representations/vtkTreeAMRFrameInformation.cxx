#include "vtkTreeAMRFrameInformation.h"

#include "vtkClientServerStream.h"
#include "vtkObjectFactory.h"
#include "vtkTreeAMRVolumeRepresentation.h"

#include <algorithm>
#include <cmath>

vtkStandardNewMacro(vtkTreeAMRFrameInformation);

//------------------------------------------------------------------------------
void vtkTreeAMRFrameInformation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "EstimatedError: " << this->GetEstimatedError() << endl;
  os << indent << "Seconds: " << this->Seconds << endl;
}

//------------------------------------------------------------------------------
void vtkTreeAMRFrameInformation::CopyFromObject(vtkObject* object)
{
  if (auto* representation = vtkTreeAMRVolumeRepresentation::SafeDownCast(object))
  {
    const double error = representation->GetEstimatedError();
    this->SquaredError = error < 0. ? -1. : error * error;
    this->Seconds = representation->GetFrameSeconds();
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRFrameInformation::AddInformation(vtkPVInformation* information)
{
  if (auto* other = vtkTreeAMRFrameInformation::SafeDownCast(information))
  {
    const double squares = std::max(this->SquaredError, 0.) + std::max(other->SquaredError, 0.);
    this->SquaredError = std::max(this->SquaredError, other->SquaredError) < 0. ? -1. : squares;
    this->Seconds = std::max(this->Seconds, other->Seconds);
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRFrameInformation::CopyToStream(vtkClientServerStream* stream)
{
  stream->Reset();
  *stream << vtkClientServerStream::Reply << this->SquaredError << this->Seconds
          << vtkClientServerStream::End;
}

//------------------------------------------------------------------------------
void vtkTreeAMRFrameInformation::CopyFromStream(const vtkClientServerStream* stream)
{
  stream->GetArgument(0, 0, &this->SquaredError);
  stream->GetArgument(0, 1, &this->Seconds);
}

//------------------------------------------------------------------------------
double vtkTreeAMRFrameInformation::GetEstimatedError() const
{
  return this->SquaredError < 0. ? -1. : std::sqrt(this->SquaredError);
}
