#include "vtkTreeAMRTrianglesInformation.h"

#include "vtkAppendPolyData.h"
#include "vtkCharArray.h"
#include "vtkClientServerStream.h"
#include "vtkCommunicator.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPolyData.h"
#include "vtkTreeAMRIsosurfaceRepresentation.h"

vtkStandardNewMacro(vtkTreeAMRTrianglesInformation);

//------------------------------------------------------------------------------
void vtkTreeAMRTrianglesInformation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Pieces: " << this->Pieces.size() << endl;
  os << indent << "Problem: " << this->Problem << endl;
}

//------------------------------------------------------------------------------
void vtkTreeAMRTrianglesInformation::CopyFromObject(vtkObject* object)
{
  auto* representation = vtkTreeAMRIsosurfaceRepresentation::SafeDownCast(object);
  vtkPolyData* triangles = representation ? representation->GetTriangles() : nullptr;
  if (!triangles || triangles->GetNumberOfPoints() == 0)
  {
    return;
  }
  const int processes = vtkMultiProcessController::GetGlobalController()->GetNumberOfProcesses();
  // A sixteenth for names and headers.
  constexpr unsigned long mostMiB = 2048 - 2048 / 16;
  const unsigned long mebibytes = triangles->GetActualMemorySize() / 1024;
  if (mebibytes * processes >= mostMiB)
  {
    this->Problem = "Tree AMR Isosurface: not exported are " + std::to_string(mebibytes) +
      " MiB of triangles, allowed on each of " + std::to_string(processes) + " processes are below " +
      std::to_string(mostMiB / processes) +
      " MiB, as they go to the client in one message. Save the data of a " +
      "Tree AMR Contour instead, which each process writes for itself.";
    return;
  }
  auto piece = vtkSmartPointer<vtkPolyData>::New();
  piece->ShallowCopy(triangles);
  this->Pieces.push_back(piece);
}

//------------------------------------------------------------------------------
void vtkTreeAMRTrianglesInformation::AddInformation(vtkPVInformation* information)
{
  if (auto* other = vtkTreeAMRTrianglesInformation::SafeDownCast(information))
  {
    this->Pieces.insert(this->Pieces.end(), other->Pieces.begin(), other->Pieces.end());
    this->Problem = this->Problem.empty() ? other->Problem : this->Problem;
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRTrianglesInformation::CopyToStream(vtkClientServerStream* stream)
{
  vtkNew<vtkCharArray> bytes;
  if (!this->Pieces.empty())
  {
    vtkCommunicator::MarshalDataObject(this->GetTriangles(), bytes);
  }
  stream->Reset();
  *stream << vtkClientServerStream::Reply << this->Problem
          << vtkClientServerStream::InsertArray(
               bytes->GetPointer(0), static_cast<int>(bytes->GetNumberOfTuples()))
          << vtkClientServerStream::End;
}

//------------------------------------------------------------------------------
void vtkTreeAMRTrianglesInformation::CopyFromStream(const vtkClientServerStream* stream)
{
  this->Pieces.clear();
  stream->GetArgument(0, 0, &this->Problem);
  vtkTypeUInt32 length = 0;
  stream->GetArgumentLength(0, 1, &length);
  if (length > 0)
  {
    vtkNew<vtkCharArray> bytes;
    bytes->SetNumberOfTuples(length);
    stream->GetArgument(0, 1, bytes->GetPointer(0), length);
    auto piece = vtkSmartPointer<vtkPolyData>::New();
    vtkCommunicator::UnMarshalDataObject(bytes, piece);
    this->Pieces.push_back(piece);
  }
}

//------------------------------------------------------------------------------
vtkSmartPointer<vtkPolyData> vtkTreeAMRTrianglesInformation::GetTriangles() const
{
  if (this->Pieces.size() == 1)
  {
    return this->Pieces[0];
  }
  vtkNew<vtkAppendPolyData> all;
  for (vtkPolyData* piece : this->Pieces)
  {
    all->AddInputData(piece);
  }
  if (!this->Pieces.empty())
  {
    all->Update();
  }
  return all->GetOutput();
}
