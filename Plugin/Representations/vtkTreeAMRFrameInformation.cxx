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
  os << indent << "Cells: " << this->Cells << endl;
  os << indent << "Levels: " << this->Levels << endl;
  os << indent << "Memory: " << this->Memory << endl;
  os << indent << "Samples: " << this->Samples << endl;
}

//------------------------------------------------------------------------------
void vtkTreeAMRFrameInformation::CopyFromObject(vtkObject* object)
{
  if (auto* representation = vtkTreeAMRVolumeRepresentation::SafeDownCast(object))
  {
    const double error = representation->GetEstimatedError();
    this->SquaredError = error < 0. ? -1. : error * error;
    this->Seconds = representation->GetFrameSeconds();
    this->Cells = representation->GetDrawnCells();
    this->Levels = representation->GetDrawnLevels();
    this->Memory = representation->GetMemory();
    this->Samples = representation->GetFrameSamples();
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
    this->Cells += other->Cells;
    this->Levels = std::max(this->Levels, other->Levels);
    this->Memory += other->Memory;
    this->Samples += other->Samples;
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRFrameInformation::CopyToStream(vtkClientServerStream* stream)
{
  stream->Reset();
  *stream << vtkClientServerStream::Reply << this->SquaredError << this->Seconds << this->Cells
          << this->Levels << this->Memory << this->Samples << vtkClientServerStream::End;
}

//------------------------------------------------------------------------------
void vtkTreeAMRFrameInformation::CopyFromStream(const vtkClientServerStream* stream)
{
  stream->GetArgument(0, 0, &this->SquaredError);
  stream->GetArgument(0, 1, &this->Seconds);
  stream->GetArgument(0, 2, &this->Cells);
  stream->GetArgument(0, 3, &this->Levels);
  stream->GetArgument(0, 4, &this->Memory);
  stream->GetArgument(0, 5, &this->Samples);
}

//------------------------------------------------------------------------------
double vtkTreeAMRFrameInformation::GetEstimatedError() const
{
  return this->SquaredError < 0. ? -1. : std::sqrt(this->SquaredError);
}
