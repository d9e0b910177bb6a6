// GlFunctions: the OpenGL functions a volume slicer needs, as a table that belongs to one context.
//
// There are no global function pointers: two contexts of two libraries live side by side, each with
// its own table. A member is called like the function without its prefix, gl.TexSubImage3D(...).
// None is ever null: all are of GL 3.3, and each is used (a gate looks). Constants (GL_TEXTURE_3D,
// ...) come from GL/glcorearb.h, which declares no functions here, so that nothing can link to
// libGL by mistake. A file that needs GL/gl.h too (osmesa.h, a toolkit's header) includes it after
// this one.
//
// A table may be used on the thread only on which its context is current.
#pragma once

#include <GL/glcorearb.h>

#include <functional>

namespace sluice {

// Finds a function by its full name ("glClear"); null when there is none.
using GlLoader = std::function<void*(const char*)>;

// X(name, NAME)
#define SLUICE_GL_FUNCTIONS(X)                              \
  /* State and queries */                                   \
  X(GetString, GETSTRING)                                   \
  X(GetStringi, GETSTRINGI)                                 \
  X(GetIntegerv, GETINTEGERV)                               \
  X(GetError, GETERROR)                                     \
  X(Enable, ENABLE)                                         \
  X(Disable, DISABLE)                                       \
  X(IsEnabled, ISENABLED)                                   \
  X(Finish, FINISH)                                         \
  X(Flush, FLUSH)                                           \
  X(FenceSync, FENCESYNC)                                   \
  X(WaitSync, WAITSYNC)                                     \
  X(DeleteSync, DELETESYNC)                                 \
  X(PixelStorei, PIXELSTOREI)                               \
  /* Rasterisation, tests and blending */                   \
  X(Scissor, SCISSOR)                                       \
  X(Viewport, VIEWPORT)                                     \
  X(CullFace, CULLFACE)                                     \
  X(FrontFace, FRONTFACE)                                   \
  X(DepthFunc, DEPTHFUNC)                                   \
  X(DepthMask, DEPTHMASK)                                   \
  X(BlendEquation, BLENDEQUATION)                           \
  X(BlendFunc, BLENDFUNC)                                   \
  /* Clearing, copying and reading back */                  \
  X(Clear, CLEAR)                                           \
  X(ClearColor, CLEARCOLOR)                                 \
  X(ClearDepth, CLEARDEPTH)                                 \
  X(ClearBufferfv, CLEARBUFFERFV)                           \
  X(ReadBuffer, READBUFFER)                                 \
  X(ReadPixels, READPIXELS)                                 \
  X(DrawBuffers, DRAWBUFFERS)                               \
  X(BlitFramebuffer, BLITFRAMEBUFFER)                       \
  X(CopyTexSubImage2D, COPYTEXSUBIMAGE2D)                   \
  /* Textures and samplers */                               \
  X(ActiveTexture, ACTIVETEXTURE)                           \
  X(GenTextures, GENTEXTURES)                               \
  X(DeleteTextures, DELETETEXTURES)                         \
  X(BindTexture, BINDTEXTURE)                               \
  X(TexParameteri, TEXPARAMETERI)                           \
  X(TexImage2D, TEXIMAGE2D)                                 \
  X(TexImage3D, TEXIMAGE3D)                                 \
  X(TexSubImage3D, TEXSUBIMAGE3D)                           \
  X(GetTexImage, GETTEXIMAGE)                               \
  X(TexBuffer, TEXBUFFER)                                   \
  /* Buffers, pixel buffers and uniform buffers included */ \
  X(GenBuffers, GENBUFFERS)                                 \
  X(DeleteBuffers, DELETEBUFFERS)                           \
  X(BindBuffer, BINDBUFFER)                                 \
  X(BufferData, BUFFERDATA)                                 \
  X(GetBufferSubData, GETBUFFERSUBDATA)                     \
  /* Vertex arrays and drawing */                           \
  X(GenVertexArrays, GENVERTEXARRAYS)                       \
  X(DeleteVertexArrays, DELETEVERTEXARRAYS)                 \
  X(BindVertexArray, BINDVERTEXARRAY)                       \
  X(DrawArrays, DRAWARRAYS)                                 \
  X(DrawElementsInstanced, DRAWELEMENTSINSTANCED)           \
  /* Whether anything passed */                             \
  X(GenQueries, GENQUERIES)                                 \
  X(DeleteQueries, DELETEQUERIES)                           \
  X(BeginQuery, BEGINQUERY)                                 \
  X(EndQuery, ENDQUERY)                                     \
  X(GetQueryObjectuiv, GETQUERYOBJECTUIV)                   \
  /* Framebuffers */                                        \
  X(GenFramebuffers, GENFRAMEBUFFERS)                       \
  X(DeleteFramebuffers, DELETEFRAMEBUFFERS)                 \
  X(BindFramebuffer, BINDFRAMEBUFFER)                       \
  X(CheckFramebufferStatus, CHECKFRAMEBUFFERSTATUS)         \
  X(FramebufferTexture2D, FRAMEBUFFERTEXTURE2D)             \
  X(FramebufferRenderbuffer, FRAMEBUFFERRENDERBUFFER)       \
  X(GenRenderbuffers, GENRENDERBUFFERS)                     \
  X(DeleteRenderbuffers, DELETERENDERBUFFERS)               \
  X(BindRenderbuffer, BINDRENDERBUFFER)                     \
  X(RenderbufferStorage, RENDERBUFFERSTORAGE)               \
  /* Shaders, programs and uniforms */                      \
  X(CreateShader, CREATESHADER)                             \
  X(DeleteShader, DELETESHADER)                             \
  X(ShaderSource, SHADERSOURCE)                             \
  X(CompileShader, COMPILESHADER)                           \
  X(GetShaderiv, GETSHADERIV)                               \
  X(GetShaderInfoLog, GETSHADERINFOLOG)                     \
  X(CreateProgram, CREATEPROGRAM)                           \
  X(DeleteProgram, DELETEPROGRAM)                           \
  X(AttachShader, ATTACHSHADER)                             \
  X(LinkProgram, LINKPROGRAM)                               \
  X(UseProgram, USEPROGRAM)                                 \
  X(GetProgramiv, GETPROGRAMIV)                             \
  X(GetProgramInfoLog, GETPROGRAMINFOLOG)                   \
  X(GetUniformLocation, GETUNIFORMLOCATION)                 \
  X(Uniform1i, UNIFORM1I)                                   \
  X(Uniform1f, UNIFORM1F)                                   \
  X(Uniform2f, UNIFORM2F)                                   \
  X(Uniform3f, UNIFORM3F)                                   \
  X(Uniform1fv, UNIFORM1FV)                                 \
  X(Uniform2fv, UNIFORM2FV)                                 \
  X(Uniform3fv, UNIFORM3FV)                                 \
  X(Uniform4fv, UNIFORM4FV)

struct GlFunctions {
#define SLUICE_GL_MEMBER(name, NAME) PFNGL##NAME##PROC name = nullptr;
  SLUICE_GL_FUNCTIONS(SLUICE_GL_MEMBER)
#undef SLUICE_GL_MEMBER
};

// The table of the context that is current. Throws Error when the context is older than 3.3 or
// a function is missing, naming it.
GlFunctions loadGlFunctions(const GlLoader& loader);

}  // namespace sluice
