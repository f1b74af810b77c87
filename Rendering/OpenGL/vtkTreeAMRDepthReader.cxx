#include "vtkTreeAMRDepthReader.h"

#include "Error.h"

#include "vtkObject.h"
#include "vtkOpenGLError.h" // brings the GL loader of this VTK: glew up to 9.3, glad from 9.4

#include <cstddef>
#include <optional>
#include <string>

namespace
{

// Saves and restores what reading pixels touches. Raw OpenGL: vtkOpenGLState never learns of it.
class PixelReadState
{
public:
  PixelReadState()
    : Scissor(glIsEnabled(GL_SCISSOR_TEST))
  {
    glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &this->ReadBinding);
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &this->DrawBinding);
    glGetIntegerv(GL_RENDERBUFFER_BINDING, &this->RenderbufferBinding);
    glGetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &this->PackBuffer);
    glGetIntegerv(GL_PACK_ALIGNMENT, &this->PackAlignment);
    glDisable(GL_SCISSOR_TEST); // it would cut blits
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
  }
  ~PixelReadState()
  {
    glPixelStorei(GL_PACK_ALIGNMENT, this->PackAlignment);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, static_cast<GLuint>(this->PackBuffer));
    glBindRenderbuffer(GL_RENDERBUFFER, static_cast<GLuint>(this->RenderbufferBinding));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(this->ReadBinding));
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(this->DrawBinding));
    if (this->Scissor)
    {
      glEnable(GL_SCISSOR_TEST);
    }
  }
  PixelReadState(const PixelReadState&) = delete;
  PixelReadState& operator=(const PixelReadState&) = delete;

  GLuint GetDrawBinding() const { return static_cast<GLuint>(this->DrawBinding); }

private:
  GLboolean Scissor;
  GLint ReadBinding = 0;
  GLint DrawBinding = 0;
  GLint RenderbufferBinding = 0;
  GLint PackBuffer = 0;
  GLint PackAlignment = 4;
};

// The names of the default framebuffer's attachments differ from those of a framebuffer object.
GLint getDepthParameter(GLuint framebuffer, GLenum parameter)
{
  GLint value = 0;
  glGetFramebufferAttachmentParameteriv(
    GL_DRAW_FRAMEBUFFER, framebuffer == 0 ? GL_DEPTH : GL_DEPTH_ATTACHMENT, parameter, &value);
  return value;
}

bool hasStencil(GLuint framebuffer)
{
  const GLenum attachment = framebuffer == 0 ? GL_STENCIL : GL_STENCIL_ATTACHMENT;
  GLint type = GL_NONE;
  glGetFramebufferAttachmentParameteriv(
    GL_DRAW_FRAMEBUFFER, attachment, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE, &type);
  if (type == GL_NONE)
  {
    return false;
  }
  GLint bits = 0;
  glGetFramebufferAttachmentParameteriv(
    GL_DRAW_FRAMEBUFFER, attachment, GL_FRAMEBUFFER_ATTACHMENT_STENCIL_SIZE, &bits);
  return bits > 0;
}

// The format of the bound depth buffer: a blit between different ones is an error.
GLenum getDepthFormat(GLuint framebuffer)
{
  const bool stencil = hasStencil(framebuffer);
  if (getDepthParameter(framebuffer, GL_FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE) == GL_FLOAT)
  {
    return stencil ? GL_DEPTH32F_STENCIL8 : GL_DEPTH_COMPONENT32F;
  }
  if (stencil)
  {
    return GL_DEPTH24_STENCIL8;
  }
  switch (getDepthParameter(framebuffer, GL_FRAMEBUFFER_ATTACHMENT_DEPTH_SIZE))
  {
    case 16:
      return GL_DEPTH_COMPONENT16;
    case 32:
      return GL_DEPTH_COMPONENT32;
    default:
      return GL_DEPTH_COMPONENT24;
  }
}

// A framebuffer with nothing but depth, single-sampled. Lives for one read: next to tracing an image it costs
// nothing, and nothing has to be released when a window goes away.
class ResolvedDepth
{
public:
  ResolvedDepth(GLenum format, int width, int height)
  {
    glGenRenderbuffers(1, &this->Renderbuffer);
    glBindRenderbuffer(GL_RENDERBUFFER, this->Renderbuffer);
    glRenderbufferStorage(GL_RENDERBUFFER, format, width, height);
    glGenFramebuffers(1, &this->Framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, this->Framebuffer); // for reading, too: it has no colours to read
    const bool stencil = format == GL_DEPTH24_STENCIL8 || format == GL_DEPTH32F_STENCIL8;
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, stencil ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT,
      GL_RENDERBUFFER, this->Renderbuffer);
    const GLenum none = GL_NONE;
    glDrawBuffers(1, &none);
    glReadBuffer(GL_NONE);
  }
  ~ResolvedDepth()
  {
    glDeleteFramebuffers(1, &this->Framebuffer);
    glDeleteRenderbuffers(1, &this->Renderbuffer);
  }
  ResolvedDepth(const ResolvedDepth&) = delete;
  ResolvedDepth& operator=(const ResolvedDepth&) = delete;

  GLuint GetFramebuffer() const { return this->Framebuffer; }

private:
  GLuint Framebuffer = 0;
  GLuint Renderbuffer = 0;
};

} // anonymous namespace

//------------------------------------------------------------------------------
void vtkTreeAMRDepthReader::Read(
  vtkRenderer* renderer, const vtkTreeAMRViewport& viewport, std::vector<float>& depth)
{
  vtkTreeAMRTarget::GetWindow(renderer);
  depth.assign(static_cast<std::size_t>(viewport.Width) * viewport.Height, 1.f);

  vtkTreeAMRTarget::DiscardErrors();
  GLenum error = GL_NO_ERROR;
  {
    PixelReadState state;
    const GLuint source = state.GetDrawBinding();
    if (getDepthParameter(source, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE) == GL_NONE)
    {
      return;
    }
    GLint sampleBuffers = 0;
    glGetIntegerv(GL_SAMPLE_BUFFERS, &sampleBuffers);
    int x = viewport.X;
    int y = viewport.Y;
    std::optional<ResolvedDepth> resolved;
    if (sampleBuffers > 0)
    {
      resolved.emplace(getDepthFormat(source), viewport.Width, viewport.Height);
      glBindFramebuffer(GL_READ_FRAMEBUFFER, source);
      glBlitFramebuffer(x, y, x + viewport.Width, y + viewport.Height, 0, 0, viewport.Width, viewport.Height,
        GL_DEPTH_BUFFER_BIT, GL_NEAREST);
      x = y = 0;
    }
    glBindFramebuffer(GL_READ_FRAMEBUFFER, resolved ? resolved->GetFramebuffer() : source);
    glReadPixels(x, y, viewport.Width, viewport.Height, GL_DEPTH_COMPONENT, GL_FLOAT, depth.data());
    error = glGetError();
  }
  if (error != GL_NO_ERROR)
  {
    throw treeamr::Error(
      "framebuffer: OpenGL error " + std::to_string(error) + " while reading the depth buffer");
  }
}
