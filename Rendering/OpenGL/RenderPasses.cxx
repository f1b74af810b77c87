#include "RenderPasses.h"

#include "vtkInformation.h"
#include "vtkInformationObjectBaseVectorKey.h"
#include "vtkOpenGLRenderPass.h"
#include "vtkProp.h"

namespace treeamr
{

std::vector<vtkOpenGLRenderPass*> renderPasses(vtkProp* prop)
{
  std::vector<vtkOpenGLRenderPass*> passes;
  vtkInformation* keys = prop->GetPropertyKeys();
  if (keys && keys->Has(vtkOpenGLRenderPass::RenderPasses()))
  {
    const int count = keys->Length(vtkOpenGLRenderPass::RenderPasses());
    for (int i = 0; i < count; ++i)
    {
      vtkObjectBase* object = keys->Get(vtkOpenGLRenderPass::RenderPasses(), i);
      if (vtkOpenGLRenderPass* pass = vtkOpenGLRenderPass::SafeDownCast(object))
      {
        passes.push_back(pass);
      }
    }
  }
  return passes;
}

vtkOpenGLRenderPass* findRenderPass(vtkProp* prop, const char* className)
{
  for (vtkOpenGLRenderPass* pass : renderPasses(prop))
  {
    if (pass->IsA(className))
    {
      return pass;
    }
  }
  return nullptr;
}

bool wantsGeometry(vtkProp* prop)
{
  return findRenderPass(prop, "vtkSSAOPass") != nullptr;
}

bool isDepthPeeling(vtkProp* prop)
{
  return findRenderPass(prop, "vtkDepthPeelingPass") != nullptr;
}

} // namespace treeamr
